//! Answering on the calling thread, within limits.

use crate::planner::TRIANGLE_COST;
use pfront_core::query::{Query, TrianglePair, Work};
use std::ops::ControlFlow;
use std::time::Instant;

/// How far a walk may go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leash {
    /// The most box and triangle tests.
    pub(crate) tests: u64,
    pub(crate) deadline: Option<Instant>,
}

/// How a walk ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum End {
    /// Nothing is left, or no more is wanted.
    #[default]
    Complete,
    /// Not over after as many tests as were allowed.
    Outgrown,
    /// Time ran out.
    Late,
}

/// Tests between two looks at the clock: some 20 us.
const BETWEEN_LOOKS: u64 = 8192;

/// Hands on what is found, with the name of the query, until it is told to stop. Returns the cost in box
/// tests.
pub(crate) fn alone<N: Copy, Q: Query>(
    queries: impl IntoIterator<Item = (N, Q)>,
    leash: Leash,
    mut found: impl FnMut(N, TrianglePair) -> ControlFlow<()>,
) -> (f64, End) {
    let Leash { mut tests, deadline } = leash;
    let late = || deadline.is_some_and(|deadline| Instant::now() >= deadline);
    let mut sum = 0.0;
    for (name, query) in queries {
        let mut cursor = query.start();
        let mut end = None;
        while end.is_none() && !cursor.is_done() {
            let before = count(cursor.work());
            let step = if deadline.is_some() { tests.min(BETWEEN_LOOKS) } else { tests };
            let stopped = query.step(&mut cursor, step, |pair| found(name, pair)).is_break();
            tests = tests.saturating_sub((count(cursor.work()) - before).max(1));
            end = match stopped {
                true => Some(End::Complete),
                false if cursor.is_done() => None,
                false if tests == 0 => Some(End::Outgrown),
                false => late().then_some(End::Late),
            };
        }
        sum += cost(cursor.work());
        if let Some(end) = end {
            return (sum, end);
        }
    }
    (sum, End::Complete)
}

fn count(work: Work) -> u64 {
    work.box_tests + work.triangle_tests
}

/// As one figure, in box tests.
pub(crate) fn cost(work: Work) -> f64 {
    work.box_tests as f64 + f64::from(TRIANGLE_COST) * work.triangle_tests as f64
}
