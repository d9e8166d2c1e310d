//! The cost history: the nodes of the last frame's front with their measured costs, found by query and path.
//!
//! The paper keeps one cost for each node of the starting front. Here each node of the whole front has its own, in the
//! same O(N_p) memory, so that a frame refines by measured costs as far as the last one did.

use super::FrontNode;
use crate::sort::sort;

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
        &self.nodes[first as usize..]
    }
}

#[cfg(test)]
mod tests {
    use super::super::node::Path;
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
}
