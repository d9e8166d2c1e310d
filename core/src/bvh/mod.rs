//! The bounding volume hierarchy: one flat array of nodes, of 32 bytes, or of 16 where memory is short
//! ([`Compact`]).
//!
//! The root is node 0, node 1 is unused, and the two children of an inner node are adjacent at an
//! even index, so that siblings share a 64-byte cache line when the array is aligned to it. A child
//! always comes after its parent: one backward pass over the array refits the whole tree.

pub mod blob;
mod build;
mod check;
mod compact;
mod layout;
mod refit;
mod shrink;
mod survey;
#[cfg(test)]
mod tests;

pub use build::{
    BuildOptions, BvhStorage, SahItem, morton, morton_scratch_bound, morton_with, sah,
    sah_scratch_bound, sah_with,
};
pub use check::{BvhError, check_scratch_bound};
pub use compact::{Compact, CompactNode};
pub use layout::{Index, Layout, Wide};
pub use refit::{Join, REBUILD_RATIO, quality, refit, refit_with};
pub use shrink::{CompactError, CompactStorage, compact, compact_bound, compact_in_place};

pub use crate::vertex_set::{Moved, mark_moved, moved_bound};
pub use survey::{Below, refit_moved, survey, survey_bound};

pub(crate) use layout::TreeNode;

use crate::aabb::Bounds;
use crate::bvtt::Family;
use crate::index::{item, run};
use crate::{Aabb, Mesh};
use bytemuck::{Pod, Zeroable};
use core::convert::Infallible;

/// The deepest a node may lie below the root (the root has depth 0).
///
/// Both builds keep it: SAH replaces a split that could break it by a median split, and halving
/// 2^31 − 1 triangles needs at most 31 levels; the Morton build splits on one of 64 key bits a
/// level. Every traversal stack is sized from it.
pub const MAX_DEPTH: usize = 64;

/// The most triangles one leaf may hold.
pub const MAX_LEAF_SIZE: u32 = 8;

/// How many nodes the BVH of so many triangles may need, whatever its leaf size.
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

/// One BVH node: 32 bytes, the same on the CPU and in a storage buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Smallest corner of the box.
    pub min: [f32; 3],
    /// Leaf: index of its first entry in the order array. Inner: index of its left child; the
    /// right child is next to it.
    pub first: u32,
    /// Largest corner of the box.
    pub max: [f32; 3],
    /// Leaf: how many triangles it holds. Inner: 0.
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

/// A mesh and its BVH, in borrowed arrays. Copying is free (four slices).
///
/// `order` lists the triangles leaf by leaf; a leaf names a run of it. The runs follow one another
/// from left to right, so the triangles below any node are one run too.
///
/// `L` is the [`Layout`]: unless it says otherwise, a BVH is [`Wide`].
#[derive(Clone, Copy, Debug)]
pub struct Bvh<'a, L: Layout = Wide> {
    mesh: Mesh<'a>,
    nodes: &'a [L::Node],
    order: &'a [L::Index],
    grid: <L::Node as TreeNode>::Grid,
}

impl<'a> Bvh<'a> {
    /// Adopts arrays from elsewhere (a file, a GPU) after checking all that a walk relies on.
    ///
    /// `scratch` marks the triangles seen: [`check_scratch_bound`] words do it in one pass. Fewer
    /// are enough for the same answer, but every pass goes over the whole order.
    ///
    /// # Errors
    /// [`BvhError`] names the first node or order entry at fault.
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
        let bvh = Self::new_unchecked(mesh, nodes, order);
        bvh.check(scratch)?;
        Ok(bvh)
    }

    /// Makes a BVH of arrays that a build or a refit has written, or that [`Bvh::new`] has accepted, without
    /// checking them.
    ///
    /// Not `unsafe`: memory safety never depends on the arrays.
    ///
    /// # Panics and wrong answers
    /// With other arrays, queries may give wrong pairs, not end, or panic.
    #[inline]
    #[must_use]
    pub fn new_unchecked(mesh: Mesh<'a>, nodes: &'a [Node], order: &'a [u32]) -> Self {
        Self { mesh, nodes, order, grid: () }
    }
}

