//! Answering on the calling thread, within limits.

use crate::planner::TRIANGLE_COST;
use pfront_core::query::{Query, TrianglePair, Work};
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
    /// It has cost what it may, and is not over.
    Outgrown,
    /// Time ran out.
    Late,
}

/// Tests between two looks at the clock: some 20 us.
const BETWEEN_LOOKS: u64 = 8192;
/// The fewest tests that are worth a step.
const STEP: u64 = 256;

/// Hands on what is found, with the name of the query, until it is told to stop. Returns the cost in box
/// tests.
pub(crate) fn alone<N: Copy, Q: Query>(
    queries: impl IntoIterator<Item = (N, Q)>,
    leash: Leash,
    mut found: impl FnMut(N, TrianglePair) -> ControlFlow<()>,
) -> (f64, End) {
    let late = || leash.deadline.is_some_and(|deadline| Instant::now() >= deadline);
    let most = if leash.deadline.is_some() { BETWEEN_LOOKS } else { u64::MAX };
    let mut before = 0.0;
    for (name, query) in queries {
        let mut cursor = query.start();
        loop {
            // All of them could be triangle tests.
            let left = (leash.cost - before - cost(cursor.work())) / f64::from(TRIANGLE_COST);
            let step = (left as u64).clamp(STEP, most);
            let stopped = query.step(&mut cursor, step, |pair| found(name, pair)).is_break();
            let now = before + cost(cursor.work());
            if stopped {
                return (now, End::Complete);
            } else if cursor.is_done() {
                before = now;
                break;
            } else if now >= leash.cost {
                return (now, End::Outgrown);
            } else if late() {
                return (now, End::Late);
            }
        }
    }
    (before, End::Complete)
}

/// As one figure, in box tests.
pub(crate) fn cost(work: Work) -> f64 {
    work.box_tests as f64 + f64::from(TRIANGLE_COST) * work.triangle_tests as f64
}
