//! The bodies of a scene, in the order in which they were added.

use super::Shape;
use crate::Error;
use pfront_core::bvtt::PosedBvh;
use pfront_core::{Aabb, Pose};
use std::fmt;
use std::sync::Arc;

/// Names a body of one scene for good: no id is ever used again. Ids ascend in the order of adding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(u64);

impl fmt::Display for BodyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {}", self.0)
    }
}

/// A shape and where it is.
#[derive(Clone, Debug)]
pub struct Body {
    id: BodyId,
    shape: Arc<Shape>,
    pose: Pose,
    aabb: Option<Aabb>,
}

impl Body {
    /// The id.
    #[must_use]
    pub fn id(&self) -> BodyId {
        self.id
    }

    /// The shape, in its own frame.
    #[must_use]
    pub fn shape(&self) -> &Arc<Shape> {
        &self.shape
    }

    /// The pose `world_from_body`.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// A box in the world that contains every posed vertex, rounding included; `None` if there is no
    /// triangle.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        self.aabb
    }

    pub(super) fn set_pose(&mut self, pose: Pose) -> Result<(), Error> {
        let aabb = PosedBvh::new(self.shape.bvh(), &pose)?.aabb();
        (self.pose, self.aabb) = (pose, aabb);
        Ok(())
    }

    pub(super) fn set_positions(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        self.shape.mesh().with_positions(positions)?;
        let bounds = Aabb::of(positions);
        if self.pose != Pose::IDENTITY {
            self.pose.check(&bounds)?;
        }
        Arc::make_mut(&mut self.shape).set_positions(positions, &bounds);
        self.set_pose(self.pose)
    }
}

/// Bodies by ascending id.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    list: Vec<Body>,
    next: u64,
}

impl Bodies {
    pub(super) fn iter(&self) -> std::slice::Iter<'_, Body> {
        self.list.iter()
    }

    /// By place in the order.
    pub(super) fn at(&self, place: u32) -> &Body {
        &self.list[place as usize]
    }

    /// Bodies that have a triangle, with their boxes.
    pub(super) fn solid(&self) -> impl Iterator<Item = (&Body, Aabb)> {
        self.list.iter().filter_map(|body| Some((body, body.aabb?)))
    }

    pub(super) fn add(&mut self, shape: Arc<Shape>, pose: Pose) -> Result<BodyId, Error> {
        let id = BodyId(self.next);
        let mut body = Body { id, shape, pose, aabb: None };
        body.set_pose(pose)?;
        self.list.push(body);
        self.next += 1;
        Ok(id)
    }

    pub(super) fn get(&self, id: BodyId) -> Result<&Body, Error> {
        self.place(id).map(|place| &self.list[place])
    }

    pub(super) fn get_mut(&mut self, id: BodyId) -> Result<&mut Body, Error> {
        self.place(id).map(|place| &mut self.list[place])
    }

    pub(super) fn remove(&mut self, id: BodyId) -> Result<Body, Error> {
        self.place(id).map(|place| self.list.remove(place))
    }

    fn place(&self, id: BodyId) -> Result<usize, Error> {
        self.list.binary_search_by_key(&id, Body::id).map_err(|_| Error::StaleBody { id })
    }
}
