//! The cost history: the nodes of the last frame's front with their measured costs, found by query and path.
//!
//! The paper keeps one cost for each node of the starting front. Here each node of the whole front has its own, in the
//! same O(N_p) memory, so that a frame refines by measured costs as far as the last one did.

use super::FrontNode;
use crate::index::part;
use crate::sort::sort;
use bytemuck::{Pod, Zeroable};

/// The nodes of the last front, sorted by query and path. None overlaps another, so those at and below a node follow each
/// other.
#[derive(Clone, Copy, Default)]
pub(super) struct CostHistory<'a> {
    nodes: &'a [FrontNode],
}

impl<'a> CostHistory<'a> {
    pub(super) fn new(nodes: &'a mut [FrontNode]) -> Self {
        sort(nodes, FrontNode::order);
        Self { nodes }
    }

    /// Finds the nodes of the last front at and below `nodes`, which ascend by key. The search starts at position `first`,
    /// which is not after the first of them.
    #[inline]
    pub(super) fn find(self, nodes: &mut [FrontNode], mut first: u32) {
        for node in nodes {
            let before = |past: &&FrontNode| past.first_key() < node.first_key();
            first += self.from(first).iter().take_while(before).count() as u32;
            node.first_past = first;
        }
    }

    /// Whether nodes of the last front lie at or below a node, so that its cost is known.
    pub(super) fn is_at_or_below(self, node: &FrontNode) -> bool {
        self.at_and_below(node).next().is_some()
    }

    /// Whether the last frame split a node.
    pub(super) fn has_split(self, node: &FrontNode) -> bool {
        self.at_and_below(node).next().is_some_and(|past| past.path > node.path)
    }

    /// The measured cost of a node: the sum at and below it, 0 if there is none.
    pub(super) fn cost(self, node: &FrontNode) -> f32 {
        let sum: f64 = self.at_and_below(node).map(|past| f64::from(past.cost)).sum();
        // Costs that a caller hands back may be too large to add up.
        (sum as f32).min(f32::MAX)
    }

    /// The share of all costs, 0 to 1, that lies at, above or below one of `nodes`, which ascend by key.
    pub(super) fn share_in(self, nodes: &[FrontNode]) -> f64 {
        let mut rest = self.nodes.iter().peekable();
        let (mut outside, mut inside) = (0.0, 0.0);
        for node in nodes {
            while let Some(past) = rest.next_if(|past| past.last_key() < node.first_key()) {
                outside += f64::from(past.cost);
            }
            while let Some(past) = rest.next_if(|past| past.first_key() <= node.last_key()) {
                inside += f64::from(past.cost);
            }
        }
        outside += rest.map(|past| f64::from(past.cost)).sum::<f64>();
        if inside > 0.0 { inside / (inside + outside) } else { 0.0 }
    }

    fn at_and_below(self, node: &FrontNode) -> impl Iterator<Item = &'a FrontNode> {
        let last = node.last_key();
        self.from(node.first_past).iter().take_while(move |past| past.first_key() <= last)
    }

    fn from(self, first: u32) -> &'a [FrontNode] {
        // No position that `find` stores exceeds the number of nodes.
        part(self.nodes, first as usize..)
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

    fn node(path: Path, cost: f32) -> FrontNode {
        FrontNode { path, cost, ..FrontNode::default() }
    }

    /// The last frame kept the first of four children, split the second, did not reach the third and kept the fourth.
    #[test]
    fn costs_are_found_at_and_below_a_node() {
        let children = [0, 1, 2, 3].map(|child| Path::default().child(child));
        let mut past = [
            node(children[3], 5.0),
            node(children[1].child(2), 4.0),
            node(children[0], 2.0),
            node(children[1].child(0), 3.0),
        ];
        let history = CostHistory::new(&mut past);
        let mut nodes = children.map(|path| node(path, 0.0));
        history.find(&mut nodes, 0);
        let found = nodes.each_ref().map(|n| (history.cost(n), history.has_split(n)));
        assert_eq!(found, [(2.0, false), (7.0, true), (0.0, false), (5.0, false)]);
        assert_eq!(nodes.each_ref().map(|n| history.is_at_or_below(n)), [true, true, false, true]);
        assert_eq!([history.share_in(&nodes), history.share_in(&nodes[1..2])], [1.0, 0.5]);
        assert_eq!(CostHistory::default().share_in(&nodes), 0.0);
    }

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
