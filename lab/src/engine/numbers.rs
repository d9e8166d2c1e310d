//! Pairs of many objects, whose triangles are numbered through in the order of the objects.

use super::EngineError;
use pfront::TrianglePair;

/// The body of each object, ascending, and the number of its first triangle.
pub(super) struct Numbers<B> {
    bodies: Vec<(B, u32)>,
    next: u32,
}

impl<B: Copy + Ord> Numbers<B> {
    pub(super) fn new() -> Self {
        Self { bodies: Vec::new(), next: 0 }
    }

    /// Adds the body of the next object.
    ///
    /// # Errors
    /// If there are more triangles than u32 can number.
    pub(super) fn add(&mut self, body: B, triangles: usize) -> Result<(), EngineError> {
        let first = self.next;
        let next = u32::try_from(triangles).ok().and_then(|triangles| first.checked_add(triangles));
        self.next = next.ok_or(EngineError::TooMany)?;
        self.bodies.push((body, first));
        Ok(())
    }

    /// The body of an object.
    pub(super) fn body(&self, object: usize) -> Result<B, EngineError> {
        let body = self.bodies.get(object).map(|&(body, _)| body);
        body.ok_or(EngineError::NoObject { object, objects: self.bodies.len() })
    }

    /// A pair of two bodies.
    pub(super) fn pair(&self, bodies: [B; 2], pair: TrianglePair) -> TrianglePair {
        let first = |body: B| self.bodies[self.bodies.partition_point(|&(id, _)| id < body)].1;
        let [a, b] = bodies.map(first);
        TrianglePair { a: a + pair.a, b: b + pair.b }
    }
}
