//! The bounding volume hierarchy (BVH): one flat array of nodes, and an order of the triangles.
//!
//! A binary tree. The root is node 0 and slot 1 is unused; the two children of an inner node are siblings at an even
//! index and the next, so that they share a 64-byte cache line when the array is aligned to one. A child
//! comes after its parent: one backward pass over the array refits the whole tree. A leaf holds a range of the
//! order, an array of triangle indices; the ranges of the leaves, from left to right, follow one another.
//!
//! [`Node`] takes 32 bytes and is the same on CPU and GPU. Builds make trees of `Node`s, refits follow a deforming mesh, [`Bvh::new`] checks arrays from
//! elsewhere, and [`blob`] stores a tree with its mesh.

pub mod blob;
mod build;
mod check;
mod node;
mod quality;
mod refit;
#[cfg(test)]
pub(crate) mod tests;

pub use build::{BuildOptions, BvhStorage, SahSteps, morton, sah};
pub use check::BvhError;
pub use node::Node;
pub use quality::{REBUILD_RATIO, quality};
pub use refit::{Refit, RefitRow, refit};

pub use crate::parallel::Join;
pub use crate::vertex_set::{Moved, mark_moved};

use crate::{Aabb, Mesh};
use core::convert::Infallible;

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

/// A mesh and its BVH, in borrowed arrays. Copying is free.
#[derive(Clone, Copy, Debug)]
pub struct Bvh<'a> {
    pub(crate) mesh: Mesh<'a>,
    nodes: &'a [Node],
    order: &'a [u32],
}

impl<'a> Bvh<'a> {
    /// Adopts arrays from elsewhere (a file, a GPU) after checking all that queries rely on.
    ///
    /// `scratch` marks the triangles seen: a bit for each does it in one pass. Fewer words are enough for the same
    /// answer, but every pass goes over the whole order.
    ///
    /// # Errors
    /// [`BvhError`] names the array, the node or the order entry at fault.
    ///
    /// # Complexity
    /// O(triangles) with full scratch. Stops early at the first fault, however tangled the nodes.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{Bvh, BvhError, Mesh, Node};
    /// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
    /// let root = Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 };
    /// assert!(Bvh::new(mesh, &[root], &[0], &mut [0]).is_ok());
    ///
    /// let small = Node { max: [0.5; 3], ..root };
    /// let refused = Bvh::new(mesh, &[small], &[0], &mut [0]).err();
    /// assert_eq!(refused, Some(BvhError::Box { node: 0 }));
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn new(
        mesh: Mesh<'a>,
        nodes: &'a [Node],
        order: &'a [u32],
        scratch: &mut [u32],
    ) -> Result<Self, BvhError> {
        let bvh = Self { mesh, nodes, order };
        bvh.check(scratch)?;
        Ok(bvh)
    }

    /// Makes a BVH of arrays that a build or a refit has written, or that [`Bvh::new`] has accepted,
    /// without checking them.
    ///
    /// Not `unsafe`: memory safety never depends on the arrays.
    ///
    /// # Panics and wrong answers
    /// With other arrays, queries may give wrong pairs, not end, or panic; an index out of range panics, here
    /// or in the query that meets it.
    #[inline]
    #[must_use]
    pub fn new_unchecked(mesh: Mesh<'a>, nodes: &'a [Node], order: &'a [u32]) -> Self {
        Self { mesh, nodes, order }
    }

