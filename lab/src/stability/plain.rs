//! The method of Zhang & Kim 2014 as printed, to show beside ours: no dilation of boxes, no floor cost, no
//! notice of a jump, one cost per starting node.
//!
//! | here | paper |
//! |---|---|
//! | `Plain::starting_front` | F_s at depth d_s, sections 3.2.1 and 5.2: 4^d_s nodes, fixed |
//! | `bound` | the right side of eq. 1 |
//! | `Plain::front` | Algorithm 2 |
//! | `cost` of a child | eq. 3, that is eq. 2 with a constant α |
//! | `volume` | V of eqs. 2 and 3, raw |
//! | `deal` | section 3.3: descending order, each to the least loaded |
//! | `Plain::walk` | section 3.4: costs are saved back to F_s by the backward index |
//!
//! Two things the paper leaves open had to be settled:
//! - A leaf pair above the bound has no children. Algorithm 2 would drop it, and with it an answer; it stays
//!   in the front.
//! - A node of F_s that does not overlap costs its one test, so it is not stored but found missing.

use pfront::TrianglePair;
use pfront::pfront_core::Aabb;
use pfront::pfront_core::bvtt::{Cursor, NodePair, Query};
use pfront::threads::{Report, Share};
use std::collections::HashMap;
use std::ops::ControlFlow;

/// Frames of a query by the paper's equations, in counted work and on one thread: what p workers would do.
#[derive(Clone, Debug)]
pub struct Plain {
    workers: usize,
    grain: f64,
    /// |n_s^{t−1}| of the nodes of F_s that overlapped.
    last: HashMap<NodePair, f64>,
    report: Report,
}

/// A node of the front, and the starting node from which it sprouted.
struct Node {
    pair: NodePair,
    cost: f64,
    sprouted_from: NodePair,
}

impl Plain {
    /// For p = `workers`, at least 1, with g = `grain`; the paper uses 2.
    pub fn new(workers: usize, grain: f64) -> Self {
        let (last, report) = (HashMap::new(), Report::default());
        Self { workers: workers.max(1), grain, last, report }
    }

    /// The report of the last frame: shares, nodes and tests, as [`pfront::threads::Traversal`] counts them.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Replaces the contents of `out` by all pairs that meet, sorted.
    pub fn all<Q: Query>(&mut self, query: &Q, out: &mut Vec<TrianglePair>) {
        self.report = Report::default();
        let starting = self.starting_front(query);
        let mut front = self.front(query, &starting);
        let parts = deal(&mut front, self.workers);
        self.walk(query, &starting, &front, &parts, out);
    }

    /// d_s: 3 to 5 on CPUs, 6 and 7 on GPUs, so that F_s is "much greater" than p; the least that makes it
    /// 8 times as large.
    fn depth(&self) -> u32 {
        (3..7).find(|&depth| 1 << (2 * depth) >= 8 * self.workers).unwrap_or(7)
    }

    /// The nodes of F_s that overlap; the others are never part of a front.
    fn starting_front(&mut self, query: &impl Query) -> Vec<NodePair> {
        let mut level: Vec<NodePair> = query.root().into_iter().collect();
        for _ in 0..self.depth() {
            let mut below = Vec::new();
            for node in level {
                let tests = query.children(node, &mut |child, _| below.push(child));
                self.report.front.box_tests += u64::from(tests);
                if tests == 0 {
                    below.push(node);
                }
            }
            level = below;
        }
        level
    }

    /// Algorithm 2.
    fn front(&mut self, query: &impl Query, starting: &[NodePair]) -> Vec<Node> {
        // The first frame: |n_s| = 1 (section 3.4).
        let weight = |n: &NodePair| self.last.get(n).copied().unwrap_or(1.0);
        let apart = (1_usize << (2 * self.depth())).saturating_sub(self.last.len());
        let total = self.last.values().sum::<f64>() + apart as f64;
        // Eq. 1.
        let bound = total / (self.grain * self.workers as f64);
        let costed = |&pair| Node { pair, cost: weight(&pair), sprouted_from: pair };
        // Lines 1 to 5.
        let (mut front, mut queue): (Vec<Node>, Vec<Node>) =
            starting.iter().map(costed).partition(|node| node.cost < bound);
        // Lines 6 to 21.
        while let Some(node) = queue.pop() {
            let mut children = Vec::with_capacity(4);
            let tests = query.children(node.pair, &mut |pair, boxes| {
                children.push((pair, volume(boxes)));
            });
            self.report.front.box_tests += u64::from(tests);
            if tests == 0 {
                front.push(node);
                continue;
            }
            let sum: f64 = children.iter().map(|child| child.1).sum();
            for (pair, volume) in children {
                // Eq. 3.
                let cost = volume / sum * (node.cost - 1.0);
                let child = Node { pair, cost, sprouted_from: node.sprouted_from };
                if cost < bound { front.push(child) } else { queue.push(child) }
            }
        }
        front
    }

