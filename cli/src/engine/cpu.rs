//! Engines on the CPU.

use super::numbers::Numbers;
use super::{Asked, Engine, Objects, On};
use anyhow::Result;
use pfront::core::query;
use pfront::threads::{Reference, Report, Settings, Traversal};
use pfront::{BodyId, Model, PairQuery, Pose, SceneQuery, SelfQuery, TrianglePair};
use pfront_cli::workload::Frame;
use pfront_scenes::Kind;
use std::sync::Arc;

pub(super) fn engine(objects: Objects, asked: Asked) -> Result<Box<dyn Engine>> {
    let Objects { kind, mut models } = objects;
    Ok(match (kind, &models[..]) {
        (Kind::Pair, [a, b]) => Box::new(Pair {
            models: [a.clone(), b.clone()],
            a_from_b: Pose::IDENTITY,
            query: asked.pair_query(),
        }),
        (Kind::SelfMesh, [_]) => {
            Box::new(Within { model: models.remove(0), query: asked.self_query() })
        }
        _ => Box::new(Many::new(models, asked.scene_query())?),
    })
}

impl Asked {
    fn traversal(self) -> Option<Traversal> {
        match self.on {
            On::Cpu(traversal) => traversal.map(|traversal| *traversal),
            On::Gpu(_) => None,
        }
    }

    pub(crate) fn pair_query(self) -> PairQuery {
        let query = PairQuery::new().with_accuracy(self.accuracy);
        match self.traversal() {
            Some(traversal) => query.with_traversal(traversal),
            None => query,
        }
    }

    fn self_query(self) -> SelfQuery {
        let query = SelfQuery::new().with_accuracy(self.accuracy).with_adjacency(self.adjacency);
        match self.traversal() {
            Some(traversal) => query.with_traversal(traversal),
            None => query,
        }
    }

    fn scene_query(self) -> SceneQuery {
        let query = SceneQuery::new().with_accuracy(self.accuracy);
        match self.traversal() {
            Some(traversal) => query.with_traversal(traversal),
            None => query,
        }
    }
}

/// To within 2 %, which is nearer than estimates come.
fn reference(query: &impl query::Query, workers: usize) -> Reference {
    Reference::of(query, workers, 0.02, &Settings::default())
}

struct Pair {
    models: [Arc<Model>; 2],
    a_from_b: Pose,
    query: PairQuery,
}

impl Engine for Pair {
    fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Frame::Poses(&[_, a_from_b]) = frame {
            self.a_from_b = a_from_b;
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair]> {
        let [a, b] = &self.models;
        Ok(self.query.all(a, b, &self.a_from_b)?)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>> {
        let [a, b] = &self.models;
        Ok(self.query.any(a, b, &self.a_from_b)?)
    }

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }

    fn reference(&self, workers: usize) -> Result<Option<Reference>> {
        let [a, b] = &self.models;
        let query = query::PairQuery::new(a.bvh(), b.bvh(), self.a_from_b)?;
        Ok(Some(reference(&query, workers)))
    }
}

struct Within {
    model: Arc<Model>,
    query: SelfQuery,
}

impl Engine for Within {
    fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Frame::Positions(positions) = frame {
            Arc::make_mut(&mut self.model).set_positions(positions)?;
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair]> {
        Ok(self.query.all(&self.model))
    }

    fn any(&mut self) -> Result<Option<TrianglePair>> {
        Ok(self.query.any(&self.model))
    }

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }

    fn reference(&self, workers: usize) -> Result<Option<Reference>> {
        Ok(Some(reference(&query::SelfQuery::new(self.model.bvh()), workers)))
    }
}

struct Many {
    query: SceneQuery,
    numbers: Numbers<BodyId>,
    pairs: Vec<TrianglePair>,
}

impl Many {
    fn new(objects: Vec<Arc<Model>>, mut query: SceneQuery) -> Result<Self> {
        let mut numbers = Numbers::new();
        for model in objects {
            let triangles = model.mesh().triangles().len();
            numbers.add(query.add(model, Pose::IDENTITY)?, triangles)?;
        }
        Ok(Self { query, numbers, pairs: Vec::new() })
    }
}

impl Engine for Many {
    fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Frame::Poses(poses) = frame {
            for (body, &pose) in self.numbers.bodies().zip(poses) {
                self.query.set_pose(body, pose)?;
            }
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair]> {
        let Self { query, numbers, pairs } = self;
        pairs.clear();
        pairs.extend(query.all()?.iter().map(|hit| numbers.pair(hit.bodies, hit.pair)));
        // They came by bodies first.
        pairs.sort_unstable();
        Ok(pairs)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>> {
        Ok(self.query.any()?.map(|hit| self.numbers.pair(hit.bodies, hit.pair)))
    }

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }
}
