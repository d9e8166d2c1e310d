//! Changes of a scene between frames.

use super::{Body, BodyId, SceneQuery, Shape};
use crate::Error;
use pfront_core::Pose;
use std::sync::Arc;

/// Nothing changes where a call fails.
impl SceneQuery {
    /// Adds a body in the pose `world_from_body`. Many bodies may share one shape.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose is not finite or takes the shape out of range.
    pub fn add(
        &mut self,
        shape: impl Into<Arc<Shape>>,
        world_from_body: Pose,
    ) -> Result<BodyId, Error> {
        let id = self.bodies.add(shape.into(), world_from_body)?;
        self.arena = None;
        self.moved();
        Ok(id)
    }

    /// Takes a body out and returns it.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    ///
    /// # Complexity
    /// O(n) for n bodies.
    pub fn remove(&mut self, id: BodyId) -> Result<Body, Error> {
        let body = self.bodies.remove(id)?;
        self.arena = None;
        self.moved();
        Ok(body)
    }

    /// Moves a body to the pose `world_from_body`.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there, [`Error::Pose`] as for [`SceneQuery::add`].
    ///
    /// # Complexity
    /// O(log n) for n bodies.
    pub fn set_pose(&mut self, id: BodyId, world_from_body: Pose) -> Result<(), Error> {
        let body = self.bodies.get_mut(id)?;
        if body.pose() != world_from_body {
            body.set_pose(world_from_body)?;
            self.moved();
        }
        Ok(())
    }

    /// Moves the vertices of a body, given in its own frame.
    ///
    /// If the shape is shared, with another body or a caller that has kept an [`Arc`] of it, it is copied
    /// first; from then on this body has its own.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if the body is not there, [`Error::Mesh`] if a coordinate is not finite or
    /// the number of vertices differs, [`Error::Pose`] if its pose takes a vertex out of range.
    ///
    /// # Complexity
    /// O(vertices) on the host; the device refits all trees anyway.
    pub fn set_positions(&mut self, id: BodyId, positions: &[[f32; 3]]) -> Result<(), Error> {
        self.bodies.get_mut(id)?.set_positions(positions)?;
        if let Some(arena) = &self.arena {
            arena.write_positions(&self.answer.engine.gpu, id, positions);
        }
        self.moved();
        Ok(())
    }

    /// A body.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    pub fn body(&self, id: BodyId) -> Result<&Body, Error> {
        self.bodies.get(id)
    }

    /// The bodies in the order in which they were added.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter()
    }

    /// How many bodies there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bodies.iter().len()
    }

    /// Whether there is no body.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The broad phase and the device have to be told.
    fn moved(&mut self) {
        (self.is_paired, self.is_posed) = (false, false);
    }
}
