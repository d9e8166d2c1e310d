//! A query about moving objects, frame by frame: whatever moves, it is placed and asked in the same words.

use crate::workload::{Frame, Header};
use anyhow::{Context, Result, bail, ensure};
use pfront::executor::Plan;
use pfront::threads::Report;
use pfront::{BodyId, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery, TrianglePair};
use pfront_testkit::scenes::Kind;
use std::sync::Arc;

/// The objects of a question: models of any number, which objects may share.
#[derive(Clone, Debug)]
pub struct Objects {
    /// The kind of question.
    pub kind: Kind,
    /// The model of each object.
    pub models: Vec<Arc<Model>>,
}

impl Objects {
    /// Builds the BVH of each mesh of a workload, once.
    ///
    /// # Errors
    /// If a mesh is refused.
    pub fn new(header: Header) -> Result<Self> {
        let models = header.meshes.into_iter().enumerate().map(|(number, mesh)| {
            let model = Model::new(mesh.positions, mesh.triangles);
            model.map(Arc::new).with_context(|| format!("mesh {number}"))
        });
        let models: Vec<Arc<Model>> = models.collect::<Result<_>>()?;
        let models = header.objects.iter().map(|&mesh| models[mesh as usize].clone()).collect();
        Ok(Self { kind: header.kind, models })
    }

    /// Triangles of all objects together.
    pub fn triangles(&self) -> usize {
        self.models.iter().map(|model| model.mesh().triangles().len()).sum()
    }
}

/// Objects, and the query about them.
pub struct Player(Subject);

#[expect(clippy::large_enum_variant, reason = "there is one for a whole run")]
enum Subject {
    Pair {
        models: [Arc<Model>; 2],
        a_from_b: Pose,
        query: PairQuery,
    },
    SelfMesh {
        model: Arc<Model>,
        query: SelfQuery,
    },
    Many {
        query: SceneQuery,
        /// The body of each object, ascending, and the number of its first triangle.
        bodies: Vec<(BodyId, u32)>,
        /// The last answer, with triangles numbered through in the order of the objects.
        pairs: Vec<TrianglePair>,
    },
}

impl Player {
    /// Makes the query.
    ///
    /// # Errors
    /// If there are more triangles than u32 can number, or a scene refuses a body.
    pub fn new(objects: Objects, executor: &Executor) -> Result<Self> {
        let Objects { kind, mut models } = objects;
        Ok(Self(match (kind, &models[..]) {
            (Kind::Pair, [a, b]) => Subject::Pair {
                models: [a.clone(), b.clone()],
                a_from_b: Pose::IDENTITY,
                query: PairQuery::new().on(executor),
            },
            (Kind::SelfMesh, [_]) => {
                let query = SelfQuery::new().on(executor);
                Subject::SelfMesh { model: models.remove(0), query }
            }
            _ => {
                let mut query = SceneQuery::new().on(executor);
                let (mut bodies, mut first) = (Vec::new(), 0_u32);
                for model in models {
                    let triangles = u32::try_from(model.mesh().triangles().len())?;
                    bodies.push((query.add(model, Pose::IDENTITY)?, first));
                    let next = first.checked_add(triangles);
                    first = next.context("more triangles than u32 can number")?;
                }
                Subject::Many { query, bodies, pairs: Vec::new() }
            }
        }))
    }

    /// Moves everything to where it is in a frame.
    ///
    /// # Errors
    /// If a shape or pose is refused, or the frame is of another kind.
    pub fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        match (&mut self.0, frame) {
            (Subject::SelfMesh { model, query }, Frame::Positions(positions)) => {
                query.set_positions(Arc::make_mut(model), positions)?;
                Ok(())
            }
            (Subject::Pair { a_from_b, .. }, Frame::Poses(&[a, b])) => {
                ensure!(a == Pose::IDENTITY, "the first object of a pair stays where it is");
                *a_from_b = b;
                Ok(())
            }
            (Subject::Many { query, bodies, .. }, Frame::Poses(poses)) => {
                ensure!(poses.len() == bodies.len(), "a frame of {} objects", poses.len());
                let mut placed = bodies.iter().zip(poses);
                Ok(placed.try_for_each(|((body, _), &pose)| query.set_pose(*body, pose))?)
            }
            _ => bail!("the frame is of another kind than the objects"),
        }
    }

    /// All pairs, sorted, numbered as in a pair file.
    ///
    /// # Errors
    /// Fails as the query does; so do the other verbs.
    pub fn all(&mut self) -> Result<&[TrianglePair]> {
        match &mut self.0 {
            Subject::Pair { models: [a, b], a_from_b, query } => Ok(query.all(a, b, *a_from_b)?),
            Subject::SelfMesh { model, query } => Ok(query.all(model)?),
            Subject::Many { query, bodies, pairs } => {
                let first = |body| bodies[bodies.partition_point(|&(id, _)| id < body)].1;
                pairs.clear();
                pairs.extend(query.all()?.iter().map(|hit| {
                    let [a, b] = hit.bodies.map(first);
                    TrianglePair { a: a + hit.pair.a, b: b + hit.pair.b }
                }));
                // They came by bodies first.
                pairs.sort_unstable();
                Ok(pairs)
            }
        }
    }

    /// Finds all pairs as the query gives them, and returns how many there are.
    ///
    /// # Errors
    /// As [`Player::all`].
    pub fn find(&mut self) -> Result<usize> {
        match &mut self.0 {
            Subject::Many { query, .. } => Ok(query.all()?.len()),
            _ => Ok(self.all()?.len()),
        }
    }

    /// Whether any pair meets.
    ///
    /// # Errors
    /// As [`Player::all`].
    pub fn any(&mut self) -> Result<bool> {
        Ok(match &mut self.0 {
            Subject::Pair { models: [a, b], a_from_b, query } => {
                query.any(a, b, *a_from_b)?.is_some()
            }
            Subject::SelfMesh { model, query } => query.any(model)?.is_some(),
            Subject::Many { query, .. } => query.any()?.is_some(),
        })
    }

    /// How many pairs meet.
    ///
    /// # Errors
    /// As [`Player::all`].
    pub fn count(&mut self) -> Result<u64> {
        Ok(match &mut self.0 {
            Subject::Pair { models: [a, b], a_from_b, query } => query.count(a, b, *a_from_b)?,
            Subject::SelfMesh { model, query } => query.count(model)?,
            Subject::Many { query, .. } => query.count()?,
        })
    }

    /// The backend of the last frame, and why it was chosen.
    pub fn plan(&self) -> Option<&Plan> {
        match &self.0 {
            Subject::Pair { query, .. } => query.plan(),
            Subject::SelfMesh { query, .. } => query.plan(),
            Subject::Many { query, .. } => query.plan(),
        }
    }

    /// The report of the last frame on threads.
    pub fn report(&self) -> Option<&Report> {
        match &self.0 {
            Subject::Pair { query, .. } => query.report(),
            Subject::SelfMesh { query, .. } => query.report(),
            Subject::Many { query, .. } => query.report(),
        }
    }
}
