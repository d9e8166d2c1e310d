//! Work stealing: rayon's recursive join over the BVTT, in which idle threads steal subtrees.

use crate::control::Control;
use crate::front::Start;
use crate::output::Output;
use crate::report::sum;
use pfront_core::bvtt::{Cursor, NodePair, Query, Work};
use std::collections::LinkedList;

/// A node pair with at most this many triangles below both sides together is traversed as a whole.
const CUT_OFF: u64 = 512;

/// A traversal by stealing.
pub(crate) struct Stealing<'s, Q, N> {
    pub(crate) queries: &'s [Q],
    pub(crate) new_output: N,
    pub(crate) control: &'s Control,
}

/// The outputs and the work of a subtree, which are joined on the way up in O(1): nothing is copied, and no thread waits
/// for a lock.
pub(crate) struct Found<O> {
    pub(crate) outputs: LinkedList<O>,
    pub(crate) work: Work,
}

impl<Q: Query + Sync, O: Output, N: Fn() -> O + Sync> Stealing<'_, Q, N> {
    /// Traverses all that lies below `starts`, by halves.
    pub(crate) fn run(&self, starts: &[Start]) -> Found<O> {
        match starts {
            [] => Found { outputs: LinkedList::new(), work: Work::default() },
            [one] => self.node(*one),
            _ => {
                let (left, right) = starts.split_at(starts.len() / 2);
                let (mut left, mut right) = rayon::join(|| self.run(left), || self.run(right));
                left.outputs.append(&mut right.outputs);
                left.work = sum(left.work, right.work);
                left
            }
        }
    }

    fn node(&self, start: Start) -> Found<O> {
        let query = &self.queries[start.query as usize];
        if self.control.is_over() {
            return self.run(&[]);
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
            output.finish();
            let outputs = Some(output).filter(|output| !output.is_empty());
            return Found { outputs: outputs.into_iter().collect(), work: cursor.work };
        }
        let mut found = self.run(&children[..count]);
        found.work.box_tests += u64::from(tests);
        found
    }
}
