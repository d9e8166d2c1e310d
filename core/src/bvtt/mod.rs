//! The bounding volume test tree (BVTT), its one traversal, and the queries that it answers.
//!
//! A BVTT node is a pair of BVH nodes whose boxes overlap; its children are the overlapping pairs of
//! their children (Zhang & Kim 2014, section 2.1). The tree is never stored. There are two of them: of
//! two meshes ([`PairQuery`]) and of one mesh with itself ([`SelfQuery`]).
//!
//! How to read this folder: `traversal` is the loop; `cursor` is where it stopped; `pair` and
//! `self_collision` say what the children of a node pair are and which triangles meet in a leaf pair;
//! `wide_node` and `block` put boxes and triangles into vector lanes for them, `block_pairs` and `planes`
//! reject most triangle pairs there; `query` has the verbs of the public interface.
//!
//! # Where we depart from the paper
//! The traversal descends two levels at a time, all pairs of up to four nodes and four others, since a
//! single box test is too small for a vector unit. Box tests, and so costs, are counted on these pairs.

mod block;
mod block_pairs;
#[cfg(test)]
mod block_tests;
mod cursor;
mod pair;
mod planes;
mod query;
mod self_collision;
mod traversal;
mod wide_node;

pub use cursor::{Cursor, Work};
pub use pair::{PairQuery, PosedBvh};
pub use query::Query;
pub use self_collision::SelfQuery;

pub(crate) use wide_node::WideNode;

use crate::Aabb;
use crate::bvh::{Bvh, Layout};

/// A BVTT node: a node of the first BVH and one of the second.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct NodePair {
    /// Index of the node of the first BVH.
    pub a: u32,
    /// Index of the node of the second BVH; of the same BVH in self-collision.
    pub b: u32,
}

/// Two triangles that intersect: indices into the triangles of the first and the second mesh, or of one
/// mesh with `a < b`. Pairs are ordered by `a`, then by `b`.
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

/// A BVTT, one node at a time. A [front](crate::front) is a cut through it.
///
/// # Panics
/// Methods may panic if a node pair is not one of this tree.
pub trait Bvtt {
    /// The root, if its boxes overlap.
    fn root(&self) -> Option<NodePair>;

    /// Passes on the children of a node that overlap, at most four and in ascending order, each with
    /// its [`Bvtt::boxes`]. Returns the number of box tests: 0 for a leaf pair, which has no children.
    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32;

    /// The boxes of both nodes in one frame: that of the query, or of the first mesh.
    fn boxes(&self, n: NodePair) -> [Aabb; 2];

    /// The number of triangles below each node.
    ///
    /// # Complexity
    /// O(depth).
    fn triangles_below(&self, n: NodePair) -> [u32; 2];

    /// About the edge of a leaf's box. The extent of an overlap that is smaller than this says nothing of its cost.
    fn leaf_edge(&self) -> f32;
}

impl<T: Bvtt> Bvtt for &T {
    fn root(&self) -> Option<NodePair> {
        T::root(self)
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        T::children(self, n, push)
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        T::boxes(self, n)
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        T::triangles_below(self, n)
    }

    fn leaf_edge(&self) -> f32 {
        T::leaf_edge(self)
    }
}

impl NodePair {
    /// The pair of roots.
    pub(crate) const ROOT: Self = Self { a: 0, b: 0 };

    /// The pairs of the children of both nodes, in ascending order; a leaf counts as its only child. A leaf pair has
    /// none.
    pub(crate) fn split<A: Layout, B: Layout>(
        self,
        a: &Bvh<'_, A>,
        b: &Bvh<'_, B>,
    ) -> impl Iterator<Item = Self> {
        let (of_a, of_b) = (halves(a, self.a), halves(b, self.b));
        let pairs = if of_a.len() + of_b.len() == 2 { 0..0 } else { of_a };
        pairs.flat_map(move |a| of_b.clone().map(move |b| Self { a, b }))
    }
}

/// The children of a node, or a leaf itself.
fn halves<L: Layout>(bvh: &Bvh<'_, L>, index: u32) -> core::ops::Range<u32> {
    let node = bvh.node(index);
    if node.is_leaf() { index..index + 1 } else { node.left()..node.left() + 2 }
}
