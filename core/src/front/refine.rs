//! Algorithm 2: refining a front until its nodes are small enough to be assigned evenly.
//!
//! [`Front::split_nodes`] is the one pass: it replaces nodes by their children. It runs once for each level of the starting
//! front, and then for as long as some node exceeds its bound, which changes with the sum of all costs.

use super::estimate::{costs_of_children, estimate};
use super::history::CostHistory;
use super::{Front, FrontNode};
use crate::Aabb;
use crate::bvtt::{NodePair, Query};
use crate::sort::sort;

/// The starting front is the first level of the BVTT with this many overlapping nodes, or the last. A policy: estimates tell little
/// of fewer, and a small frame has no use for more.
pub const STARTING_NODES: usize = 32;

/// The least share of the last frame's cost that must lie in nodes that overlap again for its costs to be used. A
/// policy: most of it.
const COHERENT: f64 = 0.5;

/// The least bound, however fine a front is asked for: a split takes about as long as 20 box tests.
const LEAST_BOUND: f64 = 64.0;

/// A node that the last frame split is split again if it costs at least this share of the bound. A policy:
/// costs may halve from frame to frame before a front becomes coarser, so that it does not change with every swing.
const HYSTERESIS: f64 = 0.5;

/// The grain of a refined front: no node that can be split costs more than 1/g of the mean load of a worker
/// (eq. 1; eq. 5 where a front serves many queries). The paper has one g, and uses 2.
///
/// A g of 0 keeps the starting front; an infinite g splits every node that is worth a split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineOptions {
    /// p. With 1 the front stays as it was added.
    pub workers: usize,
    /// g for nodes whose cost the last frame measured.
    pub g: f64,
    /// g for nodes whose cost is an estimate. A larger number of nodes averages out the errors.
    pub g_estimated: f64,
}

impl RefineOptions {
    /// Options for p = `workers`, with a g of 8 where costs were measured and of 48 where they are estimates.
    #[must_use]
    pub const fn new(workers: usize) -> Self {
        Self { workers, g: 8.0, g_estimated: 48.0 }
    }
}

/// The outcome of a refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrontReport {
    /// Whether at least half of the costs in the history lie in nodes that overlap again. Nodes then cost what the history
    /// says, where it says anything.
    pub coherent: bool,
    /// The certificate: the predicted makespan of [`Front::partition`] is at most (1 + ε)·W/p, where W is the cost of the
    /// front. At most 1/g, unless the front is full, or leaf pairs and nodes not worth a split prevent it. No more than
    /// p/ε workers, rounded up, can be kept busy (eq. 6 for the refined front).
    pub epsilon: f64,
    /// Whether some node is coarser than asked for, since there was no room for its children.
    pub full: bool,
    /// Box tests spent on the front, which are part of the work of the frame.
    pub box_tests: u64,
}

