//! The bounding volume test tree (BVTT) and the one walk over it.
//!
//! A BVTT node is a pair of BVH nodes whose boxes overlap; its children are the overlapping pairs of
//! their children (Zhang & Kim 2014, section 2.1). The tree is never stored. The walk goes down two of
//! its levels in a step, all pairs of up to four nodes and four others, which suits vector units. It keeps a stack of
//! pending nodes of fixed size and no recursion; stack and place inside the current leaf pair
//! together are a [`Cursor`], with which any query can stop after any triangle pair and go on later.
//! That is what makes a full output buffer harmless, and what lets a query be spread over frames: a walk
//! also stops when it has used up a budget of tests, see [`Query::step`](crate::query::Query::step).

mod pair;
mod within;

pub(crate) use pair::{PairTree, Side};
pub(crate) use within::SelfTree;

use crate::aabb::Bounds;
use crate::bvh::MAX_DEPTH;
use crate::lanes::{Block, Blocks, Family, Pairs, Simd, Task, widest};
use crate::triangle::{Accuracy, intersects};
use core::ops::ControlFlow;

/// A BVTT node: a node of the first BVH and one of the second.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct NodePair {
    /// Index of the node of the first BVH.
    pub a: u32,
    /// Index of the node of the second BVH; of the same BVH in self-collision.
    pub b: u32,
}

/// Two triangles that meet: indices into the triangles of the first and the second mesh, or of one
/// mesh with `a < b`. The order is that of `a`, then `b`.
#[repr(C)]
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    bytemuck::Pod,
    bytemuck::Zeroable,
)]
pub struct TrianglePair {
    /// Triangle of the first mesh.
    pub a: u32,
    /// Triangle of the second mesh.
    pub b: u32,
}

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
    skip: u32,
    work: Work,
    /// How many tests may still be done; below zero if the last step took more.
    budget: i64,
}

/// With more node pairs pending than this, steps go down one level instead of two.
const FULL: usize = 64;

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
    len: usize,
    progress: Progress,
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

    /// What the walk has done so far.
    #[must_use]
    pub fn work(&self) -> Work {
        self.progress.work
    }

    #[inline]
    fn push(&mut self, n: NodePair) {
        // In bounds by the proof at STACK.
        self.stack[self.len] = n;
        self.len += 1;
    }

    #[inline]
    fn pop(&mut self) -> Option<NodePair> {
        self.len = self.len.checked_sub(1)?;
        Some(self.stack[self.len])
    }
}

/// A BVTT: of two meshes, or of one with itself.
pub(crate) trait Bvtt {
    /// The root, if its boxes overlap.
    fn root(&self) -> Option<NodePair>;

    /// Whether both are leaves.
    fn is_leaf(&self, n: NodePair) -> bool;

    /// Hands on every child and its boxes, in ascending order; returns the number of box tests.
    fn children(&self, n: NodePair, push: impl FnMut(NodePair, [&Bounds; 2])) -> u32;

