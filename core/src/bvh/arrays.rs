//! A BVH as queries see it.

use super::{MAX_DEPTH, MAX_LEAF_SIZE};
use crate::{Aabb, BvhError, Mesh, Node};
use core::convert::Infallible;

/// A mesh and its BVH, in borrowed arrays. Copying is free.
#[derive(Clone, Copy, Debug)]
pub struct Bvh<'a> {
    pub(crate) mesh: Mesh<'a>,
    pub(super) nodes: &'a [Node],
    pub(super) order: &'a [u32],
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
pub(super) fn preorder<E>(
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
