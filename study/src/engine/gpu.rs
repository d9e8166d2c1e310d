//! Engines on a GPU.

use super::numbers::Numbers;
use super::{Engine, EngineError, Objects, OnGpu, second};
use pfront::gpu::{BodyId, Deforming, Gpu, Model, PairQuery, Report, SceneQuery, SelfQuery};
use pfront::gpu::{Settings, Shape, Timing};
use pfront::{Adjacency, Pose, TrianglePair};
use pfront_scenes::Kind;
use std::sync::Arc;

/// Uploads each model once.
pub(super) fn engine(
    objects: &Objects,
    adjacency: Adjacency,
    on: &OnGpu,
) -> Result<Box<dyn Engine>, EngineError> {
    let OnGpu { gpu, settings, timed } = on;
    match (objects.kind, &objects.models[..]) {
        (Kind::Pair, [a, b]) => {
            let first = Arc::new(Model::new(gpu, a.bvh())?);
            let second = match Arc::ptr_eq(a, b) {
                true => first.clone(),
                false => Arc::new(Model::new(gpu, b.bvh())?),
            };
            let query = pair_query(gpu, *settings, *timed)?;
            Ok(Box::new(Pair { models: [first, second], a_from_b: Pose::IDENTITY, query }))
        }
        (Kind::SelfMesh, [model]) => {
            let model = Deforming::new(gpu, model.bvh())?;
            let model = if *timed { model.with_timings()? } else { model };
            let query = self_query(gpu, *settings, *timed)?.with_adjacency(adjacency);
            Ok(Box::new(Within { model, moved: false, query }))
        }
        (_, models) => {
            let query = SceneQuery::with_settings(gpu, *settings)?;
            let query = if *timed { query.with_timings()? } else { query };
            Ok(Box::new(Many::new(models, query)?))
        }
    }
}

fn pair_query(gpu: &Gpu, settings: Settings, timed: bool) -> Result<PairQuery, EngineError> {
    let query = PairQuery::with_settings(gpu, settings)?;
    Ok(if timed { query.with_timings()? } else { query })
}

fn self_query(gpu: &Gpu, settings: Settings, timed: bool) -> Result<SelfQuery, EngineError> {
    let query = SelfQuery::with_settings(gpu, settings)?;
    Ok(if timed { query.with_timings()? } else { query })
}

struct Pair {
    models: [Arc<Model>; 2],
    a_from_b: Pose,
    query: PairQuery,
}

impl Engine for Pair {
    fn place(&mut self, object: usize, world_from_object: Pose) -> Result<(), EngineError> {
        second(object, world_from_object, &mut self.a_from_b)
    }

    fn all(&mut self) -> Result<&[TrianglePair], EngineError> {
        let [a, b] = &self.models;
        Ok(self.query.all(a, b, &self.a_from_b)?)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError> {
        let [a, b] = &self.models;
        Ok(self.query.any(a, b, &self.a_from_b)?)
    }

    fn count(&mut self) -> Result<u64, EngineError> {
        let [a, b] = &self.models;
        Ok(self.query.count(a, b, &self.a_from_b)?)
    }

    fn gpu_report(&self) -> Option<Report> {
        Some(self.query.report())
    }

    fn device_bytes(&self) -> u64 {
        let [a, b] = &self.models;
        a.bytes() + if Arc::ptr_eq(a, b) { 0 } else { b.bytes() }
    }

    fn timings(&self) -> Result<Vec<Timing>, EngineError> {
        Ok(self.query.timings()?)
    }
}

struct Within {
    model: Deforming,
    /// Whether there has been a refit, which may be timed.
    moved: bool,
    query: SelfQuery,
}

impl Engine for Within {
    fn place(&mut self, _object: usize, _world_from_object: Pose) -> Result<(), EngineError> {
        Err(EngineError::Unmovable { what: "a mesh as a whole that is asked about itself" })
    }

    fn deform(&mut self, positions: &[[f32; 3]]) -> Result<(), EngineError> {
        self.model.set_positions(positions)?;
        self.moved = true;
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair], EngineError> {
        Ok(self.query.all(&self.model)?)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError> {
        Ok(self.query.any(&self.model)?)
    }

    fn count(&mut self) -> Result<u64, EngineError> {
        Ok(self.query.count(&self.model)?)
    }

    fn gpu_report(&self) -> Option<Report> {
        Some(self.query.report())
    }

    fn device_bytes(&self) -> u64 {
        self.model.bytes()
    }

    fn timings(&self) -> Result<Vec<Timing>, EngineError> {
        let mut timings = if self.moved { self.model.timings()? } else { Vec::new() };
        timings.extend(self.query.timings()?);
        Ok(timings)
    }
}

struct Many {
    query: SceneQuery,
    numbers: Numbers<BodyId>,
    pairs: Vec<TrianglePair>,
}

impl Many {
    fn new(objects: &[Arc<pfront::Model>], mut query: SceneQuery) -> Result<Self, EngineError> {
        let (mut numbers, mut shapes) = (Numbers::new(), Vec::new());
        for model in objects {
            // Objects of one model share a shape.
            let known = shapes.iter().find(|(own, _)| Arc::ptr_eq(own, model));
            let shape = match known {
                Some((_, shape)) => Arc::clone(shape),
                None => {
                    let shape = Arc::new(Shape::new(model.bvh()));
                    shapes.push((model.clone(), shape.clone()));
                    shape
                }
            };
            numbers.add(query.add(shape, Pose::IDENTITY)?, model.mesh().triangles().len())?;
        }
        Ok(Self { query, numbers, pairs: Vec::new() })
    }
}

impl Engine for Many {
    fn place(&mut self, object: usize, world_from_object: Pose) -> Result<(), EngineError> {
        Ok(self.query.set_pose(self.numbers.body(object)?, world_from_object)?)
    }

    fn all(&mut self) -> Result<&[TrianglePair], EngineError> {
        let Self { query, numbers, pairs } = self;
        pairs.clear();
        pairs.extend(query.all()?.iter().map(|hit| numbers.pair(hit.bodies, hit.pair)));
        // They came by bodies first.
        pairs.sort();
        Ok(pairs)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError> {
        Ok(self.query.any()?.map(|hit| self.numbers.pair(hit.bodies, hit.pair)))
    }

    fn count(&mut self) -> Result<u64, EngineError> {
        Ok(self.query.count()?)
    }

    fn find(&mut self) -> Result<usize, EngineError> {
        Ok(self.query.all()?.len())
    }

    fn gpu_report(&self) -> Option<Report> {
        Some(self.query.report())
    }

    fn device_bytes(&self) -> u64 {
        self.query.bytes()
    }

    fn timings(&self) -> Result<Vec<Timing>, EngineError> {
        Ok(self.query.timings()?)
    }
}
