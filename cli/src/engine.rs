//! What a workload asks, frame by frame.

use anyhow::{Context, Result, ensure};
use pfront::core::query;
use pfront::threads::{Reference, Report, Settings, Traversal};
use pfront::{Accuracy, BodyId, Model, PairQuery, Pose, SceneQuery, SelfQuery, TrianglePair};
use pfront_cli::workload::{Frame, Header};
use pfront_scenes::Kind;
use std::sync::Arc;

/// Models and the query over them.
pub(crate) trait Engine {
    /// Moves everything to where it is in a frame.
    fn update(&mut self, frame: Frame<'_>) -> Result<()>;
    /// All pairs, sorted, numbered as in a pair file.
    fn all(&mut self) -> Result<&[TrianglePair]>;
    /// Whether anything meets.
    fn any(&mut self) -> Result<bool>;
    /// What the last frame on threads did.
    fn report(&self) -> Option<&Report>;
    /// Algorithm 1 for this frame; only of two objects or one.
    fn reference(&self, workers: usize) -> Result<Option<Reference>>;
}

/// How exactly, and by which threads; none is the calling one.
pub(crate) struct Asked {
    pub(crate) accuracy: Accuracy,
    pub(crate) traversal: Option<Traversal>,
}

/// Builds each mesh's BVH, once.
///
/// # Errors
/// If a mesh is none, or there are more triangles than u32 can number.
pub(crate) fn engine(header: Header, asked: Asked) -> Result<Box<dyn Engine>> {
    let models = header.meshes.into_iter().zip(0..).map(|(mesh, number)| {
        let model = Model::new(mesh.positions, mesh.triangles);
        model.map(Arc::new).with_context(|| format!("mesh {number}"))
    });
    let models: Vec<Arc<Model>> = models.collect::<Result<_>>()?;
    let mut objects: Vec<_> = header.objects.iter().map(|&m| models[m as usize].clone()).collect();
    drop(models);
    Ok(match (header.kind, &objects[..]) {
        (Kind::Pair, [a, b]) => Box::new(Pair {
            models: [a.clone(), b.clone()],
            a_from_b: Pose::IDENTITY,
            query: asked.pair_query(),
        }),
        (Kind::SelfMesh, [_]) => {
            Box::new(Within { model: objects.remove(0), query: asked.self_query() })
        }
        _ => Box::new(Many::new(objects, asked.scene_query())?),
    })
}

impl Asked {
    pub(crate) fn pair_query(self) -> PairQuery {
        let query = PairQuery::new().with_accuracy(self.accuracy);
        match self.traversal {
            Some(traversal) => query.with_traversal(traversal),
            None => query,
        }
    }

    pub(crate) fn self_query(self) -> SelfQuery {
        let query = SelfQuery::new().with_accuracy(self.accuracy);
        match self.traversal {
            Some(traversal) => query.with_traversal(traversal),
            None => query,
        }
    }

    fn scene_query(self) -> SceneQuery {
        let query = SceneQuery::new().with_accuracy(self.accuracy);
        match self.traversal {
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

    fn any(&mut self) -> Result<bool> {
        let [a, b] = &self.models;
        Ok(self.query.any(a, b, &self.a_from_b)?.is_some())
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

    fn any(&mut self) -> Result<bool> {
        Ok(self.query.any(&self.model).is_some())
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
    /// Each object's body, ascending, and the number of its first triangle.
    bodies: Vec<(BodyId, u32)>,
    pairs: Vec<TrianglePair>,
}

impl Many {
    fn new(objects: Vec<Arc<Model>>, mut query: SceneQuery) -> Result<Self> {
        let (mut bodies, mut first) = (Vec::new(), 0_usize);
        for model in objects {
            let triangles = model.mesh().triangles().len();
            let number = u32::try_from(first);
            bodies.push((query.add(model, Pose::IDENTITY)?, number.unwrap_or(u32::MAX)));
            first += triangles;
            ensure!(u32::try_from(first).is_ok(), "more triangles than u32 can number");
        }
        Ok(Self { query, bodies, pairs: Vec::new() })
    }
}

impl Engine for Many {
    fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Frame::Poses(poses) = frame {
            for (&(body, _), &pose) in self.bodies.iter().zip(poses) {
                self.query.set_pose(body, pose)?;
            }
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair]> {
        let Self { query, bodies, pairs } = self;
        let number = |body: BodyId, triangle: u32| {
            let object = bodies.partition_point(|&(id, _)| id < body);
            bodies[object].1 + triangle
        };
        pairs.clear();
        pairs.extend(query.all()?.iter().map(|hit| {
            let [a, b] = hit.bodies;
            TrianglePair { a: number(a, hit.pair.a), b: number(b, hit.pair.b) }
        }));
        // They came by bodies first.
        pairs.sort_unstable();
        Ok(pairs)
    }

    fn any(&mut self) -> Result<bool> {
        Ok(self.query.any()?.is_some())
    }

    fn report(&self) -> Option<&Report> {
        self.query.report()
    }

    fn reference(&self, _: usize) -> Result<Option<Reference>> {
        Ok(None)
    }
}
