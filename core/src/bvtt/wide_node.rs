//! A wide node: the up to four nodes two levels below a node, tested together.

use super::NodePair;
use crate::pose::Affine;
use crate::simd::{Box4, VECTORS};
use crate::{Bvh, Node};

/// The grandchildren of a node, with their posed boxes. A leaf counts as its only child.
pub(super) struct WideNode {
    nodes: [u32; 4],
    len: usize,
    boxes: Box4,
}

impl WideNode {
    /// The grandchildren of the node with this index, their boxes in a pose.
    #[inline(always)]
    pub(super) fn grandchildren(bvh: &Bvh<'_>, index: u32, pose: Option<&Affine>) -> Self {
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
        let mut boxes = Node::boxes(nodes.map(|index| bvh.node(index)));
        if let Some(pose) = pose {
            boxes = pose.boxes(&boxes);
        }
        Self { nodes, len, boxes }
    }

    /// Passes on the pairs of these nodes with those of `other` whose boxes overlap. With `SELF` both sides are the
    /// same: each unordered pair is passed on once, and a node with itself is no test. Returns the number of tests.
    #[inline(always)]
    pub(super) fn overlapping<const SELF: bool>(
        &self,
        other: &Self,
        mut push: impl FnMut(NodePair),
    ) -> u32 {
        // Bit 4·row + column. All tests come before the first branch on one, since none can be predicted.
        let mut found = 0;
        for row in 0..if VECTORS { self.nodes.len() } else { other.len } {
            // With `SELF` only columns up to the row are taken, so that each unordered pair comes once.
            let columns = if SELF { row + 1 } else { self.len };
            let overlapping = self.boxes.overlapping(&other.boxes.splat(row));
            found |= (overlapping & ((1 << columns) - 1)) << (4 * row);
        }
        found &= (1 << (4 * other.len)) - 1;
        while found != 0 {
            let bit = found.trailing_zeros() as usize;
            push(NodePair { a: self.nodes[bit % 4], b: other.nodes[bit / 4 % 4] });
            found &= found - 1;
        }
        let tests = if SELF { self.len * (self.len - 1) / 2 } else { self.len * other.len };
        tests as u32
    }

    /// Passes on all pairs of these nodes with those of `other`, with the square of their boxes' distance. Returns the number of
    /// tests.
    #[cfg(feature = "within")]
    #[inline(always)]
    pub(super) fn distances(&self, other: &Self, mut push: impl FnMut(NodePair, f32)) -> u32 {
        for (row, &b) in other.nodes.iter().take(other.len).enumerate() {
            let squares = self.boxes.squared_distances(&other.boxes.splat(row)).to_array();
            for (&a, square) in self.nodes.iter().zip(squares).take(self.len) {
                push(NodePair { a, b }, square);
            }
        }
        (self.len * other.len) as u32
    }
}
