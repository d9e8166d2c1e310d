//! What lies two levels below a node.

use crate::bvh::TreeNode;
use crate::index::at;
use crate::simd::Boxes;

/// The grandchildren of a node; where a child is a leaf, the child; of a leaf, the leaf itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Family {
    nodes: [u32; 4],
    len: usize,
    pub(crate) boxes: Boxes,
}

impl Family {
    #[inline(always)]
    pub(crate) fn below<N: TreeNode>(tree: &[N], grid: &N::Grid, node: u32) -> Self {
        let parent = at(tree, node);
        let (nodes, len) = if parent.is_leaf() {
            ([node; 4], 1)
        } else {
            let [l, r] = [parent.left(), parent.left() + 1];
            let (left, right) = (at(tree, l), at(tree, r));
            let ([p, q], [s, t]) =
                ([left.left(), left.left() + 1], [right.left(), right.left() + 1]);
            match (left.is_leaf(), right.is_leaf()) {
                (true, true) => ([l, r, r, r], 2),
                (true, false) => ([l, s, t, t], 3),
                (false, true) => ([p, q, r, r], 3),
                (false, false) => ([p, q, s, t], 4),
            }
        };
        // Lanes to spare hold some node, which nobody asks for.
        let in_lane = |lane: usize| at(tree, nodes[lane]);
        let boxes = N::boxes(grid, [in_lane(0), in_lane(1), in_lane(2), in_lane(3)]);
        Self { nodes, len, boxes }
    }

    /// How many they are.
    #[inline(always)]
    pub(crate) fn len(&self) -> u32 {
        self.len as u32
    }

    #[inline(always)]
    pub(crate) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.nodes.into_iter().take(self.len)
    }

    /// The node in a lane.
    #[inline(always)]
    pub(crate) fn node(&self, lane: u32) -> u32 {
        self.nodes[lane as usize % self.nodes.len()]
    }

    /// A bit for each lane in use.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> u32 {
        (1 << self.len) - 1
    }
}
