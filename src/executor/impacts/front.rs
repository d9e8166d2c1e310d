//! Fronts of subjects that move: node pairs that the threads of an executor visit, and then what a budget of tests has left of each.

use super::tree::AnyMovingBvtt;
use crate::executor::{CpuPart, Executor, History, check};
use crate::memory::{copy, extend, push, reserve};
use crate::{Error, Impact, TrianglePair};
use pfront_core::bvtt::NodePair;
use std::mem::take;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// How finely subjects are divided. Answers do not depend on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    /// Node pairs of all fronts: enough for every thread.
    pub(super) front: usize,
    /// Tests below a node pair of a front after which a front is made of what is left, since where much meets one node pair may have a tenth of
    /// all work.
    pub(super) budget: u64,
    /// Node pairs that are worth a call of another thread.
    pub(super) least: usize,
    /// Tests of few subjects on the calling thread before there is a front: a walk down two trees of a million triangles takes half of them.
    pub(super) alone: u64,
}

impl Cut {
    pub(super) const DEFAULT: Self = Self { front: 4096, budget: 4096, least: 16, alone: 256 };
}

/// A node pair of the tree of a subject.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SubjectNodePair<S> {
    pub(crate) subject: S,
    pub(super) n: NodePair,
    /// Nothing below it meets before this time.
    pub(crate) from: f64,
}

impl<S: PartialEq> SubjectNodePair<S> {
    /// All of a subject.
    pub(crate) fn root(subject: S, from: f64) -> Self {
        Self { subject, n: NodePair::default(), from }
    }

    fn is_of_same(&self, other: &Self) -> bool {
        self.subject == other.subject
    }
}

/// A node pair below which a tree is visited.
pub(super) struct Below<'t, 'q> {
    tree: &'t AnyMovingBvtt<'q>,
    n: NodePair,
    pub(super) from: f64,
    budget: u64,
    /// Node pairs that the budget has left.
    left: Vec<(NodePair, f64)>,
}

impl Below<'_, '_> {
    /// Visits pairs that meet no later than the limit, or than `visit` goes on with, and perhaps others.
    pub(super) fn visit(
        &mut self,
        limit: f64,
        mut visit: impl FnMut(TrianglePair, Impact) -> ControlFlow<(), f64>,
    ) -> Result<(), Error> {
        let mut pushed = Ok(());
        self.tree.visit_with_budget(self.n, self.budget, limit, &mut visit, &mut |n, from| {
            if pushed.is_ok() {
                pushed = push(&mut self.left, (n, from));
            }
        });
        pushed
    }
}

/// Subjects that move, about which a query asks on the threads of its executor.
pub(crate) struct MovingSubjects<'h, N, S, T> {
    pub(super) history: &'h mut History<N>,
    pub(super) subjects: &'h [SubjectNodePair<S>],
    /// Gives the name and the tree of a subject.
    pub(super) tree: T,
    pub(super) cut: Cut,
}

/// The latest time that matters, where what meets first is looked for.
pub(super) type Limit<'l> = Option<&'l (dyn Fn() -> f64 + Sync)>;

