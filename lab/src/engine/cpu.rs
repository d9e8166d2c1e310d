//! Engines over the queries of the root crate.

use super::numbers::Numbers;
use super::{Engine, EngineError, Objects, second};
use crate::stability::Reference;
use pfront::core::bvtt;
use pfront::executor::Plan;
use pfront::threads::Report;
use pfront::{
    Accuracy, Adjacency, BodyId, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery,
    TrianglePair,
};
use pfront_testkit::scenes::Kind;
use std::sync::Arc;

pub(super) fn engine(
    objects: Objects,
    accuracy: Accuracy,
    adjacency: Adjacency,
    executor: &Executor,
) -> Result<Box<dyn Engine>, EngineError> {
    let Objects { kind, mut models } = objects;
    Ok(match (kind, &models[..]) {
        (Kind::Pair, [a, b]) => {
            let query = PairQuery::new().with_accuracy(accuracy);
            Box::new(Pair {
                models: [a.clone(), b.clone()],
                a_from_b: Pose::IDENTITY,
                query: query.on(executor),
            })
        }
        (Kind::SelfMesh, [_]) => {
            let query = SelfQuery::new().with_accuracy(accuracy).with_adjacency(adjacency);
            Box::new(Within { model: models.remove(0), query: query.on(executor) })
        }
        _ => {
            let query = SceneQuery::new().with_accuracy(accuracy);
            Box::new(Many::new(models, query.on(executor))?)
        }
    })
}

/// To within 2 %, which is nearer than estimates come.
fn reference(query: &impl bvtt::Query, workers: usize) -> Reference {
    Reference::of(query, workers, 0.02)
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

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }

    fn plan(&self) -> Option<&Plan> {
        self.query.plan()
    }

    fn reference(&self, workers: usize) -> Result<Option<Reference>, EngineError> {
        let [a, b] = &self.models;
        let query =
            bvtt::PairBvtt::new(a.bvh(), b.bvh(), self.a_from_b).map_err(pfront::Error::from)?;
        Ok(Some(reference(&query, workers)))
    }
}

struct Within {
    model: Arc<Model>,
    query: SelfQuery,
}

impl Engine for Within {
    fn place(&mut self, _object: usize, _world_from_object: Pose) -> Result<(), EngineError> {
        Err(EngineError::Unmovable { what: "a mesh as a whole that is asked about itself" })
    }

    fn deform(&mut self, positions: &[[f32; 3]]) -> Result<(), EngineError> {
        Ok(self.query.set_positions(Arc::make_mut(&mut self.model), positions)?)
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

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }

    fn plan(&self) -> Option<&Plan> {
        self.query.plan()
    }

    fn reference(&self, workers: usize) -> Result<Option<Reference>, EngineError> {
        Ok(Some(reference(&bvtt::SelfBvtt::new(self.model.bvh()), workers)))
    }
}

struct Many {
    query: SceneQuery,
    numbers: Numbers<BodyId>,
    pairs: Vec<TrianglePair>,
}

impl Many {
    fn new(objects: Vec<Arc<Model>>, mut query: SceneQuery) -> Result<Self, EngineError> {
        let mut numbers = Numbers::new();
        for model in objects {
            let triangles = model.mesh().triangles().len();
            numbers.add(query.add(model, Pose::IDENTITY)?, triangles)?;
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
        pairs.sort_unstable();
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

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }

    fn plan(&self) -> Option<&Plan> {
        self.query.plan()
    }
}
