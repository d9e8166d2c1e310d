//! The bodies of a scene, in the order in which they were added.

use crate::{Aabb, Error, Model, Pose};
use pfront_core::query::Placed;
use pfront_core::sphere::Sphere;
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

/// A model and where it is.
#[derive(Clone, Debug)]
pub struct Body {
    id: BodyId,
    pub(super) model: Arc<Model>,
    pose: Pose,
    bounds: Option<(Aabb, Sphere)>,
}

impl Body {
    /// The id.
    #[must_use]
    pub fn id(&self) -> BodyId {
        self.id
    }

    /// The model, in its own frame.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
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
        Some(self.bounds?.0)
    }

    /// That box and a sphere of which the same is true.
    pub(super) fn bounds(&self) -> Option<(Aabb, Sphere)> {
        self.bounds
    }

    pub(super) fn set_pose(&mut self, pose: Pose) -> Result<(), Error> {
        Placed::new(self.model.bvh(), &pose)?;
        self.pose = pose;
        self.reshaped();
        Ok(())
    }

    /// To be called when the shape has changed, within what the pose can take.
    pub(super) fn reshaped(&mut self) {
        let aabb = self.placed().aabb();
        self.bounds = aabb.and_then(|aabb| Some((aabb, self.model.sphere()?.posed(&self.pose))));
    }

    pub(super) fn placed(&self) -> Placed<'_> {
        Placed::trusted(self.model.bvh(), &self.pose)
    }
}

/// Bodies by ascending id. What is removed leaves a gap until the next frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    entries: Vec<(BodyId, Option<Body>)>,
    live: usize,
    next: u64,
}

impl Bodies {
    pub(super) fn len(&self) -> usize {
        self.live
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Body> {
        self.entries.iter().filter_map(|(_, body)| body.as_ref())
    }

    pub(super) fn add(&mut self, model: Arc<Model>, pose: Pose) -> Result<BodyId, Error> {
        let id = BodyId(self.next);
        let mut body = Body { id, model, pose, bounds: None };
        body.set_pose(pose)?;
        self.entries.push((id, Some(body)));
        self.live += 1;
        self.next += 1;
        Ok(id)
    }

    pub(super) fn get(&self, id: BodyId) -> Result<&Body, Error> {
        let body = self.place(id).and_then(|place| self.entries[place].1.as_ref());
        body.ok_or(Error::StaleBody { id })
    }

    pub(super) fn get_mut(&mut self, id: BodyId) -> Result<&mut Body, Error> {
        let body = self.place(id).and_then(|place| self.entries[place].1.as_mut());
        body.ok_or(Error::StaleBody { id })
    }

    pub(super) fn remove(&mut self, id: BodyId) -> Result<Body, Error> {
        let body = self.place(id).and_then(|place| self.entries[place].1.take());
        self.live -= usize::from(body.is_some());
        body.ok_or(Error::StaleBody { id })
    }

    /// By place, as [`Bodies::compact`] left them.
    pub(super) fn at(&self, place: u32) -> Option<&Body> {
        self.entries[place as usize].1.as_ref()
    }

    /// Closes the gaps.
    pub(super) fn compact(&mut self) {
        if self.live < self.entries.len() {
            self.entries.retain(|(_, body)| body.is_some());
        }
    }

    fn place(&self, id: BodyId) -> Option<usize> {
        self.entries.binary_search_by_key(&id, |&(id, _)| id).ok()
    }
}
