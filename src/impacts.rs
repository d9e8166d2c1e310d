//! Impacts of models that move: which triangles meet on the way, and when first, by the CPU of an executor.

use crate::environment::with_default;
use crate::executor::{Backend, CpuPart, History, check};
use crate::memory::push;
use crate::{Error, Motion, PairQuery, SelfQuery, TrianglePair};
use pfront_core::bvtt::{NodePair, PairBvtt, SelfBvtt, Work};
use pfront_core::motion::{Impact, MovingBvtt};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

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
        with_default(|| impacts(history, &PairBvtt::moving(a.bvh(), b.bvh())))
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
        with_default(|| first_impact(history, &PairBvtt::moving(a.bvh(), b.bvh())))
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
        with_default(|| impacts(history, &SelfBvtt::moving(motion.bvh()).with_adjacency(adjacency)))
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
        with_default(|| {
            first_impact(history, &SelfBvtt::moving(motion.bvh()).with_adjacency(adjacency))
        })
    }
}

/// Node pairs of a front: enough for every thread, and each below a millisecond of work even where meshes are large.
const FRONT: usize = 4096;

/// Node pairs that are worth a call of another thread.
const LEAST: usize = 16;

fn impacts<const SELF: bool>(
    history: &mut History<()>,
    tree: &MovingBvtt<'_, SELF>,
) -> Result<Vec<(TrianglePair, Impact)>, Error> {
    let (part, mut all) = (CpuPart::new(), Vec::new());
    let listed = {
        let flag = history.executor().cancel_flag();
        let list = |front: &[NodePair], out: &mut Vec<(TrianglePair, Impact)>| {
            part.works();
            for &n in front {
                check(flag)?;
                let mut failure = Ok(());
                let _ = tree.visit_below(n, &mut Work::default(), |pair, impact| {
                    failure = push(out, (pair, impact));
                    if failure.is_err() {
                        ControlFlow::Break(())
                    } else {
                        ControlFlow::Continue(())
                    }
                });
                failure?;
            }
            Ok(())
        };
        history.by_pieces(&front(tree)?, LEAST, list, &mut all)
    };
    history.note_cpu(part.backend());
    listed?;
    all.sort_unstable_by_key(|hit| hit.0);
    Ok(all)
}

fn first_impact<const SELF: bool>(
    history: &mut History<()>,
    tree: &MovingBvtt<'_, SELF>,
) -> Result<Option<(TrianglePair, Impact)>, Error> {
    let executor = history.executor();
    if executor.pool.is_none() && executor.cancel_flag().is_none() {
        history.note_cpu(Backend::Sequential);
        return Ok(tree.first_impact());
    }
    let (part, best) = (CpuPart::new(), Mutex::new(None));
    let known = || best.lock().unwrap_or_else(PoisonError::into_inner);
    let listed = {
        let flag = history.executor().cancel_flag();
        let list = |front: &[NodePair], _: &mut Vec<()>| {
            part.works();
            for &n in front {
                check(flag)?;
                let before = *known();
                let found = tree.first_impact_below(n, &mut Work::default(), before);
                let mut best = known();
                *best = earlier(*best, found);
            }
            Ok(())
        };
        history.by_pieces(&front(tree)?, LEAST, list, &mut Vec::new())
    };
    history.note_cpu(part.backend());
    listed?;
    Ok(best.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// The first of two, by time and then by the pair.
fn earlier(
    p: Option<(TrianglePair, Impact)>,
    q: Option<(TrianglePair, Impact)>,
) -> Option<(TrianglePair, Impact)> {
    let is_first =
        |p: &(TrianglePair, Impact), q: &(TrianglePair, Impact)| (p.1.from, p.0) <= (q.1.from, q.0);
    match (p, q) {
        (Some(p), Some(q)) => Some(if is_first(&p, &q) { p } else { q }),
        (p, q) => p.or(q),
    }
}

/// A cut of the tree of about [`FRONT`] node pairs, level by level.
fn front<const SELF: bool>(tree: &MovingBvtt<'_, SELF>) -> Result<Vec<NodePair>, Error> {
    let mut front = Vec::from_iter(tree.root());
    loop {
        let (mut next, mut failure, mut is_over) = (Vec::new(), Ok(()), true);
        for &n in &front {
            let mut add = |n| {
                if failure.is_ok() {
                    failure = push(&mut next, n);
                }
            };
            match tree.children(n, &mut add) {
                0 => add(n),
                _ => is_over = false,
            }
        }
        failure?;
        front = next;
        if is_over || front.len() >= FRONT {
            return Ok(front);
        }
    }
}
