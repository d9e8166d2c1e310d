//! A wide node: the up to four nodes two levels below a node, tested together.

use super::NodePair;
use crate::bvh::{Bvh, Layout};
use crate::simd::Box4;

/// The grandchildren of a node. A leaf counts as its only child.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideNode {
    nodes: [u32; 4],
    len: usize,
    pub(crate) boxes: Box4,
}

impl WideNode {
    #[inline(always)]
    pub(crate) fn below<L: Layout>(bvh: &Bvh<'_, L>, index: u32) -> Self {
        let parent = bvh.node(index);
        let (nodes, len) = if parent.is_leaf() {
            ([index; 4], 1)
        } else {
            let [l, r] = [parent.left(), parent.left() + 1];
            let (left, right) = (bvh.node(l), bvh.node(r));
            let ([p, q], [s, t]) =
                ([left.left(), left.left() + 1], [right.left(), right.left() + 1]);
            match (left.is_leaf(), right.is_leaf()) {
                (true, true) => ([l, r, r, r], 2),
                (true, false) => ([l, s, t, t], 3),
                (false, true) => ([p, q, r, r], 3),
                (false, false) => ([p, q, s, t], 4),
            }
        };
        let boxes = bvh.boxes(nodes.map(|index| bvh.node(index)));
        Self { nodes, len, boxes }
    }

    /// Passes on the pairs of these nodes with those of `other` whose boxes overlap. Returns the number of tests.
    #[inline(always)]
    pub(crate) fn overlapping(&self, other: &Self, push: impl FnMut(NodePair)) -> u32 {
        self.overlapping_lanes(other, |_| (1 << self.len) - 1, push);
        (self.len * other.len) as u32
    }

    /// Passes on the overlapping pairs of these nodes with each other and themselves, each pair once. Returns the
    /// number of tests, which a node and itself do not need.
    #[inline(always)]
    pub(crate) fn overlapping_self(&self, push: impl FnMut(NodePair)) -> u32 {
        self.overlapping_lanes(self, |row| (2 << row) - 1, push);
        (self.len * (self.len - 1) / 2) as u32
    }

    /// Passes on each node of `other` with those of these in `lanes` of its row that it overlaps.
    #[inline(always)]
    fn overlapping_lanes(
        &self,
        other: &Self,
        lanes: impl Fn(usize) -> u32,
        mut push: impl FnMut(NodePair),
    ) {
        for (row, &b) in other.nodes.iter().take(other.len).enumerate() {
            let mut found = self.boxes.overlapping(&other.boxes.splat(row)) & lanes(row);
            while found != 0 {
                let a = self.nodes[found.trailing_zeros() as usize % self.nodes.len()];
                push(NodePair { a, b });
                found &= found - 1;
            }
        }
    }
}
