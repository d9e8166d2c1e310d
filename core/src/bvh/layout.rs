//! The two layouts of a node: [`Node`], the standard one of 32 bytes, and
//! [`CompactNode`](super::CompactNode) of 16.
//!
//! One traversal serves both: it asks a node whether it is a leaf, for its children or its range of the order, and
//! for its box. A node has the same index in both layouts of a tree, so a front of one is a front of the other.

use crate::Aabb;
use crate::aabb::Bounds;
use crate::simd::Box4;
use bytemuck::{Pod, Zeroable};
use core::fmt::Debug;

/// A layout of BVH nodes: [`Node`] or [`CompactNode`](super::CompactNode).
#[expect(private_bounds, reason = "sealed: what a traversal asks of a node is internal")]
pub trait Layout: TreeNode {}

impl Layout for Node {}

/// The questions that a traversal asks of a node.
pub(crate) trait TreeNode: Copy + Debug + 'static {
    /// The data that all boxes of a tree share.
    type Grid: Copy + Debug;

    /// How many nodes a tree has that is one leaf.
    const LONE: usize;

    /// The grid of a tree; `None` if `nodes` lacks it.
    fn grid(nodes: &[Self]) -> Option<Self::Grid>;

    fn is_leaf(&self) -> bool;

    /// Index of the left child of an inner node; the right child is next to it.
    fn left(&self) -> u32;

    /// Range of the order that a leaf holds: its first entry, and how many.
    fn leaf_range(&self) -> [u32; 2];

    /// The box, finite in every tree that can be posed.
    fn bounds(&self, grid: &Self::Grid) -> Bounds;

    /// Four boxes.
    fn boxes(grid: &Self::Grid, nodes: [&Self; 4]) -> Box4;
}

/// A BVH node of the standard layout: 32 bytes, the same on the CPU and in a storage buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Smallest corner of the box.
    pub min: [f32; 3],
    /// Leaf: index of its first entry in the order. Inner node: index of its left child; the right child is next
    /// to it.
    pub first: u32,
    /// Largest corner of the box.
    pub max: [f32; 3],
    /// Leaf: how many triangles it holds. Inner node: 0.
    pub count: u32,
}

impl Node {
    /// A node with the empty box, to initialise buffers.
    pub const EMPTY: Self = Self { min: Aabb::EMPTY.min, first: 0, max: Aabb::EMPTY.max, count: 0 };

    /// The box of the node.
    #[inline]
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }

    /// Whether the node holds triangles rather than children.
    #[inline]
    #[must_use]
    pub fn is_leaf(&self) -> bool {
        self.count != 0
    }

    pub(crate) fn set_aabb(&mut self, aabb: &Aabb) {
        self.min = aabb.min;
        self.max = aabb.max;
    }
}

impl TreeNode for Node {
    type Grid = ();

    const LONE: usize = 1;

    fn grid(_: &[Self]) -> Option<()> {
        Some(())
    }

    #[inline(always)]
    fn is_leaf(&self) -> bool {
        self.count != 0
    }

    #[inline(always)]
    fn left(&self) -> u32 {
        self.first
    }

    #[inline(always)]
    fn leaf_range(&self) -> [u32; 2] {
        [self.first, self.count]
    }

    #[inline(always)]
    fn bounds(&self, (): &()) -> Bounds {
        Bounds::new(&self.aabb())
    }

    #[inline(always)]
    fn boxes((): &(), nodes: [&Self; 4]) -> Box4 {
        // Both halves of a node are a corner and a word.
        Box4::transposed(nodes.map(|node| bytemuck::must_cast(*node)))
    }
}
