//! The bounding volume test tree (BVTT) and the one walk over it.
//!
//! A BVTT node is a pair of BVH nodes whose boxes overlap; its children are the overlapping pairs of
//! their children (Zhang & Kim 2014, section 2.1). The tree is never stored. The walk goes down two of
//! its levels in a step, all pairs of up to four nodes and four others, which suits vector units. It keeps a stack of
//! pending nodes of fixed size and no recursion; stack and place inside the current leaf pair
//! together are a [`Cursor`], with which any query can stop after any triangle pair and go on later.
//! That is what makes a full output buffer harmless, and what lets a query be spread over frames: a walk
//! also stops when it has used up a budget of tests, see [`Query::step`](crate::bvtt::Query::step).

mod block;
mod block_pairs;
#[cfg(test)]
mod block_tests;
mod cursor;
mod pair;
mod pair_tree;
mod planes;
mod query;
mod self_collision;
mod self_tree;
mod wide_node;

pub(crate) use cursor::Progress;
pub use cursor::{Cursor, Work};
pub use pair::{PairQuery, Placed};
pub use query::Query;
pub use self_collision::SelfQuery;

pub(crate) use block::{Block, Blocks};
pub(crate) use block_pairs::Pairs;
pub(crate) use pair_tree::{PairTree, Side};
pub(crate) use self_tree::SelfTree;
pub(crate) use wide_node::Family;

use crate::aabb::Bounds;
use crate::simd::{Eight, Simd, Task, VECTORS, widest};
use crate::triangle::{Accuracy, Inexact, intersects};
use core::ops::ControlFlow;
use cursor::{FULL, after};

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
    for (row, node) in b.nodes().enumerate() {
        let mut found = a.boxes.overlapping(&b.boxes.splat(row)) & lanes(row);
        while found != 0 {
            push(NodePair { a: a.node(found.trailing_zeros()), b: node });
            found &= found - 1;
        }
    }
}

/// Whether triangles of two blocks that share no vertex meet.
#[inline(always)]
fn meet(a: &Block, i: u32, b: &Block, j: u32, inexact: Option<Inexact>) -> bool {
    let (a, b) = (a.triangle(i), b.triangle(j));
    match inexact {
        None => intersects(&a, &b, Accuracy::Exact),
        Some(meet) => meet(&a, &b),
    }
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
    let walk = Walk { tree, cursor, visit };
    if VECTORS { widest(walk) } else { walk.through::<f32>() }
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
    fn run<S: Eight>(self) -> ControlFlow<()> {
        self.through::<S>()
    }
}

impl<T: Bvtt> Walk<'_, '_, T> {
    #[inline(always)]
    fn through<S: Simd>(self) -> ControlFlow<()> {
        let Self { tree, cursor, visit } = self;
        let mut kept = [Blocks::ZERO; 2];
        kept.iter_mut().for_each(Blocks::forget);
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
