//! Answers on the CPU, and what they came to.

#[cfg(feature = "threads")]
use super::alone::cost;
use super::alone::{End, Leash, alone};
#[cfg(feature = "threads")]
use crate::planner::Decider;
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use pfront_core::query::{Query, TrianglePair};
use std::ops::ControlFlow;

/// What is wanted of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Want {
    All,
    Count,
    Any,
}

/// What an answer says, beside the list.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Given {
    pub(crate) count: u64,
    pub(crate) first: Option<TrianglePair>,
}

/// What one way came to.
#[derive(Default)]
pub(super) struct Outcome {
    pub(super) given: Given,
    /// In box tests, if they were counted.
    pub(super) cost: Option<f64>,
    /// If a GPU counted them.
    pub(super) leaf_pairs: Option<u32>,
    pub(super) end: End,
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
    let found = |(), pair| {
        given.count += 1;
        match want {
            Want::All => pairs.push(pair),
            Want::Count => {}
            Want::Any => {
                given.first = Some(pair);
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    };
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
            traversal.all(query, pairs);
            Given { count: pairs.len() as u64, first: pairs.first().copied() }
        }
        Want::Count => Given { count: traversal.count(query), first: None },
        Want::Any => {
            let first = traversal.any(query);
            Given { count: u64::from(first.is_some()), first }
        }
    };
    let report = traversal.report();
    let end = if report.late { End::Late } else { End::Complete };
    Outcome { given, cost: Some(cost(report.work())), leaf_pairs: None, end }
}
