//! Impacts: which triangles of some subjects meet while these move, whether any do, how many, and when first, on the CPU of an executor.

use super::{CpuPart, Executor, History, Named, check};
use crate::memory::push;
use crate::{Error, Impact, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Cursor, NodePair, Query, Work};
use pfront_core::motion::MovingBvtt;
use std::mem::take;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// The BVTT of two meshes that move, of one that deforms and itself, or of what rests.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyMovingBvtt<'q> {
    Pair(MovingBvtt<'q, false>),
    Itself(MovingBvtt<'q, true>),
    /// Its pairs are those that intersect, from the start on.
    Still(AnyBvtt<'q>),
}

impl AnyMovingBvtt<'_> {
    /// The first time at which the boxes of the root overlap; before that, nothing below meets.
    pub(crate) fn first_overlap(&self) -> Option<f64> {
        match self {
            Self::Pair(tree) => tree.first_overlap(),
            Self::Itself(tree) => tree.first_overlap(),
            Self::Still(tree) => tree.root().map(|_| 0.0),
        }
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair)) -> u32 {
        match self {
            Self::Pair(tree) => tree.children(n, push),
            Self::Itself(tree) => tree.children(n, push),
            Self::Still(tree) => tree.children(n, &mut |child, _| push(child)),
        }
    }

    /// Visits what is below a node pair with a budget, which what rests needs none of.
    fn visit_below(
        &self,
        n: NodePair,
        budget: u64,
        visit: &mut dyn FnMut(TrianglePair, Impact) -> ControlFlow<()>,
        leave: &mut dyn FnMut(NodePair),
    ) {
        let work = &mut Work::default();
        let _ = match self {
            Self::Pair(tree) => tree.visit_with_budget(n, work, budget, visit, leave),
            Self::Itself(tree) => tree.visit_with_budget(n, work, budget, visit, leave),
            Self::Still(tree) => tree.visit(&mut Cursor::at(n), |pair| visit(pair, AT_START)),
        };
    }

    fn first_impact_below(&self, n: NodePair, limit: f64) -> Option<(TrianglePair, Impact)> {
        let work = &mut Work::default();
        match self {
            Self::Pair(tree) => tree.first_impact_below(n, work, limit),
            Self::Itself(tree) => tree.first_impact_below(n, work, limit),
            Self::Still(tree) => {
                let mut first = None;
                let _ = tree.visit(&mut Cursor::at(n), |pair| {
                    first = Some(first.map_or(pair, |first: TrianglePair| first.min(pair)));
                    ControlFlow::Continue(())
                });
                first.map(|pair| (pair, AT_START))
            }
        }
    }
}

/// The impact of what intersects from the start on.
pub(crate) const AT_START: Impact = Impact { from: 0.0, to: 0.0 };

/// Whether debug assertions are on, as in tests, whose meshes are small: all numbers below are smaller then, so that such meshes are divided too.
const IS_DEBUG: bool = cfg!(debug_assertions);

/// Node pairs of all fronts: enough for every thread.
const FRONT: usize = if IS_DEBUG { 64 } else { 4096 };

/// Tests below a node pair of a front after which several threads make a front of what is left, since where much meets one node pair may have
/// a tenth of all work.
const BUDGET: u64 = if IS_DEBUG { 64 } else { 4096 };

/// Node pairs that are worth a call of another thread.
const LEAST: usize = if IS_DEBUG { 2 } else { 16 };

/// Node pairs that one thread looks at before it divides what may end early: a walk down two trees of a million triangles takes half of them.
const ALONE: usize = if IS_DEBUG { 4 } else { 64 };

/// A node pair below which a tree is visited.
struct Below<'t, 'q> {
    tree: &'t AnyMovingBvtt<'q>,
    n: NodePair,
    budget: u64,
    /// Node pairs that the budget has left.
    left: Vec<NodePair>,
}

impl Below<'_, '_> {
    fn visit(
        &mut self,
        mut visit: impl FnMut(TrianglePair, Impact) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let mut pushed = Ok(());
        self.tree.visit_below(self.n, self.budget, &mut visit, &mut |n| {
            if pushed.is_ok() {
                pushed = push(&mut self.left, n);
            }
        });
        pushed
    }
}

