//! An oracle in the place of Algorithm 1: the front that true costs would give.
//!
//! It cannot be had before the traversal is over, so it answers nothing; it tells how far the front of a frame
//! is from the best, and how much of an imbalance no front can help. Algorithm 1 splits nodes in depth-first order and
//! checks after each; here the dearest is split first, and the partition is checked whenever the front has grown by a
//! sixteenth.

use pfront::pfront_core::bvtt::{Cursor, NodePair, Query};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

/// A p-partition front by true costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// How many nodes it has.
    pub nodes: usize,
    /// Busiest worker over mean, of the greedy partition of it.
    pub imbalance: f64,
}

impl Reference {
    /// The smallest front met on the way down, always splitting the dearest node, whose greedy partition
    /// over `workers` has an imbalance of at most 1 + `tolerance`; or the best, if leaf pairs prevent it.
    ///
    /// # Complexity
    /// Walks the BVTT once for each level of the front, and partitions the front each time that it has
    /// grown by a sixteenth.
    pub fn of<Q: Query>(query: &Q, workers: usize, tolerance: f64) -> Self {
        let Some(mut cut) = Cut::root(query) else { return Self { nodes: 0, imbalance: 1.0 } };
        cut.refine(workers, tolerance)
    }
}

/// A front, and how to make it finer.
struct Cut<'q, Q> {
    query: &'q Q,
    /// Nodes that may have children.
    inner: BinaryHeap<Costed>,
    /// Leaf pairs.
    leaves: Vec<Costed>,
}

impl<'q, Q: Query> Cut<'q, Q> {
    /// Nothing but the root.
    fn root(query: &'q Q) -> Option<Self> {
        let mut cut = Self { query, inner: BinaryHeap::new(), leaves: Vec::new() };
        let root = query.root()?;
        cut.inner.push(cut.costed(root));
        Some(cut)
    }

    /// Algorithm 1. Returns the best of the fronts that it has partitioned, which is the last where that meets the
    /// tolerance.
    fn refine(&mut self, workers: usize, tolerance: f64) -> Reference {
        let mut best = self.partition(workers);
        while best.imbalance > 1.0 + tolerance && !self.inner.is_empty() {
            let next = self.len() + 1 + self.len() / 16;
            while self.len() < next && self.split_dearest() {}
            let found = self.partition(workers);
            if found.imbalance < best.imbalance {
                best = found;
            }
        }
        best
    }

    /// Replaces the dearest node by its children, or finds that it has none. Returns whether there was
    /// one.
    fn split_dearest(&mut self) -> bool {
        let Some(dearest) = self.inner.pop() else { return false };
        let mut children = Vec::with_capacity(4);
        let pair = NodePair { a: dearest.1, b: dearest.2 };
        if self.query.children(pair, &mut |child, _| children.push(child)) == 0 {
            self.leaves.push(dearest);
        }
        for child in children {
            self.inner.push(self.costed(child));
        }
        true
    }

    /// The greedy partition: each node in descending order of cost to the worker with the least so far.
    fn partition(&self, workers: usize) -> Reference {
        let mut costs: Vec<f64> = self.nodes().map(|node| f64::from_bits(node.0)).collect();
        costs.sort_unstable_by(|x, y| y.total_cmp(x));
        let mut loads: BinaryHeap<_> = vec![Reverse(0_u64); workers.max(1)].into();
        for cost in &costs {
            if let Some(mut least) = loads.peek_mut() {
                least.0 = (f64::from_bits(least.0) + cost).to_bits();
            }
        }
        let most = loads.iter().map(|load| load.0).max();
        let makespan = most.map_or(0.0, f64::from_bits);
        let total: f64 = costs.iter().sum();
        let imbalance = if total > 0.0 { makespan * loads.len() as f64 / total } else { 1.0 };
        Reference { nodes: costs.len(), imbalance }
    }

    /// A node and its true cost.
    fn costed(&self, pair: NodePair) -> Costed {
        let mut cursor = Cursor::at(pair);
        // Never broken off.
        let _ = self.query.visit(&mut cursor, |_| ControlFlow::Continue(()));
        ((1.0 + cursor.work.cost()).to_bits(), pair.a, pair.b)
    }

    fn nodes(&self) -> impl Iterator<Item = &Costed> {
        self.leaves.iter().chain(&self.inner)
    }

    fn len(&self) -> usize {
        self.leaves.len() + self.inner.len()
    }
}

/// A node pair by its cost, whose bits sort as positive numbers do.
type Costed = (u64, u32, u32);

#[cfg(test)]
mod tests {
    use super::*;
    use pfront::pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
    use pfront::{Model, Pose};
    use pfront_testkit::scenes::icosphere;

    #[test]
    fn the_reference_is_a_cut_within_its_tolerance() {
        let ball = icosphere(20_000);
        let ball = Model::new(ball.positions, ball.triangles).unwrap();
        let here = Pose::from_translation([0.3, 0.2, 0.1]);
        let query = PairBvtt::new(ball.bvh(), ball.bvh(), here).unwrap();
        let whole = query.count();
        for workers in [1, 2, 7, 64, 1024] {
            let mut cut = Cut::root(&query).unwrap();
            let found = cut.refine(workers, 0.02);
            assert!(found.imbalance <= 1.02 || workers > 7, "{found:?}");
            let pairs = cut.nodes().map(|node| {
                let mut pairs = 0;
                let _ = query.visit(&mut Cursor::at(NodePair { a: node.1, b: node.2 }), |_| {
                    pairs += 1;
                    ControlFlow::Continue(())
                });
                pairs
            });
            assert_eq!(pairs.sum::<u64>(), whole, "{found:?}");
        }
        let empty = Model::new(Vec::new(), Vec::new()).unwrap();
        let nothing = Reference::of(&SelfBvtt::new(empty.bvh()), 8, 0.02);
        assert_eq!(nothing, Reference { nodes: 0, imbalance: 1.0 });
    }
}
