//! How far a walk has come: the node pairs it still has to see, its place in the topmost leaf pair, the work
//! done and what is left of its budget.

use super::NodePair;
use crate::bvh::MAX_DEPTH;

/// What a walk has done: the cost |n| = m1 + k·m2 of the paper counts these (section 2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Box tests (m1).
    pub box_tests: u64,
    /// Triangle tests (m2): pairs whose own boxes overlap.
    pub triangle_tests: u64,
}

/// How far a walk has come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// Combinations of the topmost leaf pair that are done.
    pub(super) skip: u32,
    pub(super) work: Work,
    /// How many tests may still be done; below zero if the last step took more.
    pub(super) budget: i64,
}

impl Progress {
    /// Of a leaf pair with more tests than the budget allows, the combinations up to where it ends, and
    /// there the next step begins.
    #[cold]
    #[inline(never)]
    pub(super) fn cut(&mut self, mut tested: u64) -> u64 {
        for _ in 1..self.budget {
            tested &= tested - 1;
        }
        self.skip = tested.trailing_zeros() + 1;
        !after(self.skip)
    }

    /// Counts the tests of a leaf pair. One without any counts against the budget too, since it has to be
    /// looked at.
    #[inline]
    pub(super) fn spend(&mut self, tested: u64) {
        let tests = tested.count_ones();
        self.work.triangle_tests += u64::from(tests);
        self.budget -= i64::from(tests.max(1));
    }
}

/// Of 64 combinations, those without the first `skip`.
#[inline]
pub(super) fn after(skip: u32) -> u64 {
    u64::MAX.checked_shl(skip).unwrap_or(0)
}

/// With more node pairs pending than this, steps go down one level instead of two.
pub(super) const FULL: usize = 64;

/// Most node pairs a stack can hold. A step of two levels takes one of at most [`FULL`] + 1 and puts back
/// at most 16. A step of one level puts back at most four that lie a level deeper, so each level leaves
/// at most three behind; both trees descend together until one reaches a leaf and the other goes on,
/// which makes no more levels than the deeper tree has.
const STACK: usize = FULL + 16 + 3 * MAX_DEPTH;

/// Where a query stands: start one with `start`, pass it to `page` or `visit` until nothing is left.
///
/// Below 2.2 KiB, no allocation; a copy is a bookmark. It belongs to the query that made it.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    stack: [NodePair; STACK],
    pub(super) len: usize,
    pub(super) progress: Progress,
}

impl Cursor {
    pub(crate) fn new(root: Option<NodePair>) -> Self {
        let mut cursor = Self {
            stack: [NodePair::default(); STACK],
            len: 0,
            progress: Progress {
                skip: 0,
                work: Work { box_tests: 1, triangle_tests: 0 },
                budget: 0,
            },
        };
        if let Some(root) = root {
            cursor.push(root);
        }
        cursor
    }

    /// A walk over the part of a BVTT below one node, as a worker does from a node of its front.
    #[must_use]
    pub fn at(n: NodePair) -> Self {
        let mut cursor = Self::new(Some(n));
        cursor.progress.work = Work::default();
        cursor
    }

    /// Goes to another node without clearing the count of work.
    pub fn restart(&mut self, n: NodePair) {
        (self.len, self.progress.skip) = (0, 0);
        self.push(n);
    }

    /// Whether the walk is over.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.len == 0
    }

    /// The nodes below which nothing has been visited yet, with the one in which a step has ended: a cut through
    /// what is left of the BVTT. The last comes next.
    #[must_use]
    pub fn pending(&self) -> &[NodePair] {
        self.stack.get(..self.len).unwrap_or_default()
    }

    /// Takes out the pending node pairs below which nothing has been visited, for others to go on from. What is left to
    /// this cursor is the leaf pair in which the last step ended, if it did not end between two nodes.
    pub fn hand_over(&mut self) -> &[NodePair] {
        let pending = self.stack.get_mut(..self.len).unwrap_or_default();
        self.len = usize::from(self.progress.skip != 0);
        if self.len == 1
            && let [first, .., last] = &mut *pending
        {
            core::mem::swap(first, last);
        }
        pending.get(self.len..).unwrap_or_default()
    }

    /// What the walk has done so far.
    #[must_use]
    pub fn work(&self) -> Work {
        self.progress.work
    }

    #[inline]
    pub(super) fn push(&mut self, n: NodePair) {
        // There is room by the proof at STACK.
        if let Some(free) = self.stack.get_mut(self.len) {
            *free = n;
        }
        self.len += 1;
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<NodePair> {
        self.len = self.len.checked_sub(1)?;
        self.stack.get(self.len).copied()
    }
}