/// A subject that is asked about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MovingSubject<S> {
    /// Nothing of it meets before this time.
    pub(crate) from: f64,
    pub(crate) subject: S,
}

/// Adds all pairs that meet to a list, in no order. `tree` gives the name and the tree of a subject.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::Memory`], or [`Error::Panicked`] for a thread of a pool.
pub(crate) fn impacts<'q, F: Named, S: Copy + PartialEq + Send + Sync>(
    history: &mut History<F::Name>,
    subjects: &[MovingSubject<S>],
    tree: impl Fn(S) -> Option<(F::Name, AnyMovingBvtt<'q>)> + Sync,
    all: &mut Vec<(F, Impact)>,
) -> Result<(), Error> {
    let list = |name, below: &mut Below<'_, '_>, out: &mut Vec<(F, Impact)>| {
        let mut pushed = Ok(());
        below.visit(|pair, impact| {
            pushed = push(out, (F::new(name, pair), impact));
            if pushed.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })?;
        pushed.map(ControlFlow::Continue)
    };
    by_node_pairs(history, roots(subjects), tree, FRONT, list, all)
}

/// How many pairs certainly meet, and how many do or are open.
///
/// # Errors
/// As [`impacts`].
pub(crate) fn count<'q, N: Copy + Ord, S: Copy + PartialEq + Send + Sync>(
    history: &mut History<N>,
    subjects: &[MovingSubject<S>],
    tree: impl Fn(S) -> Option<(N, AnyMovingBvtt<'q>)> + Sync,
) -> Result<[u64; 2], Error> {
    let counts = [AtomicU64::new(0), AtomicU64::new(0)];
    let add = |_, below: &mut Below<'_, '_>, _: &mut Vec<()>| {
        let (mut proven, mut all) = (0, 0);
        below.visit(|_, impact| {
            proven += u64::from(impact.is_proven());
            all += 1;
            ControlFlow::Continue(())
        })?;
        counts[0].fetch_add(proven, Relaxed);
        counts[1].fetch_add(all, Relaxed);
        Ok(ControlFlow::Continue(()))
    };
    by_node_pairs(history, roots(subjects), tree, FRONT, add, &mut Vec::new())?;
    Ok(counts.map(AtomicU64::into_inner))
}

