//! Where a traversal stopped: the node pairs still to be visited, the place inside the topmost leaf pair, the
//! work done and the rest of the budget.

use super::NodePair;
use crate::bvh::MAX_DEPTH;
use crate::index::{at, at_mut, range};
use core::ops::ControlFlow;

/// Work done, which the cost |n| = m1 + k·m2 of the paper counts (section 2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Box tests (m1).
    pub box_tests: u64,
    /// Triangle tests (m2): triangle pairs whose own boxes overlap.
    pub triangle_tests: u64,
}

/// The work done and the tests that may still be done.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    work: Work,
    /// The triangle pairs of the topmost leaf pair that are done, in the order of their bits.
    done: u32,
    /// Tests left; at most 0 once the budget is spent.
    left: i64,
}

impl Budget {
    /// The triangle pairs of the topmost leaf pair that are still to be tested, as bits.
    pub(super) fn open(&self) -> u64 {
        after(self.done)
    }

    pub(super) fn is_inside_leaf_pair(&self) -> bool {
        self.done != 0
    }

    pub(super) fn is_spent(&self) -> bool {
        self.left <= 0
    }

    pub(super) fn refill(&mut self, tests: u64) {
        self.left = i64::try_from(tests).unwrap_or(i64::MAX);
    }

    pub(super) fn spend_box_tests(&mut self, tests: u32) {
        self.work.box_tests += u64::from(tests);
        self.left -= i64::from(tests);
    }

    /// Calls `visit` for each bit of `left`, the triangle pairs of a leaf pair that are still undecided of those
    /// `tested`, until it breaks or the budget is spent; the traversal then resumes inside the leaf pair.
    #[inline(always)]
    pub(super) fn decide(
        &mut self,
        mut tested: u64,
        mut left: u64,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.done = 0;
        if i64::from(tested.count_ones()) > self.left {
            tested &= self.cut(tested);
            left &= tested;
        }
        let mut flow = ControlFlow::Continue(());
        while left != 0 && flow.is_continue() {
            let bit = left.trailing_zeros();
            left &= left - 1;
            flow = visit(bit);
            if flow.is_break() {
                // The tests after this pair count when their turn comes.
                self.done = bit + 1;
                tested &= !after(self.done);
            }
        }
        // A leaf pair without tests costs one, since it has to be looked at.
        let tests = tested.count_ones();
        self.work.triangle_tests += u64::from(tests);
        self.left -= i64::from(tests.max(1));
        flow
    }

    /// The pairs up to the end of the budget, from which the traversal resumes.
    #[cold]
    #[inline(never)]
    fn cut(&mut self, mut tested: u64) -> u64 {
        for _ in 1..self.left {
            tested &= tested - 1;
        }
        self.done = tested.trailing_zeros() + 1;
        !after(self.done)
    }
}

/// The bits from `first` on.
fn after(first: u32) -> u64 {
    u64::MAX.checked_shl(first).unwrap_or(0)
}

/// The most pending node pairs. A step pops one and pushes at most 16. Each of these is two levels deeper in
/// either tree, or a leaf there, so at most `MAX_DEPTH / 2` steps follow one another downwards.
const STACK: usize = 15 * MAX_DEPTH.div_ceil(2) + 1;

/// The progress of a query: start one with [`Query::start`](super::Query::start), pass it to `page`, `step` or `visit`
/// until [`Cursor::is_done`].
///
/// Less than 4 KiB, without allocation; a copy is a bookmark. Use it with the query that made it.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    stack: [NodePair; STACK],
    len: usize,
    pub(super) budget: Budget,
}

impl Cursor {
    /// A cursor at the start of the subtree of the BVTT below `n`, for a worker that traverses from a node of its
    /// front; `None` is the empty subtree.
    #[inline]
    #[must_use]
    pub fn at(n: impl Into<Option<NodePair>>) -> Self {
        let budget = Budget { work: Work::default(), done: 0, left: 0 };
        let mut cursor = Self { stack: [NodePair::ROOT; STACK], len: 0, budget };
        if let Some(n) = n.into() {
            cursor.push(n);
        }
        cursor
    }

    /// Moves to the start of the subtree below `n`. [`Cursor::work`] goes on counting.
    pub fn restart(&mut self, n: NodePair) {
        (self.len, self.budget.done) = (0, 0);
        self.push(n);
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.len == 0
    }

    /// The node pairs below which not everything has been visited, the next one last: a front of the rest of the traversal.
    #[must_use]
    pub fn pending(&self) -> &[NodePair] {
        range(&self.stack, 0, self.len as u32)
    }

    /// Takes out the pending node pairs below which nothing has been visited, for other cursors to start from. This cursor
    /// keeps the leaf pair in which the last step ended, if it did not end between two nodes.
    pub fn take_pending(&mut self) -> &[NodePair] {
        let pending = core::mem::take(&mut self.len);
        if self.budget.is_inside_leaf_pair() {
            let top = *at(&self.stack, pending - 1);
            let first = core::mem::replace(at_mut(&mut self.stack, 0), top);
            *at_mut(&mut self.stack, pending - 1) = first;
            self.len = 1;
        }
        range(&self.stack, self.len as u32, (pending - self.len) as u32)
    }

    /// The work done so far.
    #[must_use]
    pub fn work(&self) -> Work {
        self.budget.work
    }

    #[inline]
    pub(super) fn push(&mut self, n: NodePair) {
        // There is room by the proof at STACK.
        *at_mut(&mut self.stack, self.len) = n;
        self.len += 1;
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<NodePair> {
        self.len = self.len.checked_sub(1)?;
        self.stack.get(self.len).copied()
    }
}
