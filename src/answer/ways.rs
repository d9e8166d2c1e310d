//! Answers on the CPU, and what they came to.

use super::alone::{End, Leash, alone};
#[cfg(feature = "threads")]
use crate::planner::Decider;
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use pfront_core::bvtt::{Query, TrianglePair};
use std::ops::ControlFlow;
#[cfg(feature = "threads")]
use std::slice::from_ref;

/// The verbs of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Want {
    All,
    Count,
    Any,
}

/// What an answer says, beside the list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given<T = TrianglePair> {
    pub(crate) count: u64,
    pub(crate) first: Option<T>,
}

impl<T> Default for Given<T> {
    fn default() -> Self {
        Self::counted(0)
    }
}

impl<T> Given<T> {
    /// The answer to `all`: a list in order.
    pub(crate) fn listed(list: &[T]) -> Self
    where
        T: Copy,
    {
        Self { count: list.len() as u64, first: list.first().copied() }
    }

    pub(crate) fn counted(count: u64) -> Self {
        Self { count, first: None }
    }

    /// The answer to `any`: the first pair found.
    pub(crate) fn found(first: Option<T>) -> Self {
        Self { count: u64::from(first.is_some()), first }
    }

    /// Takes note of one more, in `list` if all are wanted; breaks if that is enough.
    pub(crate) fn add(&mut self, hit: T, want: Want, list: &mut Vec<T>) -> ControlFlow<()> {
        self.count += 1;
        match want {
            Want::All => list.push(hit),
            Want::Count => {}
            Want::Any => {
                self.first = Some(hit);
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}

/// What one way came to.
#[derive(Default)]
pub(crate) struct Outcome<G = Given> {
    pub(crate) given: G,
    /// In box tests, if they were counted.
    pub(crate) cost: Option<f64>,
    /// If a GPU counted them.
    pub(crate) leaf_pairs: Option<u32>,
    pub(crate) end: End,
}

/// Answers on the calling thread, as long as `longer` allows.
pub(super) fn on_one(
    query: impl Query,
    want: Want,
    pairs: &mut Vec<TrianglePair>,
    leash: Leash,
    longer: impl FnMut(f64, &dyn Fn() -> f64) -> Option<f64>,
) -> Outcome {
    let mut given = Given::default();
    if want == Want::All {
        pairs.clear();
    }
    let found = |(), pair| given.add(pair, want, pairs);
    let (cost, end) = alone([((), query)], || 1, leash, found, longer);
    if want == Want::All && end != End::Outgrown {
        pairs.sort_unstable();
        given.first = pairs.first().copied();
    }
    Outcome { given, cost: Some(cost), leaf_pairs: None, end }
}

/// So many threads, with what they know of the last frame.
#[cfg(feature = "threads")]
pub(super) fn ready<'t>(
    traversal: &'t mut Option<Traversal>,
    decider: &Decider,
    workers: u32,
) -> &'t mut Traversal {
    let traversal = traversal.get_or_insert_with(|| decider.planner().traversal(workers));
    decider.prepare(traversal, workers);
    traversal
}

/// Answers on threads.
#[cfg(feature = "threads")]
pub(super) fn on_threads(
    traversal: &mut Traversal,
    query: &(impl Query + Sync),
    want: Want,
    pairs: &mut Vec<TrianglePair>,
) -> Outcome {
    let given = match want {
        Want::All => {
            traversal.all(from_ref(query), pairs);
            Given::listed(pairs)
        }
        Want::Count => Given::counted(traversal.count(from_ref(query))),
        Want::Any => Given::found(traversal.any(from_ref(query)).map(|hit| hit.pair)),
    };
    let report = &traversal.report;
    let end = if report.late { End::Late } else { End::Complete };
    Outcome { given, cost: Some(report.work().cost()), leaf_pairs: None, end }
}