    /// Hands on the overlapping pairs of what lies two levels below, see [`Family`]; returns the number
    /// of box tests.
    fn grandchildren(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32;

    /// Visits the triangle pairs of a leaf pair that meet, from where `progress` is on and as far as its
    /// budget lasts, see [`decide`].
    fn leaf<S: Simd>(
        &self,
        n: NodePair,
        kept: &mut [Blocks; 2],
        progress: &mut Progress,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()>;
}

/// What is done with a pair. Not a type parameter: one walk for each kind of tree is enough machine
/// code, and a hit costs far more to find than to hand on.
pub(crate) type Visit<'v> = dyn FnMut(TrianglePair) -> ControlFlow<()> + 'v;

/// The overlapping pairs of two families: of each node of the second with the first's in `lanes` of it.
#[inline(always)]
fn family_pairs(
    [a, b]: [&Family; 2],
    lanes: impl Fn(usize) -> u32,
    mut push: impl FnMut(NodePair),
) {
    for (row, &node) in b.nodes().iter().enumerate() {
        let mut found = a.boxes.overlapping(&b.boxes.splat(row)) & lanes(row);
        while found != 0 {
            push(NodePair { a: a.nodes()[found.trailing_zeros() as usize], b: node });
            found &= found - 1;
        }
    }
}

/// Whether triangles of two blocks that share no vertex meet.
#[inline]
fn meet(a: &Block, i: usize, b: &Block, j: usize, accuracy: Accuracy) -> bool {
    intersects(&a.triangle(i), &b.triangle(j), accuracy)
}

/// Decides those that are left of the pairs of two leaves, by their bits, until `visit` breaks or the
/// budget is used up; `skip` is 0 again if nothing remains.
#[inline(always)]
fn decide(
    pairs: Pairs,
    progress: &mut Progress,
    mut visit: impl FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let Pairs { mut tested, mut left, .. } = pairs;
    progress.skip = 0;
    if i64::from(tested.count_ones()) > progress.budget {
        let affordable = progress.cut(tested);
        tested &= affordable;
        left &= affordable;
    }
    while left != 0 {
        let bit = left.trailing_zeros();
        left &= left - 1;
        if visit(bit).is_break() {
            // The others count when their turn comes.
            progress.skip = bit + 1;
            progress.spend(tested & !after(bit + 1));
            return ControlFlow::Break(());
        }
    }
    progress.spend(tested);
    ControlFlow::Continue(())
}

impl Progress {
    /// Of a leaf pair with more tests than the budget allows, the combinations up to where it ends, and
    /// there the next step begins.
    #[cold]
    #[inline(never)]
    fn cut(&mut self, mut tested: u64) -> u64 {
        for _ in 1..self.budget {
            tested &= tested - 1;
        }
        self.skip = tested.trailing_zeros() + 1;
        !after(self.skip)
    }

    /// Counts the tests of a leaf pair. One without any counts against the budget too, since it has to be
    /// looked at.
    #[inline]
    fn spend(&mut self, tested: u64) {
        let tests = tested.count_ones();
        self.work.triangle_tests += u64::from(tests);
        self.budget -= i64::from(tests.max(1));
    }
}

/// Of 64 combinations, those without the first `skip`.
#[inline]
fn after(skip: u32) -> u64 {
    u64::MAX.checked_shl(skip).unwrap_or(0)
}

/// Goes on from `cursor` until `visit` breaks, the budget is used up or nothing is left.
pub(crate) fn walk<T: Bvtt>(
    tree: &T,
    cursor: &mut Cursor,
    budget: u64,
    visit: &mut Visit<'_>,
) -> ControlFlow<()> {
    // Setting up takes longer than many a query does.
    if cursor.is_done() || budget == 0 {
        return ControlFlow::Continue(());
    }
    // No walk lasts longer.
    cursor.progress.budget = i64::try_from(budget).unwrap_or(i64::MAX);
    widest(Walk { tree, cursor, visit })
}

/// A walk yet to be done.
struct Walk<'w, 'v, T> {
    tree: &'w T,
    cursor: &'w mut Cursor,
    visit: &'w mut Visit<'v>,
}

impl<T: Bvtt> Task for Walk<'_, '_, T> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let Self { tree, cursor, visit } = self;
        let mut kept = [Blocks::EMPTY; 2];
        while let Some(n) = cursor.pop() {
            if tree.is_leaf(n) {
                let end = tree.leaf::<S>(n, &mut kept, &mut cursor.progress, visit);
                if cursor.progress.skip != 0 {
                    cursor.push(n);
                }
                end?;
            } else {
                let tests = if cursor.len <= FULL {
                    tree.grandchildren(n, |below| cursor.push(below))
                } else {
                    tree.children(n, |child, _| cursor.push(child))
                };
                cursor.progress.work.box_tests += u64::from(tests);
                cursor.progress.budget -= i64::from(tests);
            }
            if cursor.progress.budget <= 0 {
                break;
            }
        }
        ControlFlow::Continue(())
    }
}
