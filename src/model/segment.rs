//! Triangles that a segment meets, and the rule for the inside of a model.

use super::Model;
use crate::Error;
use crate::environment::with_default;
use crate::memory::{filled, push};
use pfront_core::Pose;
use pfront_core::bvtt::PosedBvh;
use pfront_core::relation::{NotSolid, Rule};
use pfront_core::segment::{Segment, SegmentHit};
use std::ops::ControlFlow;

impl Model {
    /// The triangles that the closed segment between two points meets, sorted, each with the parameter of their first common point: exactly,
    /// touching counts. A segment from a point to itself is that point. Coordinates may be of any type that f64 holds.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is NaN or beyond ±2^125; [`Error::Memory`].
    ///
    /// # Complexity
    /// O(nodes whose boxes the segment reaches + h log h) for h hits.
    ///
    /// # Examples
    /// ```
    /// use pfront::Model;
    /// let square = |z| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
    /// let floors = Model::new([square(0.0), square(1.0)].concat(), vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])?;
    /// // Upwards, through the edge that two triangles have in common.
    /// let hits = floors.segment([0.5, 0.5, -1.0], [0.5, 0.5, 3.0])?;
    /// assert_eq!(hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>(), [0, 1, 2, 3]);
    /// assert_eq!(hits.iter().map(|hit| hit.at).collect::<Vec<_>>(), [0.25, 0.25, 0.5, 0.5]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn segment(
        &self,
        from: [impl Into<f64>; 3],
        to: [impl Into<f64>; 3],
    ) -> Result<Vec<SegmentHit>, Error> {
        with_default(|| hits(&Segment::new(from, to)?, &self.unposed()))
    }

    /// The first triangle along the segment from one point to another, and the parameter of their first common point: exactly; of
    /// triangles that it meets in one point, the one with the lowest index.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is NaN or beyond ±2^125.
    ///
    /// # Complexity
    /// As [`Model::segment`], without nodes beyond the first triangle that has been found so far.
    ///
    /// # Examples
    /// ```
    /// use pfront::Model;
    /// let model = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let hit = model.segment_first([0.5, 0.5, 3.0], [0.5, 0.5, -1.0])?.expect("it passes the triangle");
    /// assert_eq!((hit.triangle, hit.at), (0, 0.75));
    /// assert_eq!(model.segment_first([0.5, 0.5, 3.0], [0.5, 0.5, 1e-300])?, None);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn segment_first(
        &self,
        from: [impl Into<f64>; 3],
        to: [impl Into<f64>; 3],
    ) -> Result<Option<SegmentHit>, Error> {
        with_default(|| {
            let first = Segment::new(from, to)?.first([self.unposed()]);
            Ok(first.map(|(_, hit)| hit))
        })
    }

    fn unposed(&self) -> PosedBvh<'_> {
        PosedBvh::new_unchecked(self.bvh(), &Pose::IDENTITY)
    }

    /// The rule for its inside, or the edge that is open; found at the first call and at the next after the model has changed.
    ///
    /// # Errors
    /// [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n log n), then O(1).
    pub(crate) fn rule(&self) -> Result<Result<Rule, NotSolid>, Error> {
        if let Some(rule) = self.rule.get() {
            return Ok(*rule);
        }
        let mesh = self.mesh();
        let mut scratch = filled(0, 2 * mesh.vertex_count() + 6 * mesh.triangles().len())?;
        Ok(*self.rule.get_or_init(|| Rule::of(mesh, &mut scratch)))
    }
}

/// The triangles of a posed mesh that a segment meets, sorted.
///
/// # Errors
/// [`Error::Memory`].
pub(crate) fn hits(segment: &Segment, posed: &PosedBvh<'_>) -> Result<Vec<SegmentHit>, Error> {
    let (mut hits, mut pushed) = (Vec::new(), Ok(()));
    let _ = segment.visit(posed, |hit| {
        pushed = push(&mut hits, hit);
        if pushed.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    pushed?;
    hits.sort_unstable_by_key(|hit| hit.triangle);
    Ok(hits)
}