impl Front<'_> {
    /// Refines a front as [`RefineOptions`] say. `query` finds a query, or a reference to one, by its number.
    ///
    /// `history` are the nodes of the last frame's front with their measured costs, or none. They are sorted by query and
    /// path.
    ///
    /// # Complexity
    /// O(1) and at most 4 box tests for each node that is split, and O(N) for each level that is added, after O(N log N)
    /// for N nodes of the history.
    pub fn refine<Q: Query>(
        &mut self,
        options: &RefineOptions,
        history: &mut [FrontNode],
        query: impl Fn(u32) -> Q,
    ) -> FrontReport {
        let mut report = FrontReport::default();
        let several = options.workers > 1;
        let none = CostHistory::default();
        while several
            && self.len < STARTING_NODES
            && self.split_nodes(none, &query, &|_| true, &mut report)
        {}
        // The order of the history allows one pass through both.
        sort(self.nodes_mut(), FrontNode::order);
        let mut history = CostHistory::new(history);
        report.coherent = history.share_in(self.nodes()) >= COHERENT;
        if !report.coherent {
            history = none;
        }
        self.set_costs(history, &query);
        while several && self.split_expensive(options, history, &query, &mut report) && !report.full
        {
        }
        let mean = self.cost() / options.workers.max(1) as f64;
        report.epsilon = if mean > 0.0 { self.max_cost() / mean } else { 0.0 };
        report
    }

    /// Sets the costs of a starting front: those of the last frame, and estimates for nodes without one.
    fn set_costs<Q: Query>(&mut self, history: CostHistory<'_>, query: &impl Fn(u32) -> Q) {
        history.find(self.nodes_mut(), 0);
        for node in self.nodes_mut() {
            let measured = history.cost(node);
            let estimated = || estimate(&query(node.query), node.pair) as f32;
            node.cost = if measured > 0.0 { measured } else { estimated() }.max(1.0);
        }
    }

    /// Splits nodes that exceed the bound which the present sum of costs gives. Returns whether any was split.
    fn split_expensive<Q: Query>(
        &mut self,
        options: &RefineOptions,
        history: CostHistory<'_>,
        query: &impl Fn(u32) -> Q,
        report: &mut FrontReport,
    ) -> bool {
        let mean = self.cost() / options.workers as f64;
        // A g that is negative or NaN asks for nothing, like 0.
        let bound = |g: f64| (mean / g.max(0.0)).max(LEAST_BOUND);
        let [estimated, measured] = [options.g_estimated, options.g].map(bound);
        let is_due = |node: &FrontNode| {
            let bound = if history.is_at_or_below(node) { measured } else { estimated };
            let cost = f64::from(node.cost);
            cost >= bound || cost >= HYSTERESIS * bound && history.has_split(node)
        };
        self.split_nodes(history, query, &is_due, report)
    }

    /// Replaces each node that `is_due` by its overlapping children, as long as there is room. Leaf pairs stay. Returns
    /// whether any node was split.
    fn split_nodes<Q: Query>(
        &mut self,
        history: CostHistory<'_>,
        query: &impl Fn(u32) -> Q,
        is_due: &dyn Fn(&FrontNode) -> bool,
        report: &mut FrontReport,
    ) -> bool {
        let mut was_any_split = false;
        // The loop runs backwards, so that only nodes that have had their turn move into gaps.
        for index in (0..self.len).rev() {
            let parent = self.nodes[index];
            if !is_due(&parent) {
                continue;
            }
            let first = self.len;
            let has_room = first + 4 <= self.nodes.len();
            if !has_room && report.full {
                continue;
            }
            let query = query(parent.query);
            let mut boxes = [[Aabb::EMPTY; 2]; 4];
            let tests = query.children(parent.pair, &mut |pair, both| {
                if !has_room {
                    return;
                }
                boxes[self.len - first] = both;
                self.push(FrontNode {
                    pair,
                    path: parent.path.child(child_number(pair)),
                    ..parent
                });
            });
            report.box_tests += u64::from(tests);
            if tests == 0 || !has_room {
                report.full |= tests > 0;
                continue;
            }
            was_any_split = true;
            let children = &mut self.nodes[first..self.len];
            history.find(children, parent.first_past);
            let was_split = history.has_split(&parent);
            for child in &mut *children {
                child.cost = if was_split { history.cost(child) } else { 0.0 };
            }
            if children.iter().any(|child| child.cost == 0.0) {
                let is_measured = history.is_at_or_below(&parent);
                let boxes = &boxes[..children.len()];
                let shares = costs_of_children(&query, &parent, is_measured, boxes);
                for (child, share) in children.iter_mut().zip(shares) {
                    child.cost = if child.cost > 0.0 { child.cost } else { share };
                }
            }
            children.iter_mut().for_each(|child| child.cost = child.cost.max(1.0));
            // The last node takes the parent's place.
            self.len -= 1;
            self.nodes[index] = self.nodes[self.len];
        }
        was_any_split
    }
}

/// The number of a child: siblings of a BVH are adjacent at an even and an odd index. Children come in the order of these
/// numbers.
fn child_number(pair: NodePair) -> u32 {
    (pair.a & 1) << 1 | (pair.b & 1)
}
