//! The bounding volume hierarchy (BVH): one flat array of nodes, and an order of the triangles.
//!
//! A binary tree. The root is node 0 and slot 1 is unused; the two children of an inner node are siblings at an even
//! index and the next, so that they share a 64-byte cache line when the array is aligned to one. A child
//! comes after its parent: one backward pass over the array refits the whole tree. A leaf holds a range of the
//! order, an array of triangle indices; the ranges of the leaves, from left to right, follow one another.
//!
//! [`Node`](crate::Node) takes 32 bytes and is the same on CPU and GPU. Builds make trees of nodes, refits follow a deforming mesh,
//! [`Bvh::new`](crate::Bvh::new) checks arrays from elsewhere, and the crate `pfront-blob` stores a tree with its mesh.

pub(crate) mod arrays;
mod build;
mod check;
pub(crate) mod error;
pub(crate) mod node;
mod quality;
mod refit;
#[cfg(test)]
pub(crate) mod tests;

pub use build::{BuildOptions, BvhStorage, SahSteps, morton, sah};
pub use quality::{REBUILD_RATIO, quality};
pub use refit::{Refit, RefitRow, refit};

pub use crate::parallel::Join;
pub use crate::vertex_set::{Moved, mark_moved};

/// The deepest a node may lie below the root (the root has depth 0).
///
/// Builds keep it: they replace a split that could break it by one in the middle, and halving 2^31 − 1 triangles needs
/// at most 31 levels. Every traversal stack is sized from it.
pub const MAX_DEPTH: usize = 64;

/// The most triangles one leaf may hold.
pub const MAX_LEAF_SIZE: u32 = 8;

/// 2^23. A sum of it and a smaller positive number has no room for a fraction, so the lowest bits of such a float are
/// an integer: the number, rounded to the nearest.
const TO_BITS: f32 = 8_388_608.0;

/// The most nodes that the BVH of `triangles` triangles may have, whatever its leaf size.
///
/// A binary tree with n leaves has 2n − 1 nodes, and one slot is left unused to align siblings.
/// A tree that is one leaf has no second slot.
///
/// # Examples
/// ```
/// use pfront_core::{Node, bvh::node_bound};
/// static mut NODES: [Node; node_bound(1000)] = [Node::EMPTY; node_bound(1000)];
/// assert_eq!(node_bound(1000) * size_of::<Node>(), 64_000);
/// ```
#[must_use]
pub const fn node_bound(triangles: usize) -> usize {
    2 * triangles
}
