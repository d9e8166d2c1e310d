//! Work stealing: rayon's recursive join over the BVTT, in which idle threads steal subtrees.

use crate::control::Control;
use crate::front::Start;
use crate::output::Output;
use crate::report::sum;
use pfront_core::bvtt::{Cursor, NodePair, Query, Work};
use std::sync::{Mutex, PoisonError};

/// A node pair with at most this many triangles below both sides together is traversed as a whole.
const CUT_OFF: u64 = 512;

/// A traversal by stealing.
pub(crate) struct Stealing<'s, Q, N, O> {
    queries: &'s [Q],
    new_output: N,
    control: &'s Control,
    /// An output for each subtree that was traversed as a whole, and all work.
    found: Mutex<(Vec<O>, Work)>,
}

impl<'s, Q: Query + Sync, O: Output, N: Fn() -> O + Sync> Stealing<'s, Q, N, O> {
    pub(crate) fn new(queries: &'s [Q], new_output: N, control: &'s Control) -> Self {
        Self { queries, new_output, control, found: Mutex::default() }
    }

    pub(crate) fn found(self) -> (Vec<O>, Work) {
        self.found.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Traverses all that lies below `starts`, by halves.
    pub(crate) fn run(&self, starts: &[Start]) {
        match starts {
            [] => (),
            [one] => self.node(*one),
            _ => {
                let (left, right) = starts.split_at(starts.len() / 2);
                rayon::join(|| self.run(left), || self.run(right));
            }
        }
    }

    fn node(&self, start: Start) {
        let query = &self.queries[start.query as usize];
        if self.control.is_over() {
            return;
        }
        let [a, b] = query.triangles_below(start.pair).map(u64::from);
        let (mut children, mut count) = ([start; 4], 0);
        let mut push = |pair: NodePair| {
            children[count].pair = pair;
            count += 1;
        };
        let tests = if a + b > CUT_OFF {
            query.children(start.pair, &mut |child, _| push(child))
        } else {
            0
        };
        if tests == 0 {
            let (mut output, mut cursor) = ((self.new_output)(), Cursor::at(start.pair));
            self.control.traverse(query, start.query, &mut cursor, &mut output, u64::MAX);
            self.add(cursor.work, Some(output));
        } else {
            self.add(Work { box_tests: tests.into(), triangle_tests: 0 }, None);
            self.run(&children[..count]);
        }
    }

    fn add(&self, work: Work, output: Option<O>) {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        found.0.extend(output);
        found.1 = sum(found.1, work);
    }
}
