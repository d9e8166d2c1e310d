//! Answering on the calling thread, within limits.

use pfront_core::bvtt::{Cursor, Query, TrianglePair, Work};
use pfront_core::front::estimate;
use std::ops::ControlFlow;
use std::time::Instant;

/// How far a walk may go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leash {
    /// In box tests.
    pub(crate) cost: f64,
    pub(crate) deadline: Option<Instant>,
}

/// How a walk ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum End {
    /// Nothing is left, or no more is wanted.
    #[default]
    Complete,
    /// Somebody else shall do it.
    Outgrown,
    /// Time ran out.
    Late,
}

/// Tests between two looks at the clock: some 20 us.
const BETWEEN_LOOKS: u64 = 8192;
/// How many nodes tell what is left.
const LARGEST: usize = 16;
/// The fewest tests that are worth a step.
const STEP: u64 = 256;

/// Hands on what is found, with the name of the query, until it is told to stop. At the end of the leash `longer`
/// says how far to go on, if at all; it is told the cost up to now, and what the rest may cost by its boxes. There
/// are `count` queries. Returns the cost in box tests.
pub(crate) fn alone<N: Copy, Q: Query>(
    queries: impl IntoIterator<Item = (N, Q)>,
    count: impl Fn() -> usize,
    mut leash: Leash,
    mut found: impl FnMut(N, TrianglePair) -> ControlFlow<()>,
    mut longer: impl FnMut(f64, &dyn Fn() -> f64) -> Option<f64>,
) -> (f64, End) {
    let most = if leash.deadline.is_some() { BETWEEN_LOOKS } else { u64::MAX };
    let (mut spent, mut looked) = (0.0, 0.0);
    for (done, (name, query)) in queries.into_iter().enumerate() {
        let (mut cursor, before) = (query.start(), spent);
        // Of what is over, nobody asks for more.
        while !cursor.is_done() {
            if spent >= leash.cost {
                let rest = || {
                    let here = rest(&query, &cursor);
                    let each = (spent + here) / (done + 1) as f64;
                    here + count().saturating_sub(done + 1) as f64 * each
                };
                match longer(spent, &rest) {
                    Some(cost) => leash.cost = cost,
                    None => return (spent, End::Outgrown),
                }
            }
            // A look takes as long as a small query.
            if spent - looked >= BETWEEN_LOOKS as f64 {
                looked = spent;
                if leash.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                    return (spent, End::Late);
                }
            }
            // All of them could be triangle tests.
            let left = (leash.cost - spent) / Work::TRIANGLE_COST;
            let step = (left as u64).clamp(STEP, most);
            let stopped = query.step(&mut cursor, step, |pair| found(name, pair)).is_break();
            spent = before + cursor.work.cost();
            if stopped {
                return (spent, End::Complete);
            }
        }
        spent = before + cursor.work.cost();
    }
    (spent, End::Complete)
}

/// The work that is left of a query, by its boxes. The node pairs that waited longest are the largest by far:
/// the others are parts of node pairs that were as large.
fn rest(query: &impl Query, cursor: &Cursor) -> f64 {
    cursor.pending().iter().take(LARGEST).map(|n| estimate(query, *n)).sum()
}
