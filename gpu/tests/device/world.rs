//! Many bodies, on the device and as the core has them.

use crate::common::{Both, sorted};
use pfront_core::Pose;
use pfront_core::bvtt::{PairQuery, PosedBvh};
use pfront_gpu::{BodyId, Error, SceneHit, SceneQuery, Shape};
use pfront_testkit::shapes::Soup;
use std::sync::Arc;

/// Bodies on the device, and what they are made of beside it.
pub(crate) struct World<'m> {
    pub(crate) query: SceneQuery,
    pub(crate) bodies: Vec<(BodyId, &'m Part)>,
}

/// A mesh as the core has it, and as a scene does.
pub(crate) struct Part {
    pub(crate) both: Both,
    pub(crate) shape: Arc<Shape>,
}

impl Part {
    pub(crate) fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]], leaf_size: u32) -> Self {
        let both = Both::new(positions, triangles, leaf_size);
        let shape = Arc::new(Shape::new(both.bvh()));
        Self { both, shape }
    }

    pub(crate) fn of(soup: &Soup) -> Self {
        Self::new(&soup.positions, &soup.triangles, 4)
    }
}

impl<'m> World<'m> {
    pub(crate) fn new(query: SceneQuery) -> Self {
        Self { query, bodies: Vec::new() }
    }

    pub(crate) fn add(&mut self, part: &'m Part, pose: Pose) -> BodyId {
        let id = self.query.add(part.shape.clone(), pose).unwrap();
        self.bodies.push((id, part));
        id
    }

    pub(crate) fn remove(&mut self, index: usize) {
        let (id, _) = self.bodies.remove(index);
        assert_eq!(self.query.remove(id).unwrap().id(), id);
        assert_eq!(self.query.remove(id).unwrap_err(), Error::StaleBody { id });
        assert_eq!(self.query.body(id).unwrap_err(), Error::StaleBody { id });
    }

    pub(crate) fn set_pose(&mut self, index: usize, pose: Pose) {
        self.query.set_pose(self.bodies[index].0, pose).unwrap();
    }

    pub(crate) fn truth(&self) -> Vec<SceneHit> {
        let placed = |&(id, part): &(BodyId, &'m Part)| {
            PosedBvh::new(part.both.bvh(), &self.query.body(id).unwrap().pose()).unwrap()
        };
        let mut hits = Vec::new();
        for (i, a) in self.bodies.iter().enumerate() {
            for b in &self.bodies[i + 1..] {
                let pairs = sorted(&PairQuery::in_world(placed(a), placed(b)));
                hits.extend(pairs.iter().map(|&pair| SceneHit { bodies: [a.0, b.0], pair }));
            }
        }
        hits
    }

    /// Checks every verb and returns how many pairs meet.
    pub(crate) fn check(&mut self) -> usize {
        let truth = self.truth();
        assert_eq!(self.query.len(), self.bodies.len());
        assert!(self.query.all().unwrap() == truth, "{} pairs", truth.len());
        assert_eq!(self.query.count().unwrap(), truth.len() as u64);
        let any = self.query.any().unwrap();
        assert!(any.map_or(truth.is_empty(), |hit| truth.binary_search(&hit).is_ok()));
        truth.len()
    }
}
