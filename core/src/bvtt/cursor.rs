//! The position at which a traversal stopped: the node pairs still to be visited, the place inside the topmost leaf
//! pair, the work done and the rest of the budget.

use super::NodePair;
use crate::bvh::MAX_DEPTH;
use core::ops::{Add, ControlFlow};

/// Work done, which the cost |n| = m1 + k·m2 of the paper counts (section 2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Box tests (m1).
    pub box_tests: u64,
    /// Triangle tests (m2): triangle pairs whose own boxes overlap, also those that planes then separate.
    pub triangle_tests: u64,
}

impl Work {
    /// k, the cost of a triangle test in box tests: measured on x86-64, and the same on all processors, so that fronts are alike.
    pub const TRIANGLE_COST: f64 = 6.5;

    /// The cost |n| = m1 + k·m2, in box tests.
    #[must_use]
    pub fn cost(self) -> f64 {
        self.box_tests as f64 + Self::TRIANGLE_COST * self.triangle_tests as f64
    }

    /// Tests of both kinds, which a budget counts.
    #[must_use]
    pub fn tests(self) -> u64 {
        self.box_tests + self.triangle_tests
    }
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            box_tests: self.box_tests + other.box_tests,
            triangle_tests: self.triangle_tests + other.triangle_tests,
        }
    }
}

/// The most pending node pairs. A step pops one and pushes at most 16, so the stack grows by at most 15 a step. Each node
/// pair pushed is two levels deeper in one tree or both, or has a leaf there, so a path downwards has at most
/// `MAX_DEPTH / 2` steps.
pub(super) const STACK: usize = 15 * MAX_DEPTH.div_ceil(2) + 1;

/// The progress of a query: start one with [`Query::start`](super::Query::start), pass it to `page`, `step` or `visit`
/// until [`Cursor::is_done`].
///
/// A cursor takes less than 4 KiB and allocates nothing; a copy is a bookmark. Use it with the query that made it.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    stack: [NodePair; STACK],
    len: usize,
    /// The work done so far.
    pub work: Work,
    /// The first triangle pair of the topmost leaf pair that is still to be tested, as the index of its bit; 0 unless
    /// the last step ended inside that leaf pair.
    next_bit: u32,
    /// Tests that the present step may still do; at most 0 once its budget is spent.
    tests_left: i64,
}

impl Cursor {
    /// A cursor at the start of the subtree of the BVTT below `n`, for a worker that traverses from a node of its
    /// front; `None` is the empty subtree.
    #[inline]
    #[must_use]
    pub fn at(n: impl Into<Option<NodePair>>) -> Self {
        let (stack, work) = ([NodePair::ROOT; STACK], Work::default());
        let mut cursor = Self { stack, len: 0, work, next_bit: 0, tests_left: 0 };
        if let Some(n) = n.into() {
            cursor.push(n);
        }
        cursor
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.len == 0
    }

    /// The node pairs below which not everything has been visited, the next one last: a front of the rest of the traversal.
    /// The last may be a leaf pair of which a part has been visited: to go on elsewhere, use [`Cursor::take_pending`].
    #[must_use]
    pub fn pending(&self) -> &[NodePair] {
        &self.stack[..self.len]
    }

    /// Takes out the pending node pairs below which nothing has been visited, for other cursors to start from. This cursor
    /// keeps the leaf pair in which the last step ended, if it did not end between two nodes.
    pub fn take_pending(&mut self) -> &[NodePair] {
        let pending = core::mem::take(&mut self.len);
        if self.is_inside_leaf_pair() {
            let top = self.stack[pending - 1];
            let first = core::mem::replace(&mut self.stack[0], top);
            self.stack[pending - 1] = first;
            self.len = 1;
        }
        &self.stack[self.len..][..pending - self.len]
    }

