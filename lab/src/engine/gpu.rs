//! Engines on a GPU.

use super::numbers::Numbers;
use super::{Engine, EngineError, Objects, OnGpu, second};
use pfront::core::bvtt::PosedBvh;
use pfront::gpu::{
    Bodies, Deforming, Gpu, GpuModel, GpuPairQuery, GpuReport, GpuSelfQuery, GpuSettings,
};
use pfront::gpu::{Timing, World};
use pfront::{Aabb, Adjacency, Bvh, Pose, Stamp, TrianglePair};
use pfront_testkit::scenes::Kind;
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
            let first = Arc::new(GpuModel::new(gpu, a.bvh())?);
            let second = match Arc::ptr_eq(a, b) {
                true => first.clone(),
                false => Arc::new(GpuModel::new(gpu, b.bvh())?),
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
            let world = World::new(gpu, *settings)?;
            let world = if *timed { world.with_timings()? } else { world };
            Ok(Box::new(Many::new(models, world)?))
        }
    }
}

fn pair_query(gpu: &Gpu, settings: GpuSettings, timed: bool) -> Result<GpuPairQuery, EngineError> {
    let query = GpuPairQuery::with_settings(gpu, settings)?;
    Ok(if timed { query.with_timings()? } else { query })
}

fn self_query(gpu: &Gpu, settings: GpuSettings, timed: bool) -> Result<GpuSelfQuery, EngineError> {
    let query = GpuSelfQuery::with_settings(gpu, settings)?;
    Ok(if timed { query.with_timings()? } else { query })
}

struct Pair {
    models: [Arc<GpuModel>; 2],
    a_from_b: Pose,
    query: GpuPairQuery,
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

    fn gpu_report(&self) -> Option<GpuReport> {
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
    query: GpuSelfQuery,
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

    fn gpu_report(&self) -> Option<GpuReport> {
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

/// Objects by their numbers.
struct Many {
    world: World,
    models: Vec<Arc<pfront::Model>>,
    boxes: Vec<Option<Aabb>>,
    /// Objects whose boxes overlap; empty after a move.
    near: Vec<Bodies>,
    numbers: Numbers<u32>,
    pairs: Vec<TrianglePair>,
}

impl Many {
    fn new(models: &[Arc<pfront::Model>], mut world: World) -> Result<Self, EngineError> {
        let bvhs: Vec<_> = models.iter().map(|model| model.bvh()).collect();
        let mut meshes: Vec<(Stamp, u32)> = Vec::new();
        let mut bodies = Vec::new();
        for model in models {
            let known = meshes.iter().find(|(stamp, _)| *stamp == model.stamp());
            let mesh = match known {
                Some(&(_, mesh)) => mesh,
                None => {
                    let mesh = world.add_mesh(model.bvh())?;
                    meshes.push((model.stamp(), mesh));
                    mesh
                }
            };
            bodies.push((mesh, Pose::IDENTITY));
        }
        world.set_bodies(&bodies)?;
        let mut numbers = Numbers::new();
        for (model, number) in models.iter().zip(0..) {
            numbers.add(number, model.mesh().triangles().len())?;
        }
        let boxes = bvhs.iter().map(Bvh::aabb).collect();
        let models = models.to_vec();
        Ok(Self { world, models, boxes, near: Vec::new(), numbers, pairs: Vec::new() })
    }

    /// The world, and each two objects whose boxes overlap.
    fn near(&mut self) -> (&mut World, &[Bodies]) {
        if self.near.is_empty() {
            let numbers = 0..self.boxes.len() as u32;
            let two = numbers
                .clone()
                .flat_map(|a| numbers.clone().skip(a as usize + 1).map(move |b| [a, b]));
            let meet = |two: &Bodies| match two.map(|i| self.boxes[i as usize]) {
                [Some(a), Some(b)] => a.overlaps(&b),
                _ => false,
            };
            self.near = two.filter(meet).collect();
        }
        (&mut self.world, &self.near)
    }
}

impl Engine for Many {
    fn place(&mut self, object: usize, world_from_object: Pose) -> Result<(), EngineError> {
        let (number, bvh) = (self.numbers.body(object)?, self.models[object].bvh());
        self.world.set_pose(number, world_from_object)?;
        let posed = PosedBvh::new(bvh, &world_from_object).map_err(pfront::Error::from)?;
        self.boxes[object] = posed.aabb();
        self.near.clear();
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair], EngineError> {
        self.near();
        let Self { world, near, numbers, pairs, .. } = self;
        pairs.clear();
        pairs.extend(world.all(near)?.iter().map(|&(bodies, pair)| numbers.pair(bodies, pair)));
        // They came by bodies first.
        pairs.sort();
        Ok(pairs)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError> {
        let (world, near) = self.near();
        let hit = world.any(near)?;
        Ok(hit.map(|(bodies, pair)| self.numbers.pair(bodies, pair)))
    }

    fn count(&mut self) -> Result<u64, EngineError> {
        let (world, near) = self.near();
        Ok(world.count(near)?)
    }

    fn find(&mut self) -> Result<usize, EngineError> {
        let (world, near) = self.near();
        Ok(world.all(near)?.len())
    }

    fn gpu_report(&self) -> Option<GpuReport> {
        Some(self.world.report())
    }

    fn device_bytes(&self) -> u64 {
        self.world.bytes()
    }

    fn timings(&self) -> Result<Vec<Timing>, EngineError> {
        Ok(self.world.timings()?)
    }
}