    /// Section 3.4: what each worker finds and does.
    fn walk(
        &mut self,
        query: &impl Query,
        starting: &[NodePair],
        front: &[Node],
        parts: &[usize],
        out: &mut Vec<TrianglePair>,
    ) {
        self.last.clear();
        self.last.extend(starting.iter().map(|&node| (node, 0.0)));
        self.report.nodes = front.len();
        self.report.shares.resize(self.workers, Share::default());
        out.clear();
        for (node, &part) in front.iter().zip(parts) {
            let mut cursor = Cursor::at(node.pair);
            // Never broken off.
            let _ = query.visit(&mut cursor, |pair| {
                out.push(pair);
                ControlFlow::Continue(())
            });
            let work = cursor.work;
            *self.last.entry(node.sprouted_from).or_default() += 1.0 + work.cost();
            let share = &mut self.report.shares[part];
            share.predicted += node.cost;
            share.work = share.work + work;
        }
        out.sort_unstable();
    }
}

/// Sorts a front by cost and gives each node to the worker with the least so far; returns whose each is.
/// Comparisons are plain ones, so that costs that are NaN do what they would do in print.
fn deal(front: &mut [Node], workers: usize) -> Vec<usize> {
    front.sort_by(|x, y| y.cost.total_cmp(&x.cost));
    let mut loads = vec![0.0; workers];
    let least = |loads: &[f64]| {
        (1..workers).fold(0, |least, i| if loads[i] < loads[least] { i } else { least })
    };
    front
        .iter()
        .map(|node| {
            let part = least(&loads);
            loads[part] += node.cost;
            part
        })
        .collect()
}

/// The volume in which two boxes overlap.
fn volume([a, b]: [Aabb; 2]) -> f64 {
    let edge = |k: usize| f64::from(a.max[k].min(b.max[k])) - f64::from(a.min[k].max(b.min[k]));
    (0..3).map(|k| edge(k).max(0.0)).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deals_as_printed() {
        let node =
            |cost| Node { pair: NodePair::default(), cost, sprouted_from: NodePair::default() };
        // Graham's: 15 where 12 is possible.
        let mut front = [4.0, 7.0, 6.0, 5.0, 4.0, 7.0, 6.0, 5.0, 4.0].map(node);
        let parts = deal(&mut front, 4);
        let load = |part| -> f64 {
            front.iter().zip(&parts).filter(|(_, p)| **p == part).map(|(node, _)| node.cost).sum()
        };
        assert_eq!([0, 1, 2, 3].map(load).into_iter().fold(0.0, f64::max), 15.0);
        // Costs of 0 / 0 all go to one worker.
        let mut front = [f64::NAN; 3].map(node);
        assert_eq!(deal(&mut front, 2), [0, 0, 0]);
    }

    #[test]
    fn flat_boxes_have_no_volume() {
        let [flat, cube] = [0.0, 2.0].map(|z| Aabb { min: [0.0; 3], max: [1.0, 2.0, z] });
        assert_eq!(volume([flat, cube]), 0.0);
        assert_eq!(volume([cube, Aabb { min: [0.5, -1.0, 1.0], max: [3.0; 3] }]), 1.0);
        assert_eq!(volume([cube, Aabb { min: [2.0; 3], max: [3.0; 3] }]), 0.0);
    }

    #[test]
    fn starting_fronts_are_as_deep_as_the_papers() {
        let depth = |workers| Plain::new(workers, 2.0).depth();
        assert_eq!([1, 8, 9, 64, 1024, 1 << 20].map(depth), [3, 3, 4, 5, 7, 7]);
    }
}