    /// Takes out half of the pending node pairs, as a cursor for another worker: every second one from the bottom on, so
    /// that both get large ones and small ones. `None` if there are not two. This cursor keeps the leaf pair in which the
    /// last step ended, and its counts of work.
    pub fn take_half(&mut self) -> Option<Self> {
        let given = self.len - usize::from(self.is_inside_leaf_pair());
        if self.len < 2 {
            return None;
        }
        let (mut other, mut kept) = (Self::at(None), 0);
        for index in 0..self.len {
            let n = self.stack[index];
            if index < given && index % 2 == 0 {
                other.push(n);
            } else {
                self.stack[kept] = n;
                kept += 1;
            }
        }
        self.len = kept;
        Some(other)
    }

    /// Takes out the pending node pair that would be visited last, for another worker. `None` if there are not two, so that
    /// this cursor keeps its order and the leaf pair in which the last step ended.
    ///
    /// # Complexity
    /// O(pending node pairs).
    pub fn take_last(&mut self) -> Option<NodePair> {
        if self.len < 2 {
            return None;
        }
        let last = self.stack[0];
        self.len -= 1;
        for index in 0..self.len {
            let n = self.stack[index + 1];
            self.stack[index] = n;
        }
        Some(last)
    }

    #[inline]
    pub(super) fn push(&mut self, n: NodePair) {
        // There is room by the proof at STACK.
        self.stack[self.len] = n;
        self.len += 1;
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<NodePair> {
        self.len = self.len.checked_sub(1)?;
        self.stack.get(self.len).copied()
    }

    pub(super) fn set_budget(&mut self, tests: u64) {
        self.tests_left = i64::try_from(tests).unwrap_or(i64::MAX);
    }

    pub(super) fn is_budget_spent(&self) -> bool {
        self.tests_left <= 0
    }

    pub(super) fn spend_box_tests(&mut self, tests: u32) {
        self.work.box_tests += u64::from(tests);
        self.tests_left -= i64::from(tests);
    }

    pub(super) fn is_inside_leaf_pair(&self) -> bool {
        self.next_bit != 0
    }

    /// The triangle pairs of the topmost leaf pair that are still to be tested, as bits.
    pub(super) fn bits_left(&self) -> u64 {
        bits_from(self.next_bit)
    }

    /// Calls `visit` for each bit of `visited` until it breaks or the budget is spent; the traversal then resumes
    /// inside this leaf pair. Bits are triangle pairs of a leaf pair. Every bit of `tested`, which contains
    /// `visited`, counts as a triangle test.
    #[inline(always)]
    pub(super) fn for_each_within_budget(
        &mut self,
        mut tested: u64,
        mut visited: u64,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.next_bit = 0;
        if i64::from(tested.count_ones()) > self.tests_left {
            tested = self.truncate_at_budget(tested);
            visited &= tested;
        }
        let mut flow = ControlFlow::Continue(());
        while visited != 0 && flow.is_continue() {
            let bit = visited.trailing_zeros();
            visited &= visited - 1;
            flow = visit(bit);
            if flow.is_break() {
                // The tests after this pair count in the step that does them.
                self.next_bit = bit + 1;
                tested &= !bits_from(self.next_bit);
            }
        }
        // A leaf pair without triangle tests counts as one against the budget, since its triangles were loaded.
        let tests = tested.count_ones();
        self.work.triangle_tests += u64::from(tests);
        self.tests_left -= i64::from(tests.max(1));
        flow
    }

    /// The lowest bits of `tested`, as many as the budget has tests left. The traversal resumes after them.
    #[cold]
    #[inline(never)]
    fn truncate_at_budget(&mut self, tested: u64) -> u64 {
        let mut rest = tested;
        for _ in 1..self.tests_left {
            rest &= rest - 1;
        }
        self.next_bit = rest.trailing_zeros() + 1;
        tested & !bits_from(self.next_bit)
    }
}

/// The bits from `first` on.
fn bits_from(first: u32) -> u64 {
    u64::MAX.checked_shl(first).unwrap_or(0)
}
