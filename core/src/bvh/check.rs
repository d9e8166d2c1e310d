//! What makes arrays a BVH of a mesh.
//!
//! One walk settles the structure without marking nodes. Children come after their parent, so every
//! path ends; each leaf's run must start where the run of the leaf before it ended, so a node
//! reached twice is caught at its first leaf, and a tangled graph cannot be walked for longer than
//! a tree could be.

use super::{Bvh, Index, Layout, MAX_DEPTH, MAX_LEAF_SIZE, TreeNode, preorder};
use crate::{Aabb, CapacityError};
use core::fmt;

/// How many words of scratch [`Bvh::new`] needs to check so many triangles in one pass.
#[must_use]
pub const fn check_scratch_bound(triangles: usize) -> usize {
    triangles.div_ceil(u32::BITS as usize)
}

impl<L: Layout> Bvh<'_, L> {
    pub(super) fn check(&self, scratch: &mut [u32]) -> Result<(), BvhError> {
        let (found, expected) = (self.order.len(), self.mesh.triangles().len());
        if found != expected {
            return Err(BvhError::OrderLength { found, expected });
        }
        check_permutation(self.order, scratch)?;
        self.check_nodes()
    }

    fn check_nodes(&self) -> Result<(), BvhError> {
        let (mut reached, mut covered) = (0, 0);
        preorder(self.nodes, |index, depth| {
            let node = self.node(index as u32);
            reached += 1;
            let content = if node.is_leaf() {
                let run = self.run(node, covered).ok_or(BvhError::Leaf { node: index })?;
                covered += run.len();
                let boxes = run.iter().map(|t| Aabb::of(&self.mesh.triangle(t.get())));
                boxes.fold(Aabb::EMPTY, |a, b| a.union(&b))
            } else {
                let [a, b] = self.children(index).ok_or(BvhError::Child { node: index })?;
                if depth == MAX_DEPTH {
                    return Err(BvhError::Depth { node: index });
                }
                let [a, b] = [a, b].map(|child| Aabb::from(self.bounds(child)));
                if !(is_finite(&a) && is_finite(&b)) {
                    return Err(BvhError::Box { node: index });
                }
                a.union(&b)
            };
            let aabb = Aabb::from(self.bounds(node));
            if is_finite(&aabb) && aabb.contains(&content) {
                Ok(())
            } else {
                Err(BvhError::Box { node: index })
            }
        })?;
        if covered != self.order.len() {
            return Err(BvhError::Uncovered { entry: covered });
        }
        // The reached nodes are all different, and slot 1 is never among them.
        let fewest = if reached > 0 { L::Node::FEWEST } else { 0 };
        let needed = if reached > 1 { reached + 1 } else { fewest };
        if needed != self.nodes.len() {
            return Err(BvhError::NodeCount { reached, found: self.nodes.len() });
        }
        Ok(())
    }

    fn run(&self, leaf: &L::Node, covered: usize) -> Option<&[L::Index]> {
        let [first, count] = leaf.run().map(|x| x as usize);
        let run = self.order.get(first..first.checked_add(count)?)?;
        (first == covered && count <= MAX_LEAF_SIZE as usize).then_some(run)
    }

    fn children(&self, index: usize) -> Option<&[L::Node; 2]> {
        let left = self.node(index as u32).left() as usize;
        let pair = self.nodes.get(left..left.checked_add(2)?)?;
        (left > index && left.is_multiple_of(2)).then_some(pair.try_into().ok()?)
    }
}

fn is_finite(aabb: &Aabb) -> bool {
    aabb.min.iter().chain(&aabb.max).all(|x| x.is_finite())
}

/// Whether `order` holds each of 0 … its length − 1 once; a pass marks as many as `scratch` can.
fn check_permutation<I: Index>(order: &[I], scratch: &mut [u32]) -> Result<(), BvhError> {
    if !order.is_empty() && scratch.is_empty() {
        let needed = check_scratch_bound(order.len());
        return Err(BvhError::Scratch(CapacityError { buffer: "scratch", needed, capacity: 0 }));
    }
    if let Some(entry) = order.iter().position(|t| t.get() as usize >= order.len()) {
        return Err(BvhError::Order { entry });
    }
    let window = scratch.len().saturating_mul(u32::BITS as usize);
    for start in (0..order.len()).step_by(window.max(1)) {
        scratch.fill(0);
        for (entry, triangle) in order.iter().enumerate() {
            let offset = (triangle.get() as usize).wrapping_sub(start);
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

/// Why arrays are not a BVH of a mesh.
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
    /// A leaf holds more than [`MAX_LEAF_SIZE`] triangles, or its run is out of range or does not
    /// start where the run of the leaf to its left ends: also when a node has two parents.
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
    /// A box, or that of a child, is not finite, or it does not contain what is below it.
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
    /// The slot of a compact BVH for its grid holds none.
    Grid,
    /// There is no scratch to check the order with.
    Scratch(CapacityError),
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
            Self::Scratch(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for BvhError {}
