//! Impacts of models that move: which triangles meet on the way, and when first, by the CPU of an executor.

use crate::environment::with_default;
use crate::executor::History;
use crate::executor::impacts::{self, AnyMovingBvtt, MovingSubject};
use crate::{Error, Impact, Motion, PairQuery, SelfQuery, TrianglePair};
use pfront_core::bvtt::{PairBvtt, SelfBvtt};

impl PairQuery {
    /// All pairs of triangles of two models that meet while both move, sorted, each with when they first do: they do not meet before `from`, and
    /// certainly meet before `to`, if that is finite. CPUs answer, whatever the executor; the same to the bit. The distance of
    /// [`PairQuery::within`] does not matter.
    ///
    /// Exact but for pairs that touch and do not pass, move in one plane for ever, or have coordinates of more than 356 bits: these are reported
    /// with an infinite `to`. No pair is missed. See [`pfront_core::motion`].
    ///
    /// # Errors
    /// [`Error::Memory`]; [`Error::Cancelled`] if the flag of the executor is set.
    ///
    /// # Complexity
    /// Two boxes of each node are compared at a common time, so that bodies which move side by side have as many pairs as bodies at rest. Two
    /// triangles whose boxes meet at a time take some ten nanoseconds if they stay well apart, else some microseconds.
    ///
    /// # Examples
    /// See [`Motion`].
    pub fn impacts(
        &mut self,
        a: &Motion<'_>,
        b: &Motion<'_>,
    ) -> Result<Vec<(TrianglePair, Impact)>, Error> {
        let history = self.query.history();
        with_default(|| all(history, AnyMovingBvtt::Pair(PairBvtt::moving(a.bvh(), b.bvh()))))
    }

    /// The pair of triangles that meets first, by `from` and then by the pair, and when, if any does.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Complexity
    /// Node pairs that meet first are visited first, and those that do so later than the answer are left out.
    pub fn first_impact(
        &mut self,
        a: &Motion<'_>,
        b: &Motion<'_>,
    ) -> Result<Option<(TrianglePair, Impact)>, Error> {
        let history = self.query.history();
        with_default(|| first(history, AnyMovingBvtt::Pair(PairBvtt::moving(a.bvh(), b.bvh()))))
    }
}

impl SelfQuery {
    /// All pairs of triangles of one model that meet while it deforms, as [`PairQuery::impacts`] has them. Triangles that share a vertex are
    /// decided by [a rule of their own](pfront_core::motion::impact_in_mesh); poses do not matter.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Examples
    /// See [`Motion::between`].
    pub fn impacts(&mut self, motion: &Motion<'_>) -> Result<Vec<(TrianglePair, Impact)>, Error> {
        let adjacency = self.adjacency();
        let history = self.history();
        let tree = || SelfBvtt::moving(motion.bvh()).with_adjacency(adjacency);
        with_default(|| all(history, AnyMovingBvtt::Itself(tree())))
    }

    /// The pair of triangles of one model that meets first while it deforms.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    pub fn first_impact(
        &mut self,
        motion: &Motion<'_>,
    ) -> Result<Option<(TrianglePair, Impact)>, Error> {
        let adjacency = self.adjacency();
        let history = self.history();
        let tree = || SelfBvtt::moving(motion.bvh()).with_adjacency(adjacency);
        with_default(|| first(history, AnyMovingBvtt::Itself(tree())))
    }
}

/// All pairs of one subject, sorted.
fn all(
    history: &mut History<()>,
    tree: AnyMovingBvtt<'_>,
) -> Result<Vec<(TrianglePair, Impact)>, Error> {
    let mut all = Vec::new();
    impacts::impacts(history, subject(&tree).as_slice(), |()| Some(((), tree)), &mut all)?;
    all.sort_unstable_by_key(|hit| hit.0);
    Ok(all)
}

/// The first pair of one subject.
fn first(
    history: &mut History<()>,
    tree: AnyMovingBvtt<'_>,
) -> Result<Option<(TrianglePair, Impact)>, Error> {
    impacts::first_impact(history, subject(&tree).as_slice(), |()| Some(((), tree)), None)
}

/// The only subject, if its boxes overlap at a time.
fn subject(tree: &AnyMovingBvtt<'_>) -> Option<MovingSubject<()>> {
    tree.first_overlap().map(|from| MovingSubject { from, subject: () })
}