/// A pair that certainly meets, the first that is found; if there is none, one that is open, if any is.
///
/// # Errors
/// As [`impacts`].
pub(crate) fn any_impact<'q, F: Named, S: Copy + PartialEq + Send + Sync>(
    history: &mut History<F::Name>,
    subjects: &[MovingSubject<S>],
    tree: impl Fn(S) -> Option<(F::Name, AnyMovingBvtt<'q>)> + Sync,
) -> Result<Option<(F, Impact)>, Error> {
    let found = Mutex::new(None);
    let search = |name, below: &mut Below<'_, '_>, _: &mut Vec<()>| {
        let mut end = ControlFlow::Continue(());
        below.visit(|pair, impact| {
            let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
            if impact.is_proven() {
                end = ControlFlow::Break(());
            }
            if end.is_break() || found.is_none() {
                *found = Some((F::new(name, pair), impact));
            }
            end
        })?;
        Ok(end)
    };
    let (mut above, mut least) = (roots(subjects), 1);
    if !is_whole(history.executor()) {
        above = above.and_then(|above| begin(history, above, &tree, search));
        least = FRONT;
    }
    by_node_pairs(history, above, tree, least, search, &mut Vec::new())?;
    Ok(found.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// A node pair of the tree of a subject.
type SubjectNodePair<S> = (MovingSubject<S>, NodePair);

/// The whole of each subject.
fn roots<S: Copy>(subjects: &[MovingSubject<S>]) -> Result<Vec<SubjectNodePair<S>>, Error> {
    let mut all = Vec::new();
    for &subject in subjects {
        push(&mut all, (subject, NodePair::default()))?;
    }
    Ok(all)
}

/// Asks about some node pairs on the calling thread, depth first, for where much meets a hit is found before a front is made. Returns what
/// is left to ask about: nothing once `ask` breaks.
///
/// # Errors
/// Every error of `ask`, and as [`impacts`].
fn begin<'q, N: Copy + Ord, S: Copy>(
    history: &History<N>,
    mut left: Vec<SubjectNodePair<S>>,
    tree: impl Fn(S) -> Option<(N, AnyMovingBvtt<'q>)>,
    ask: impl Fn(N, &mut Below<'_, 'q>, &mut Vec<()>) -> Result<ControlFlow<()>, Error>,
) -> Result<Vec<SubjectNodePair<S>>, Error> {
    let (flag, mut children) = (history.executor().cancel_flag(), Vec::new());
    left.reverse();
    for _ in 0..ALONE {
        check(flag)?;
        let Some((subject, n)) = left.pop() else { break };
        let Some((name, tree)) = tree(subject.subject) else { continue };
        if deepen(&tree, &[n], &mut children)? {
            for &child in &children {
                push(&mut left, (subject, child))?;
            }
            continue;
        }
        let below = &mut Below { tree: &tree, n, budget: u64::MAX, left: Vec::new() };
        if ask(name, below, &mut Vec::new())?.is_break() {
            return Ok(Vec::new());
        }
    }
    left.reverse();
    Ok(left)
}

/// Asks about what is below some node pairs on the threads of the executor, until `ask` breaks, and adds to a list. Several threads make a front
/// of at least so many of them, if there are, and then of what the budget has left of each.
///
/// # Errors
/// The error of `above`, every error of `ask`, and as [`impacts`]. Who has worked is noted then too.
fn by_node_pairs<'q, N: Copy + Ord, S: Copy + PartialEq + Send + Sync, R: Send>(
    history: &mut History<N>,
    above: Result<Vec<SubjectNodePair<S>>, Error>,
    tree: impl Fn(S) -> Option<(N, AnyMovingBvtt<'q>)> + Sync,
    least: usize,
    ask: impl Fn(N, &mut Below<'_, 'q>, &mut Vec<R>) -> Result<ControlFlow<()>, Error> + Sync,
    out: &mut Vec<R>,
) -> Result<(), Error> {
    let (part, has_ended, left) = (CpuPart::new(), AtomicBool::new(false), Mutex::new(Vec::new()));
    let left = || left.lock().unwrap_or_else(PoisonError::into_inner);
    let flag = history.executor().cancel_flag();
    let for_threads = history.executor().pool.is_some();
    let budget = if for_threads { BUDGET } else { u64::MAX };
    let list = |front: &[SubjectNodePair<S>], out: &mut Vec<R>| {
        part.works();
        for of_one in front.chunk_by(|x, y| x.0 == y.0) {
            let subject = of_one[0].0;
            let Some((name, tree)) = tree(subject.subject) else { continue };
            for &(_, n) in of_one {
                check(flag)?;
                if has_ended.load(Relaxed) {
                    return Ok(());
                }
                let mut below = Below { tree: &tree, n, budget, left: Vec::new() };
                if ask(name, &mut below, out)?.is_break() {
                    has_ended.store(true, Relaxed);
                }
                if !below.left.is_empty() {
                    let mut left = left();
                    below.left.drain(..).try_for_each(|n| push(&mut left, (subject, n)))?;
                }
            }
        }
        Ok(())
    };
    let by_fronts = |mut above| {
        loop {
            let front = fronts(above, &tree, least, for_threads)?;
            history.by_pieces(&front, LEAST, list, out)?;
            above = take(&mut *left());
            if above.is_empty() || has_ended.load(Relaxed) {
                return Ok(());
            }
        }
    };
    let listed = above.and_then(by_fronts);
    history.note_cpu(part.backend());
    listed
}

/// Whether one thread answers that nothing interrupts: it divides nothing if it may stop early.
fn is_whole(executor: &Executor) -> bool {
    executor.pool.is_none() && executor.cancel_flag().is_none()
}

/// The pair that meets first, by time, then by the name of its subject, then by the pair; or `known`, if that comes before all. Subjects ascend by
/// the time before which nothing of them meets.
///
/// # Errors
/// As [`impacts`].
pub(crate) fn first_impact<'q, F: Named, S: Copy + PartialEq + Sync>(
    history: &mut History<F::Name>,
    subjects: &[MovingSubject<S>],
    tree: impl Fn(S) -> Option<(F::Name, AnyMovingBvtt<'q>)> + Sync,
    known: Option<(F, Impact)>,
) -> Result<Option<(F, Impact)>, Error> {
    let (part, best) = (CpuPart::new(), Mutex::new(known));
    let known = || best.lock().unwrap_or_else(PoisonError::into_inner);
    let limit = || known().map_or(f64::INFINITY, |(_, impact)| impact.from);
    let listed = {
        let executor = history.executor();
        let flag = executor.cancel_flag();
        let search = |front: &[SubjectNodePair<S>], _: &mut Vec<()>| {
            part.works();
            for of_one in front.chunk_by(|x, y| x.0 == y.0) {
                let MovingSubject { from, subject } = of_one[0].0;
                if from > limit() {
                    break;
                }
                let Some((name, tree)) = tree(subject) else { continue };
                // Among hits at the same time, that of the first name counts.
                let is_before =
                    |(hit, impact): (F, Impact)| impact.from <= from && hit.name() < name;
                if known().is_some_and(is_before) {
                    continue;
                }
                for &(_, n) in of_one {
                    check(flag)?;
                    let found = tree.first_impact_below(n, limit());
                    let found = found.map(|(pair, impact)| (F::new(name, pair), impact));
                    let mut best = known();
                    *best = earlier(*best, found);
                }
            }
            Ok(())
        };
        let least = if is_whole(executor) { 1 } else { FRONT };
        roots(subjects)
            .and_then(|above| fronts(above, &tree, least, executor.pool.is_some()))
            .and_then(|front| history.by_pieces(&front, LEAST, search, &mut Vec::new()))
    };
    history.note_cpu(part.backend());
    listed?;
    Ok(best.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// The first of two, by time and then by the hit.
fn earlier<F: Named>(p: Option<(F, Impact)>, q: Option<(F, Impact)>) -> Option<(F, Impact)> {
    let is_first = |p: &(F, Impact), q: &(F, Impact)| (p.1.from, p.0) <= (q.1.from, q.0);
    match (p, q) {
        (Some(p), Some(q)) => Some(if is_first(&p, &q) { p } else { q }),
        (p, q) => p.or(q),
    }
}

/// A cut of the trees below some node pairs, of at least so many node pairs if there are, one subject after the other. For several threads, node
/// pairs that are near each other are spread over the list, so that no piece of it has all of where much meets.
fn fronts<'q, N, S: Copy + PartialEq>(
    above: Vec<SubjectNodePair<S>>,
    tree: impl Fn(S) -> Option<(N, AnyMovingBvtt<'q>)>,
    least: usize,
    for_threads: bool,
) -> Result<Vec<SubjectNodePair<S>>, Error> {
    let share = least / above.chunk_by(|x, y| x.0 == y.0).count().max(1);
    if share <= 1 {
        return Ok(above);
    }
    let (mut fronts, mut front, mut next) = (Vec::new(), Vec::new(), Vec::new());
    for of_one in above.chunk_by(|x, y| x.0 == y.0) {
        let subject = of_one[0].0;
        front.clear();
        for &(_, n) in of_one {
            push(&mut front, n)?;
        }
        if let Some((_, tree)) = tree(subject.subject) {
            while front.len() < share && deepen(&tree, &front, &mut next)? {
                std::mem::swap(&mut front, &mut next);
            }
        }
        let rows = if for_threads { front.len().isqrt().max(1) } else { 1 };
        for &n in (0..rows).flat_map(|row| front.iter().skip(row).step_by(rows)) {
            push(&mut fronts, (subject, n))?;
        }
    }
    Ok(fronts)
}

/// Makes `next` the children of a front, and its leaf pairs. Returns whether it had others.
fn deepen(
    tree: &AnyMovingBvtt<'_>,
    front: &[NodePair],
    next: &mut Vec<NodePair>,
) -> Result<bool, Error> {
    let (mut pushed, mut has_children) = (Ok(()), false);
    next.clear();
    for &n in front {
        let mut add = |n| {
            if pushed.is_ok() {
                pushed = push(next, n);
            }
        };
        match tree.children(n, &mut add) {
            0 => add(n),
            _ => has_children = true,
        }
    }
    pushed?;
    Ok(has_children)
}
