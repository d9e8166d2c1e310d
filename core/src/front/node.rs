//! A node of a front, and its place in the tree.

use crate::bvtt::NodePair;
use bytemuck::{Pod, Zeroable};

/// One node of a front: 40 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrontNode {
    /// The BVTT node.
    pub pair: NodePair,
    /// Its way from the node that was added.
    pub(super) path: Path,
    /// Its expected cost |n| = m1 + k·m2, in box tests. Where the next frame is to use it, the worker replaces this by the
    /// measured cost, finite and positive.
    pub cost: f32,
    /// The number of its query, where one front serves many. If the next frame numbers its queries otherwise, nodes of the
    /// cost history are to be renumbered before, and those of queries that are gone left out.
    pub query: u32,
    /// The worker that it is assigned to.
    pub part: u32,
    /// The position in the cost history of the first node whose [`FrontNode::first_key`] is not below its own.
    pub(super) first_past: u32,
}

impl FrontNode {
    /// The first query and path of its subtree, its own.
    pub(super) fn first_key(&self) -> (u32, Path) {
        (self.query, self.path)
    }

    /// The last query and path of its subtree.
    pub(super) fn last_key(&self) -> (u32, Path) {
        (self.query, self.path.last())
    }

    /// Its place in the order of a front: by query and path, and where these are equal, as for nodes that were added to one
    /// query or lie deep, by node pair. No two nodes of a front have the same.
    pub(super) fn order(&self) -> (u32, Path, [u32; 2]) {
        (self.query, self.path, [self.pair.a, self.pair.b])
    }
}

/// The way from a node that was added to a front, such as the root of a BVTT, to one below: the child taken at each level,
/// 2 bits each from the top, and the level in the low 7 bits of 128; the default is the path of the node that was added.
/// The order of paths is the depth-first order of the tree, and the paper's backward index is a prefix.
///
/// A path tells no more than [`Path::MAX_LEVEL`] levels. All nodes below share the path of their ancestor there: what
/// is remembered of them is remembered of all together, and they are split all the same.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
pub(super) struct Path([u64; 2]);

impl Path {
    /// The last level at which paths differ.
    pub(super) const MAX_LEVEL: u32 = 60;

    const fn bits(self) -> u128 {
        (self.0[0] as u128) << 64 | self.0[1] as u128
    }

    const fn of(bits: u128) -> Self {
        Self([(bits >> 64) as u64, bits as u64])
    }

    pub(super) fn level(self) -> u32 {
        (self.0[1] & 127) as u32
    }

    /// The path to child number `child`, 0 to 3.
    pub(super) fn child(self, child: u32) -> Self {
        let level = self.level();
        if level >= Self::MAX_LEVEL {
            return self;
        }
        Self::of((self.bits() + 1) | u128::from(child) << (126 - 2 * level))
    }

    /// The largest path of the subtree.
    pub(super) fn last(self) -> Self {
        // Memory that a caller hands back may hold any level.
        Self::of(self.bits() | u128::MAX.checked_shr(2 * self.level()).unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_sort_depth_first() {
        let root = Path::default();
        let order = [
            root,
            root.child(0),
            root.child(0).child(0),
            root.child(0).child(3),
            root.child(1),
            root.child(3).child(2),
        ];
        assert!(order.is_sorted());
        assert!(root.child(0).last() > order[3] && root.child(0).last() < order[4]);
        let deepest = (0..Path::MAX_LEVEL).fold(root, |p, _| p.child(3));
        assert_eq!(deepest.level(), Path::MAX_LEVEL);
        assert_eq!([0, 1, 2, 3].map(|child| deepest.child(child)), [deepest; 4]);
        assert!(deepest <= root.last() && deepest <= deepest.last());
    }
}
