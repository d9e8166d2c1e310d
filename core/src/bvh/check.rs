//! The check that arrays are a BVH of a mesh.
//!
//! One preorder pass settles the structure without marking nodes. Children come after their parent, so every
//! path ends; the range of a leaf must begin where that of the leaf before it ended, so a node
//! reached twice is caught at its first leaf, and a tangled graph cannot take longer than a tree.

use super::{Bvh, Layout, MAX_DEPTH, MAX_LEAF_SIZE, preorder};
use crate::index::{at, range};
use crate::{Aabb, CapacityError};
use core::fmt;

/// How many words of scratch [`Bvh::new`] needs to check `triangles` triangles in one pass.
#[must_use]
pub const fn check_scratch_bound(triangles: usize) -> usize {
    triangles.div_ceil(u32::BITS as usize)
}

impl<N: Layout> Bvh<'_, N> {
    pub(super) fn check(&self, scratch: &mut [u32]) -> Result<(), BvhError> {
        let (found, expected) = (self.order.len(), self.mesh.triangles().len());
        if found != expected {
            return Err(BvhError::OrderLength { found, expected });
        }
        check_permutation(self.order, scratch)?;
        let (mut reached, mut covered) = (0, 0);
        preorder(self.nodes, |index, depth| {
            let node = at(self.nodes, index);
            reached += 1;
            let content = if node.is_leaf() {
                let [first, count] = node.leaf_range();
                let in_range = count as usize <= self.order.len() - covered;
                if first as usize != covered || count > MAX_LEAF_SIZE || !in_range {
                    return Err(BvhError::Leaf { node: index });
                }
                covered += count as usize;
                let triangles = range(self.order, first, count).iter();
                triangles.fold(Aabb::EMPTY, |a, &t| a.union(&Aabb::of(&self.mesh.triangle(t))))
            } else {
                let left = node.left() as usize;
                if left <= index || !left.is_multiple_of(2) || left + 1 >= self.nodes.len() {
                    return Err(BvhError::Child { node: index });
                }
                if depth == MAX_DEPTH {
                    return Err(BvhError::Depth { node: index });
                }
                let [a, b] = [left, left + 1].map(|n| Aabb::from(self.bounds(at(self.nodes, n))));
                a.union(&b)
            };
            let aabb = Aabb::from(self.bounds(node));
            let is_finite = aabb.min.iter().chain(&aabb.max).all(|x| x.is_finite());
            let fits = is_finite && aabb.contains(&content);
            if fits { Ok(()) } else { Err(BvhError::Box { node: index }) }
        })?;
        if covered != self.order.len() {
            return Err(BvhError::Uncovered { entry: covered });
        }
        // The reached nodes are all different, and slot 1 is never among them.
        let needed = match reached {
            0 => 0,
            1 => N::LONE,
            _ => reached + 1,
        };
        if needed != self.nodes.len() {
            return Err(BvhError::NodeCount { reached, found: self.nodes.len() });
        }
        Ok(())
    }
}

/// Whether `order` holds each of 0 … its length − 1 once; a pass marks as many as `scratch` can.
fn check_permutation(order: &[u32], scratch: &mut [u32]) -> Result<(), BvhError> {
    if !order.is_empty() && scratch.is_empty() {
        let needed = check_scratch_bound(order.len());
        return Err(BvhError::Capacity(CapacityError { buffer: "scratch", needed, capacity: 0 }));
    }
    if let Some(entry) = order.iter().position(|&t| t as usize >= order.len()) {
        return Err(BvhError::Order { entry });
    }
    let window = scratch.len().saturating_mul(u32::BITS as usize);
    for start in (0..order.len()).step_by(window.max(1)) {
        scratch.fill(0);
        for (entry, &triangle) in order.iter().enumerate() {
            // Triangles outside the window have their pass.
            let offset = (triangle as usize).wrapping_sub(start);
            if let Some(word) = scratch.get_mut(offset / u32::BITS as usize) {
                let mark = 1 << (offset % u32::BITS as usize);
                if *word & mark != 0 {
                    return Err(BvhError::Order { entry });
                }
                *word |= mark;
            }
        }
    }
    Ok(())
}

/// The fault of arrays that are not a BVH of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BvhError {
    /// The order does not have one entry per triangle.
    OrderLength {
        /// Entries given.
        found: usize,
        /// Triangles of the mesh.
        expected: usize,
    },
    /// An entry of the order names no triangle, or one that an earlier entry names.
    Order {
        /// The entry at fault.
        entry: usize,
    },
    /// A left child at an odd index, out of range or not after its parent.
    Child {
        /// The parent.
        node: usize,
    },
    /// A leaf holds more than [`MAX_LEAF_SIZE`] triangles, or its range is out of bounds or does not
    /// begin where that of the leaf to its left ends: also when a node has two parents.
    Leaf {
        /// The leaf at fault.
        node: usize,
    },
    /// No leaf holds an entry of the order.
    Uncovered {
        /// The first such entry.
        entry: usize,
    },
    /// Children deeper than [`MAX_DEPTH`].
    Depth {
        /// Their parent.
        node: usize,
    },
    /// A box is not finite, or does not contain the boxes or triangles below it.
    Box {
        /// The node at fault.
        node: usize,
    },
    /// Some nodes cannot be reached from the root, so a refit would trip over them.
    NodeCount {
        /// Nodes reached. Unless the root is alone, the array has the unused slot 1 besides.
        reached: usize,
        /// Length of the node array.
        found: usize,
    },
    /// Slot 1 of a compact BVH does not hold a grid.
    Grid,
    /// More triangles than a compact BVH can hold.
    TooManyTriangles {
        /// How many there are.
        triangles: usize,
        /// How many there may be.
        most: usize,
    },
    /// A buffer is too small.
    Capacity(CapacityError),
}

impl fmt::Display for BvhError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OrderLength { found, expected } => {
                write!(f, "the order has {found} entries for {expected} triangles")
            }
            Self::Order { entry } => {
                write!(f, "order entry {entry} is out of range or names a triangle again")
            }
            Self::Child { node } => write!(
                f,
                "the left child of node {node} must be even, in range and after its parent"
            ),
            Self::Leaf { node } => write!(
                f,
                "leaf {node} must hold at most {MAX_LEAF_SIZE} triangles and continue the order \
                 where the leaf to its left ends"
            ),
            Self::Uncovered { entry } => write!(f, "no leaf holds order entry {entry}"),
            Self::Depth { node } => {
                write!(f, "the children of node {node} are deeper than {MAX_DEPTH}")
            }
            Self::Box { node } => write!(
                f,
                "the box of node {node} must be finite and contain the boxes below it: refit first"
            ),
            Self::NodeCount { reached, found } => {
                write!(f, "{reached} nodes can be reached, which does not fit an array of {found}")
            }
            Self::Grid => write!(f, "slot 1 of a compact BVH must hold its grid"),
            Self::TooManyTriangles { triangles, most } => {
                write!(f, "a compact BVH holds at most {most} triangles, not {triangles}")
            }
            Self::Capacity(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for BvhError {}
