//! Algorithm 1 of the paper, offline: the front that true costs would give.
//!
//! It cannot be had before the walk is over, so it answers nothing; it tells how far the front of a frame
//! is from the best, and how much of an imbalance no front can help.

use crate::Settings;
use pfront_core::bvtt::{Cursor, NodePair, Query};
use pfront_core::front::FrontNode;
use pfront_core::front::{Load, greedy};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

/// A p-partition front by true costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// How many nodes it has.
    pub nodes: usize,
    /// Busiest worker over mean, of the greedy partition of it.
    pub imbalance: f64,
    /// The least imbalance of any partition of a front of that cost: the dearest leaf pair of the BVTT over
    /// the mean, or 1.
    pub lower_bound: f64,
}

impl Reference {
    /// The smallest front met on the way down, always splitting the dearest node, whose greedy partition
    /// over `workers` has an imbalance of at most 1 + `tolerance`; or the best, if leaf pairs prevent it.
    ///
    /// # Complexity
    /// Walks the BVTT once for each level of the front, and partitions the front each time that it has
    /// grown by a sixteenth.
    #[must_use]
    pub fn of<Q: Query>(query: &Q, workers: usize, tolerance: f64, settings: &Settings) -> Self {
        let Some(mut cut) = Cut::root(query, settings.triangle_cost) else {
            return Self { nodes: 0, imbalance: 1.0, lower_bound: 1.0 };
        };
        let (best, cost) = cut.refine(workers, tolerance);
        let mean = cost / workers.max(1) as f64;
        Self { lower_bound: f64::max(1.0, cut.dearest_leaf(mean) / mean), ..best }
    }
}

/// A front, and how to make it finer.
struct Cut<'q, Q> {
    query: &'q Q,
    triangle_cost: f32,
    /// Nodes that may have children.
    inner: BinaryHeap<Costed>,
    /// Leaf pairs, dearest first: no node costs more than one above it, so that they are met in this
    /// order.
    leaves: Vec<Costed>,
}

impl<'q, Q: Query> Cut<'q, Q> {
    /// Nothing but the root.
    fn root(query: &'q Q, triangle_cost: f32) -> Option<Self> {
        let mut cut = Self { query, triangle_cost, inner: BinaryHeap::new(), leaves: Vec::new() };
        let root = query.root()?;
        cut.inner.push(cut.costed(root));
        Some(cut)
    }

    /// Algorithm 1. Returns the best of the fronts that it has partitioned, which is the last where that
    /// meets the tolerance, and its cost. Where a walk takes two levels in a step, what is tested below a
    /// node depends a little on where above it the walk began; so fronts differ in cost.
    fn refine(&mut self, workers: usize, tolerance: f64) -> (Reference, f64) {
        let mut loads = vec![Load::default(); workers.max(1)];
        let (mut best, mut cost) = (self.partition(&mut loads), self.cost());
        while best.imbalance > 1.0 + tolerance && !self.inner.is_empty() {
            let next = self.len() + 1 + self.len() / 16;
            while self.len() < next && self.split_dearest() {}
            let found = self.partition(&mut loads);
            if found.imbalance < best.imbalance {
                (best, cost) = (found, self.cost());
            }
        }
        (best, cost)
    }

    /// What the dearest leaf pair costs, or 0 if that is less than `least`.
    fn dearest_leaf(&mut self, least: f64) -> f64 {
        let dearer = |node: Option<&Costed>| node.is_some_and(|node| node.cost >= least);
        while self.leaves.is_empty() && dearer(self.inner.peek()) {
            self.split_dearest();
        }
        self.leaves.first().map_or(0.0, |leaf| leaf.cost)
    }

    /// Replaces the dearest node by its children, or finds that it has none. Returns whether there was
    /// one.
    fn split_dearest(&mut self) -> bool {
        let Some(dearest) = self.inner.pop() else { return false };
        let mut children = Vec::with_capacity(4);
        if self.query.expand(dearest.pair, &mut |child| children.push(child)) == 0 {
            self.leaves.push(dearest);
        }
        for child in children {
            self.inner.push(self.costed(child));
        }
        true
    }