impl<'a, L: Layout> Bvh<'a, L> {
    /// The mesh.
    #[inline]
    #[must_use]
    pub fn mesh(&self) -> Mesh<'a> {
        self.mesh
    }

    /// The nodes in use; empty for an empty mesh. In a compact BVH, slot 1 holds its grid.
    #[inline]
    #[must_use]
    pub fn nodes(&self) -> &'a [L::Node] {
        self.nodes
    }

    /// The triangles, leaf by leaf.
    #[inline]
    #[must_use]
    pub fn order(&self) -> &'a [L::Index] {
        self.order
    }

    /// The root node, or `None` for an empty mesh.
    #[inline]
    #[must_use]
    pub fn root(&self) -> Option<&'a L::Node> {
        self.nodes.first()
    }

    /// The box of the root, or `None` for an empty mesh.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        Some(self.bounds(self.root()?).into())
    }

    /// A node, by an index that is in range.
    #[inline(always)]
    pub(crate) fn node(&self, index: u32) -> &'a L::Node {
        item(self.nodes, index)
    }

    /// The box of a node.
    #[inline(always)]
    pub(crate) fn bounds(&self, node: &L::Node) -> Bounds {
        node.bounds(&self.grid)
    }

    /// What lies two levels below a node.
    #[inline(always)]
    pub(crate) fn family(&self, node: u32) -> Family {
        Family::below(self.nodes, &self.grid, node)
    }

    /// The triangles of a leaf.
    #[inline]
    pub(crate) fn leaf_triangles(&self, leaf: &L::Node) -> &'a [L::Index] {
        let [first, count] = leaf.run();
        run(self.order, first, count)
    }

    /// How many triangles lie below a node: they are one run of the order, from its leftmost leaf to
    /// its rightmost.
    pub(crate) fn triangles_below(&self, node: u32) -> u32 {
        if node == 0 {
            return self.order.len() as u32;
        }
        let end = |side: u32| {
            let mut node = self.node(node);
            while !node.is_leaf() {
                node = self.node(node.left() + side);
            }
            node.run()
        };
        let ([left, _], [right, count]) = (end(0), end(1));
        right + count - left
    }

    /// About the edge of a leaf's box: the longest edge of the root's over the root of the number of
    /// leaves, to a power of two, as for leaves that tile a face of it.
    pub(crate) fn leaf_edge(&self) -> f32 {
        let leaves = self.nodes.len() / 2 + 1;
        let Some(root) = self.aabb() else { return 0.0 };
        let longest = (0..3).fold(0.0, |m: f32, k| m.max(root.max[k] * 0.5 - root.min[k] * 0.5));
        longest / (1_u32 << (leaves.ilog2() / 2)) as f32 * 2.0
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

    /// Whether nodes lie as every build lays them: all that lies below a node is one run, which
    /// [`refit_with`](crate::bvh::build::refit_with) and those that go by it rely on, and [`Bvh::new`]
    /// does not ask for.
    ///
    /// # Complexity
    /// O(nodes).
    #[must_use]
    pub fn is_depth_first(&self) -> bool {
        let mut children = 2;
        let in_place = preorder(self.nodes, |index, _| {
            let node = item(self.nodes, index as u32);
            if node.is_leaf() {
                return Ok(());
            }
            let expected = children;
            children += 2;
            if node.left() == expected { Ok(()) } else { Err(()) }
        });
        in_place.is_ok()
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
}

/// Visits each node and its depth, parents first and left before right, until `visit` refuses one.
///
/// `visit` must refuse an inner node whose children are out of range or deeper than [`MAX_DEPTH`].
fn preorder<N: TreeNode, E>(
    nodes: &[N],
    mut visit: impl FnMut(usize, usize) -> Result<(), E>,
) -> Result<(), E> {
    // Each level above the current node left at most one right child waiting, and no node is
    // deeper than MAX_DEPTH.
    let mut waiting = [(0, 0); MAX_DEPTH];
    let mut len = 0_usize;
    let mut next = if nodes.is_empty() { None } else { Some((0, 0)) };
    while let Some((index, depth)) = next {
        visit(index, depth)?;
        let node = item(nodes, index as u32);
        next = if node.is_leaf() {
            len = len.wrapping_sub(1);
            waiting.get(len).copied()
        } else {
            let left = node.left() as usize;
            if let Some(free) = waiting.get_mut(len) {
                *free = (left + 1, depth + 1);
                len += 1;
            }
            Some((left, depth + 1))
        };
    }
    Ok(())
}