    /// The mesh.
    #[inline]
    #[must_use]
    pub fn mesh(&self) -> Mesh<'a> {
        self.mesh
    }

    /// The nodes in use; empty for an empty mesh.
    #[inline]
    #[must_use]
    pub fn nodes(&self) -> &'a [Node] {
        self.nodes
    }

    /// The triangles, leaf by leaf.
    #[inline]
    #[must_use]
    pub fn order(&self) -> &'a [u32] {
        self.order
    }

    /// The box of the root, or `None` for an empty mesh.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        Some(self.root()?.aabb())
    }

    /// The depth of the deepest node: 0 for a lone root, at most [`MAX_DEPTH`].
    ///
    /// # Complexity
    /// O(nodes).
    #[must_use]
    pub fn depth(&self) -> usize {
        let mut deepest = 0;
        let Ok(()) = preorder(self.nodes, |_, depth| {
            deepest = deepest.max(depth);
            Ok::<(), Infallible>(())
        });
        deepest
    }

    /// Whether the nodes below every node are one range of the array, as builds lay them. Refits
    /// rely on it; [`Bvh::new`] does not ask for it.
    ///
    /// # Complexity
    /// O(nodes).
    #[must_use]
    pub fn is_depth_first(&self) -> bool {
        let mut children = 2;
        let laid = preorder(self.nodes, |index, _| {
            let node = &self.nodes[index];
            if node.is_leaf() {
                return Ok(());
            }
            let expected = children;
            children += 2;
            if node.left() == expected { Ok(()) } else { Err(()) }
        });
        laid.is_ok()
    }

    /// Checks the tree as [`Bvh::new`] does, for tests: call it after every change.
    ///
    /// # Panics
    /// If the tree is not a well-formed BVH of its mesh.
    #[expect(clippy::panic, reason = "a test helper: panicking is its purpose")]
    pub fn assert_well_formed(&self) {
        if let Err(error) = self.check(&mut [0; 256]) {
            panic!("{error}");
        }
    }

    /// The root node, or `None` for an empty mesh.
    #[inline]
    pub(crate) fn root(&self) -> Option<&'a Node> {
        self.nodes.first()
    }

    #[inline(always)]
    pub(crate) fn node(&self, index: u32) -> &'a Node {
        &self.nodes[index as usize]
    }

    /// The triangles of a leaf, at most [`MAX_LEAF_SIZE`].
    #[inline]
    pub(crate) fn leaf_triangles(&self, leaf: &Node) -> &'a [u32] {
        assert!(leaf.count <= MAX_LEAF_SIZE, "a leaf holds too many triangles");
        &self.order[leaf.first as usize..][..leaf.count as usize]
    }

    /// How many triangles lie below a node: one range of the order, from its leftmost leaf to its rightmost.
    pub(crate) fn triangles_below(&self, node: u32) -> u32 {
        if node == 0 {
            return self.order.len() as u32;
        }
        let end = |side: u32| {
            let mut node = self.node(node);
            while !node.is_leaf() {
                node = self.node(node.left() + side);
            }
            node
        };
        let (left, right) = (end(0), end(1));
        right.first + right.count - left.first
    }

    /// The edge of a leaf's box, roughly: the longest edge of the root's box over the square root of the number of
    /// leaves, to a power of two, as for leaves that tile a face of it.
    pub(crate) fn leaf_edge(&self) -> f32 {
        let leaves = self.nodes.len() / 2 + 1;
        let Some(root) = self.aabb() else { return 0.0 };
        let longest = (0..3).fold(0.0, |m: f32, k| m.max(root.max[k] * 0.5 - root.min[k] * 0.5));
        longest / (1_u32 << (leaves.ilog2() / 2)) as f32 * 2.0
    }
}

/// Visits each node and its depth, parents first and left before right, until `visit` refuses one.
///
/// `visit` must refuse an inner node whose children are out of range or deeper than [`MAX_DEPTH`].
fn preorder<E>(
    nodes: &[Node],
    mut visit: impl FnMut(usize, usize) -> Result<(), E>,
) -> Result<(), E> {
    // Each level above the current node left at most one right child waiting, and no node is
    // deeper than MAX_DEPTH.
    let mut waiting = [(0, 0); MAX_DEPTH];
    let mut len = 0_usize;
    let mut next = nodes.first().map(|_| (0, 0));
    while let Some((index, depth)) = next {
        visit(index, depth)?;
        let node = &nodes[index];
        if !node.is_leaf() {
            let left = node.left() as usize;
            waiting[len] = (left + 1, depth + 1);
            len += 1;
            next = Some((left, depth + 1));
        } else if len > 0 {
            len -= 1;
            next = Some(waiting[len]);
        } else {
            next = None;
        }
    }
    Ok(())
}