    fn partition(&self, loads: &mut [Load]) -> Reference {
        let node =
            |c: &Costed| FrontNode { pair: c.pair, cost: c.cost as f32, ..FrontNode::default() };
        let mut nodes: Vec<FrontNode> = self.nodes().map(node).collect();
        let makespan = greedy(&mut nodes, loads);
        let total: f64 = loads.iter().map(|load| load.cost).sum();
        let imbalance = if total > 0.0 { makespan * loads.len() as f64 / total } else { 1.0 };
        Reference { nodes: nodes.len(), imbalance, lower_bound: 1.0 }
    }

    /// A node and its true cost.
    fn costed(&self, pair: NodePair) -> Costed {
        let mut cursor = Cursor::at(pair);
        // Never broken off.
        let _ = self.query.visit(&mut cursor, |_| ControlFlow::Continue(()));
        let work = cursor.work();
        let tests =
            work.box_tests as f64 + f64::from(self.triangle_cost) * work.triangle_tests as f64;
        Costed { cost: 1.0 + tests, pair }
    }

    fn nodes(&self) -> impl Iterator<Item = &Costed> {
        self.leaves.iter().chain(&self.inner)
    }

    fn len(&self) -> usize {
        self.leaves.len() + self.inner.len()
    }

    fn cost(&self) -> f64 {
        self.nodes().map(|node| node.cost).sum()
    }
}

#[derive(Clone, Copy)]
struct Costed {
    cost: f64,
    pair: NodePair,
}

impl PartialEq for Costed {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Costed {}

impl PartialOrd for Costed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Costed {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |c: &Self| (c.pair.a, c.pair.b);
        self.cost.total_cmp(&other.cost).then_with(|| key(self).cmp(&key(other)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::bvh::node_bound;
    use pfront_core::bvh::{self, BuildOptions, BvhStorage};
    use pfront_core::bvtt::{PairQuery, TrianglePair};
    use pfront_core::{Mesh, Node, Pose};
    use pfront_scenes::icosphere;

    #[test]
    fn what_is_found_is_a_cut() {
        let ball = icosphere(1_300);
        let n = ball.triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
        let options = BuildOptions::default();
        let bvh = bvh::morton(mesh, &options, storage, &mut vec![0; 2 * n]).unwrap();
        let here = Pose::from_translation([0.3, 0.2, 0.1]);
        let query = PairQuery::new(bvh, bvh, here).unwrap();
        let k = Settings::default().triangle_cost;
        let whole = pairs(&query, query.root());
        assert!(!whole.is_empty());
        for workers in [1, 2, 7, 64, 1024] {
            for tolerance in [0.0, 0.02, 0.5] {
                let mut cut = Cut::root(&query, k).unwrap();
                let all = cut.cost();
                let (best, cost) = cut.refine(workers, tolerance);
                assert_eq!(pairs(&query, cut.nodes().map(|node| node.pair)), whole);
                // Splitting takes box tests out of the walk, but may set it going from odd levels.
                assert!(cost <= 1.3 * all && cost >= 0.5 * all, "{cost} of {all}");
                if best.imbalance <= 1.0 + tolerance {
                    assert_eq!(best.nodes, cut.len());
                }
                let dearest = cut.dearest_leaf(0.0);
                assert!(dearest * workers as f64 / cost <= best.imbalance * 1.000_001, "{best:?}");
                while cut.split_dearest() {}
                assert!(cut.leaves.iter().all(|leaf| leaf.cost <= dearest));
            }
        }
    }

    fn pairs(query: &impl Query, below: impl IntoIterator<Item = NodePair>) -> Vec<TrianglePair> {
        let mut found = Vec::new();
        for node in below {
            let _ = query.visit(&mut Cursor::at(node), |pair| {
                found.push(pair);
                ControlFlow::Continue(())
            });
        }
        found.sort_unstable();
        found
    }
}
