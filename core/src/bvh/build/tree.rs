//! The recursion of every build: which nodes there are, where they lie and how deep.
//!
//! Nodes are numbered in preorder: the children of a node, all that lies below the left one, all that lies below the
//! right one. The start of that second stretch is known only when the first is finished. If both grow at once, the
//! right one begins where it would if the left side had leaves of one triangle, and moves up afterwards.

use super::{BuildOptions, BvhStorage};
use crate::Node;
use crate::bvh::{MAX_DEPTH, MAX_LEAF_SIZE, node_bound};
use crate::parallel::{GRAIN, Join, both, split};
use crate::{Aabb, Bvh, CapacityError, Mesh};

/// How a build divides triangles.
pub(super) trait Divide: Sync {
    /// Triangles that are adjacent in the order.
    type Run<'r>: Send;

    /// Writes the triangles of a leaf; returns their box.
    fn leaf(&self, run: &Self::Run<'_>, order: &mut [u32]) -> Aabb;

    /// Divides a run of `count` triangles at its `middle`, which it returns: count / 2 unless the depth is `free`.
    fn divide<'r>(
        &self,
        run: &'r mut Self::Run<'_>,
        count: usize,
        free: bool,
    ) -> (usize, [Self::Run<'r>; 2]);
}

/// Builds the tree over all triangles of a mesh, none of which may be missing in `run`.
pub(super) fn build<'a, D: Divide>(
    mesh: Mesh<'a>,
    options: &BuildOptions<'_>,
    storage: BvhStorage<'a>,
    divide: &D,
    mut run: D::Run<'_>,
) -> Result<Bvh<'a>, CapacityError> {
    let count = mesh.triangles().len();
    if count == 0 {
        return storage.into_bvh(mesh, 0);
    }
    // Side by side, parts leave gaps.
    let join = options.join.filter(|_| storage.nodes.len() >= node_bound(count));
    let leaf_size = options.leaf_size.clamp(1, MAX_LEAF_SIZE) as usize;
    let (root, below) = split(storage.nodes, 2);
    let tree = Tree { divide, leaf_size, join };
    let (node, used) = tree.grow(&mut run, split(storage.order, count).0, 0, 0, below, 2);
    // The root takes slot 0; slot 1 stays empty so that siblings start at even indices.
    for (slot, node) in root.iter_mut().zip([node, Node::EMPTY]) {
        *slot = node;
    }
    storage.into_bvh(mesh, if used == 0 { 1 } else { 2 + used })
}

struct Tree<'t, D> {
    divide: &'t D,
    leaf_size: usize,
    join: Option<&'t Join<'t>>,
}

impl<D: Divide> Tree<'_, D> {
    /// Builds a node over a run, whose part of the order begins at `first`, and what lies `below` it, from index
    /// `base` on. Returns the node and how many lie below, which may be more than there is room for.
    fn grow(
        &self,
        run: &mut D::Run<'_>,
        order: &mut [u32],
        first: usize,
        depth: usize,
        below: &mut [Node],
        base: usize,
    ) -> (Node, usize) {
        let count = order.len();
        if count <= self.leaf_size {
            let Aabb { min, max } = self.divide.leaf(run, order);
            return (Node { min, first: first as u32, max, count: count as u32 }, 0);
        }
        // Halving the run down to single triangles takes `levels` more levels. A division of another kind may not
        // use a level up unless they still fit below it. They fit below the root (31 <= MAX_DEPTH), and so below
        // every node.
        let levels = (usize::BITS - (count - 1).leading_zeros()) as usize;
        debug_assert!(levels <= MAX_DEPTH - depth);
        let (middle, mut runs) = self.divide.divide(run, count, levels < MAX_DEPTH - depth);
        let (left_order, right_order) = split(order, middle);
        let (pair, rest) = split(below, 2);
        let (from, depth) = (base + 2, depth + 1);
        let [left, right] = if self.join.is_some() && count > GRAIN {
            self.side_by_side(&mut runs, [left_order, right_order], first, depth, rest, from)
        } else {
            let [on_left, on_right] = &mut runs;
            let left = self.grow(on_left, left_order, first, depth, rest, from);
            let ((_, rest), from) = (split(rest, left.1), from + left.1);
            [left, self.grow(on_right, right_order, first + middle, depth, rest, from)]
        };
        let Aabb { min, max } = left.0.aabb().union(&right.0.aabb());
        for (slot, node) in pair.iter_mut().zip([left.0, right.0]) {
            *slot = node;
        }
        (Node { min, first: base as u32, max, count: 0 }, 2 + left.1 + right.1)
    }

    /// Builds two siblings as [`grow`](Self::grow) does. Apart, so that the tasks are not on the stack of every level.
    #[inline(never)]
    fn side_by_side(
        &self,
        [on_left, on_right]: &mut [D::Run<'_>; 2],
        [left_order, right_order]: [&mut [u32]; 2],
        first: usize,
        depth: usize,
        below: &mut [Node],
        base: usize,
    ) -> [(Node, usize); 2] {
        let middle = left_order.len();
        let room = node_bound(middle) - 2;
        let (left_nodes, right_nodes) = split(below, room);
        let (left, mut right) = both(
            self.join,
            || self.grow(on_left, left_order, first, depth, left_nodes, base),
            || {
                let (first, base) = (first + middle, base + room);
                self.grow(on_right, right_order, first, depth, right_nodes, base)
            },
        );
        let gap = room - left.1;
        let moved = |node: Node| {
            let gap = if node.is_leaf() { 0 } else { gap as u32 };
            Node { first: node.first - gap, ..node }
        };
        right.0 = moved(right.0);
        for index in left.1..left.1 + right.1 {
            below[index] = moved(below[index + gap]);
        }
        [left, right]
    }
}
