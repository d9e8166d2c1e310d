//! Algorithm 1 of the paper, offline: the front that true costs would give.
//!
//! It cannot be had before the walk is over, so it answers nothing; it tells how far the front of a frame
//! is from the best, and how much of an imbalance no front can help.

use crate::Settings;
use pfront_core::front::FrontNode;
use pfront_core::partition::{Load, greedy};
use pfront_core::query::{Cursor, NodePair, Query};
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
    /// The least imbalance of any partition of any front: the dearest leaf pair over the mean, or 1.
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
        let workers = workers.max(1);
        let cost = |pair| true_cost(query, pair, settings.triangle_cost);
        let mut inner: BinaryHeap<Costed> = query.root().map(cost).into_iter().collect();
        let (mut leaves, mut best) = (Vec::new(), Self { imbalance: f64::MAX, ..Self::default() });
        let (mut next, mut loads) = (1, vec![Load::default(); workers]);
        while let Some(dearest) = inner.pop() {
            if inner.len() + leaves.len() + 1 >= next {
                let all = inner.iter().chain(&leaves).chain([&dearest]);
                let found = partition(all, &mut loads);
                if found.imbalance < best.imbalance {
                    best = Self { lower_bound: best.lower_bound, ..found };
                }
                if found.imbalance <= 1.0 + tolerance {
                    break;
                }
                next = found.nodes + 1 + found.nodes / 16;
            }
            if query.expand(dearest.pair, &mut |child| inner.push(cost(child))) == 0 {
                leaves.push(dearest);
            }
        }
        let last = partition(inner.iter().chain(&leaves), &mut loads);
        let best = if last.imbalance < best.imbalance { last } else { best };
        let mean = query.root().map_or(0.0, |root| cost(root).cost) / workers as f64;
        let leaf = leaves.iter().fold(0.0, |most, leaf| f64::max(most, leaf.cost));
        Self { lower_bound: if mean > 0.0 { f64::max(1.0, leaf / mean) } else { 1.0 }, ..best }
    }
}

#[derive(Clone, Copy)]
struct Costed {
    cost: f64,
    pair: NodePair,
}

fn true_cost<Q: Query>(query: &Q, pair: NodePair, triangle_cost: f32) -> Costed {
    let mut cursor = Cursor::at(pair);
    // Never broken off.
    let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
    let work = cursor.work();
    let tests = work.box_tests as f64 + f64::from(triangle_cost) * work.triangle_tests as f64;
    Costed { cost: 1.0 + tests, pair }
}

fn partition<'c>(front: impl Iterator<Item = &'c Costed>, loads: &mut [Load]) -> Reference {
    let node = |c: &Costed| FrontNode { pair: c.pair, cost: c.cost as f32, ..FrontNode::default() };
    let mut nodes: Vec<FrontNode> = front.map(node).collect();
    let makespan = greedy(&mut nodes, loads);
    let total: f64 = loads.iter().map(|load| load.cost).sum();
    let imbalance = if total > 0.0 { makespan * loads.len() as f64 / total } else { 1.0 };
    Reference { nodes: nodes.len(), imbalance, lower_bound: 1.0 }
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
