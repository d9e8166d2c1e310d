//! Pairs of many objects, whose triangles are numbered through in the order of the objects.

use anyhow::{Context, Result};
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
    pub(super) fn add(&mut self, body: B, triangles: usize) -> Result<()> {
        let first = self.next;
        let next = u32::try_from(triangles).ok().and_then(|triangles| first.checked_add(triangles));
        self.next = next.context("more triangles than u32 can number")?;
        self.bodies.push((body, first));
        Ok(())
    }

    pub(super) fn bodies(&self) -> impl Iterator<Item = B> {
        self.bodies.iter().map(|&(body, _)| body)
    }

    /// A pair of two bodies.
    pub(super) fn pair(&self, bodies: [B; 2], pair: TrianglePair) -> TrianglePair {
        let first = |body: B| self.bodies[self.bodies.partition_point(|&(id, _)| id < body)].1;
        let [a, b] = bodies.map(first);
        TrianglePair { a: a + pair.a, b: b + pair.b }
    }
}
