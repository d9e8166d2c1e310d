//! The node of a BVH.

use crate::Aabb;
use crate::aabb::Bounds;
use crate::simd::Box4;
use bytemuck::{Pod, Zeroable};

/// A BVH node: 32 bytes, the same on the CPU and in a storage buffer.
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

    /// Index of the left child of an inner node; the right child is next to it.
    #[inline(always)]
    pub(crate) fn left(&self) -> u32 {
        self.first
    }

    /// The box, finite in every tree that can be posed.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> Bounds {
        Bounds::new(&self.aabb())
    }

    /// Four boxes.
    #[inline(always)]
    pub(crate) fn boxes(nodes: [&Self; 4]) -> Box4 {
        // Both halves of a node are a corner and a word.
        Box4::transposed(nodes.map(|node| bytemuck::must_cast(*node)))
    }
}