impl<'h, 'q, N, S, T> MovingSubjects<'h, N, S, T>
where
    N: Copy + Ord,
    S: Copy + PartialEq + Send + Sync,
    T: Fn(S) -> Option<(N, AnyMovingBvtt<'q>)> + Sync,
{
    pub(crate) fn new(
        history: &'h mut History<N>,
        subjects: &'h [SubjectNodePair<S>],
        tree: T,
    ) -> Self {
        Self { history, subjects, tree, cut: Cut::DEFAULT }
    }

    /// Asks about all subjects on the threads of the executor, until `ask` breaks, and adds to a list. Nothing is asked that meets later than the
    /// limit.
    ///
    /// Few subjects begin on the calling thread, depth first, for where much meets a hit is found before a front is made, and what is soon over
    /// calls no other. Then a front is made of what the budget has left, and again.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Memory`], [`Error::Panicked`] for a thread of a pool, and every error of `ask`. Who has worked is noted then
    /// too.
    pub(super) fn each<R: Send>(
        self,
        limit: Limit<'_>,
        ask: impl Fn(N, &mut Below<'_, 'q>, &mut Vec<R>) -> Result<ControlFlow<()>, Error> + Sync,
        out: &mut Vec<R>,
    ) -> Result<(), Error> {
        let part = CpuPart::new();
        let asked = self.by_fronts(&part, limit, ask, out);
        self.history.note_cpu(part.backend());
        asked
    }

    /// [`Self::each`], with what sees who works.
    fn by_fronts<R: Send>(
        &self,
        part: &CpuPart,
        limit: Limit<'_>,
        ask: impl Fn(N, &mut Below<'_, 'q>, &mut Vec<R>) -> Result<ControlFlow<()>, Error> + Sync,
        out: &mut Vec<R>,
    ) -> Result<(), Error> {
        let (has_ended, left) = (AtomicBool::new(false), Mutex::new(Vec::new()));
        let left = || left.lock().unwrap_or_else(PoisonError::into_inner);
        let Self { history, tree, cut, .. } = self;
        let flag = history.executor().cancel_flag();
        let list = |budget: u64, front: &[SubjectNodePair<S>], out: &mut Vec<R>| {
            part.works();
            for of_one in front.chunk_by(SubjectNodePair::is_of_same) {
                let subject = of_one[0].subject;
                let Some((name, tree)) = tree(subject) else { continue };
                for &SubjectNodePair { n, from, .. } in of_one {
                    check(flag)?;
                    if has_ended.load(Relaxed) {
                        return Ok(());
                    }
                    if limit.is_some_and(|limit| from > limit()) {
                        continue;
                    }
                    let mut below = Below { tree: &tree, n, from, budget, left: Vec::new() };
                    if ask(name, &mut below, out)?.is_break() {
                        has_ended.store(true, Relaxed);
                    }
                    if !below.left.is_empty() {
                        let of_subject = |(n, from)| SubjectNodePair { subject, n, from };
                        extend(&mut left(), below.left.drain(..).map(of_subject))?;
                    }
                }
            }
            Ok(())
        };
        let (mut front, mut budget) = (copy(self.subjects)?, u64::MAX);
        if !is_whole(history.executor()) {
            let is_few = front.len() < 2 * cut.least;
            budget = if is_few { cut.alone / front.len().max(1) as u64 } else { cut.budget }.max(1);
            front = if is_few { front } else { self.front(front, limit)? };
        }
        loop {
            history.by_pieces(&front, cut.least, |front, out| list(budget, front, out), out)?;
            let above = take(&mut *left());
            if above.is_empty() || has_ended.load(Relaxed) {
                return Ok(());
            }
            (front, budget) = (self.front(above, limit)?, cut.budget);
        }
    }

    /// A cut of the trees below some node pairs, of about so many as a front has if there are, in the order of these. One thread makes a sixteenth
    /// of it, and all of them the rest. For several threads, node pairs that are near each other are spread over the list, so that no piece of
    /// it has all of where much meets.
    fn front(
        &self,
        above: Vec<SubjectNodePair<S>>,
        limit: Limit<'_>,
    ) -> Result<Vec<SubjectNodePair<S>>, Error> {
        let (tree, least, mut front) = (&self.tree, self.cut.front, above);
        if front.len() < least {
            let mut coarse = Vec::new();
            refine(tree, &front, least / 16, limit, &mut coarse)?;
            let list = |piece: &[SubjectNodePair<S>], out: &mut Vec<_>| {
                refine(tree, piece, least * piece.len() / coarse.len().max(1), limit, out)
            };
            front.clear();
            self.history.by_pieces(&coarse, self.cut.least, list, &mut front)?;
        }
        if self.history.executor().pool.is_none() {
            return Ok(front);
        }
        let mut spread = Vec::new();
        reserve(&mut spread, front.len())?;
        for of_one in front.chunk_by(SubjectNodePair::is_of_same) {
            let rows = of_one.len().isqrt();
            spread.extend((0..rows).flat_map(|row| of_one.iter().skip(row).step_by(rows)));
        }
        Ok(spread)
    }
}

/// Whether one thread answers that nothing interrupts: it divides nothing.
fn is_whole(executor: &Executor) -> bool {
    executor.pool.is_none() && executor.cancel_flag().is_none()
}

/// Adds a cut of the trees below some node pairs, of about so many node pairs if there are, in the order of these.
fn refine<'q, N, S: Copy + PartialEq>(
    tree: impl Fn(S) -> Option<(N, AnyMovingBvtt<'q>)>,
    above: &[SubjectNodePair<S>],
    least: usize,
    limit: Limit<'_>,
    out: &mut Vec<SubjectNodePair<S>>,
) -> Result<(), Error> {
    let share = least / above.chunk_by(SubjectNodePair::is_of_same).count().max(1);
    let limit = limit.map_or(f64::INFINITY, |limit| limit());
    let (mut front, mut next) = (Vec::new(), Vec::new());
    for of_one in above.chunk_by(SubjectNodePair::is_of_same) {
        if of_one.len() >= share {
            extend(out, of_one.iter().copied())?;
            continue;
        }
        let Some((_, tree)) = tree(of_one[0].subject) else { continue };
        extend(&mut front, of_one.iter().copied())?;
        while front.len() < share && deepen(&tree, &front, limit, &mut next)? {
            std::mem::swap(&mut front, &mut next);
        }
        extend(out, front.drain(..))?;
    }
    Ok(())
}

/// Makes `next` the children of a front, and its leaf pairs, but for what meets later than the limit. Returns whether it had others.
fn deepen<S: Copy>(
    tree: &AnyMovingBvtt<'_>,
    front: &[SubjectNodePair<S>],
    limit: f64,
    next: &mut Vec<SubjectNodePair<S>>,
) -> Result<bool, Error> {
    let (mut pushed, mut has_children) = (Ok(()), false);
    next.clear();
    for &above in front {
        let mut add = |n, from| {
            if pushed.is_ok() && from <= limit {
                pushed = push(next, SubjectNodePair { n, from, ..above });
            }
        };
        match tree.children(above.n, &mut add) {
            0 => add(above.n, above.from),
            _ => has_children = true,
        }
    }
    pushed?;
    Ok(has_children)
}
