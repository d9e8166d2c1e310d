//! The error of arrays that are no BVH.

use super::{MAX_DEPTH, MAX_LEAF_SIZE};
use crate::CapacityError;

/// The fault of arrays that are not a BVH of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BvhError {
    /// An array has another length: `order` one entry per triangle, `nodes` those that the root leads to and the unused
    /// slot 1, which a lone root does without.
    #[error("`{array}` has {found} elements instead of {expected}")]
    Length {
        /// The array.
        array: &'static str,
        /// How many elements it should have.
        expected: usize,
        /// How many it has.
        found: usize,
    },
    /// An entry of the order names no triangle, or one that an earlier entry names, or lies in no leaf.
    #[error("order entry {entry} is out of range, names a triangle again, or is in no leaf")]
    Order {
        /// An entry at fault.
        entry: usize,
    },
    /// A left child at an odd index, out of range, not after its parent, or deeper than [`MAX_DEPTH`].
    #[error(
        "the left child of node {node} must be even, in range, after its parent and at most \
         {MAX_DEPTH} levels below the root"
    )]
    Child {
        /// The parent.
        node: usize,
    },
    /// A leaf holds more than [`MAX_LEAF_SIZE`] triangles, or its range is out of bounds or does not
    /// begin where that of the leaf to its left ends: also when a node has two parents.
    #[error(
        "leaf {node} must hold at most {MAX_LEAF_SIZE} triangles and continue the order where the \
         leaf to its left ends"
    )]
    Leaf {
        /// The leaf at fault.
        node: usize,
    },
    /// A box is not finite, or does not contain the boxes or triangles below it.
    #[error("the box of node {node} must be finite and contain the boxes below it: refit first")]
    Box {
        /// The node at fault.
        node: usize,
    },
    /// An array is longer than a blob can tell.
    #[error("`{array}` has {found} elements, and may have at most {most}: split the mesh")]
    TooMany {
        /// The array.
        array: &'static str,
        /// How many elements it may have.
        most: usize,
        /// How many it has.
        found: usize,
    },
    /// A buffer is too small.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
}
