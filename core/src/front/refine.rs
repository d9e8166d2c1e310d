//! Algorithm 2: refining a front until its nodes are small enough to be assigned evenly.
//!
//! [`Front::split`] is the one loop. It needs no memory but that of the front: nodes that it has yet to look at wait at
//! the end of the slice, as a stack whose top is its first node, and those that it has looked at are at the beginning.
//! Both are in depth-first order, and children take the place of their parent.

use super::estimate::{TESTS_PER_TRIANGLE, costs_of_children, triangles_in_overlap};
use super::{CostHistory, Front, FrontNode, Path};
use crate::Aabb;
use crate::bvtt::{Bvtt, NodePair};
use crate::index::{at, at_mut, range};

/// The starting front is the first level of the BVTT with this many overlapping nodes, or the last.
pub const STARTING_NODES: usize = 32;

/// The least share of the last frame's cost that must lie in nodes that overlap again for its costs to be used.
const COHERENT: f64 = 0.5;

/// Below this cost no node is split: a split takes about as long as 20 box tests.
pub(super) const WORTH_SPLITTING: f64 = 64.0;

/// A node that the last frame split is split again if it costs more than this share of the bound.
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
    /// For p = `workers`, with a g of 8 where costs were measured and of 48 where they are estimates.
    #[must_use]
    pub const fn new(workers: usize) -> Self {
        Self { workers, g: 8.0, g_estimated: 48.0 }
    }
}

/// The outcome of a refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrontReport {
    /// Nodes of the starting front, N_s.
    pub starting_nodes: usize,
    /// The share of the cost history that lies in nodes that overlap again, 0 to 1.
    pub coherence: f64,
    /// Whether it was enough for the history to be used.
    pub coherent: bool,
    /// How many workers can help, eq. 6 of the paper: the cost of the starting front over that of its dearest node,
    /// rounded up. At least 1.
    pub p_optimal: u32,
    /// The certificate: the predicted makespan of [`Front::partition`] is at most (1 + ε)·W/p, where W is the cost of the
    /// front. At most 1/g, unless the front is full, or leaf pairs and nodes not worth a split prevent it.
    pub epsilon: f64,
    /// Whether some node is coarser than asked for, as the memory of the front is used up.
    pub full: bool,
    /// Box tests spent on the front, which are part of the work of the frame.
    pub box_tests: u64,
}

impl Front<'_> {
    /// Refines a front as [`RefineOptions`] say. `query` finds a query, or a reference to one, by its number.
    ///
    /// # Complexity
    /// O(nodes added), one box test each at most, and a pass over the front for each time that new estimates have
    /// lowered the sum so far that more nodes exceed the bound.
    pub fn refine<Q: Bvtt>(
        &mut self,
        options: &RefineOptions,
        history: CostHistory<'_>,
        query: impl Fn(u32) -> Q,
    ) -> FrontReport {
        let several = options.workers > 1;
        if several {
            self.descend(&query);
        }
        let (found, cost) = (history.cost_found_in(self.nodes()), history.cost());
        let coherence = if cost > 0.0 { found / cost } else { 0.0 };
        let coherent = coherence >= COHERENT;
        let history = if coherent { history } else { CostHistory::default() };
        self.set_costs(history, &query);
        let (starting_nodes, ratio) = (self.len, self.cost() / self.dearest());
        let p_optimal = (ratio as u32).max(1);
        let p_optimal = p_optimal + u32::from(f64::from(p_optimal) < ratio);
        while several && self.split_above(options, history, &query) && !self.full {}
        let mean = self.cost() / options.workers.max(1) as f64;
        FrontReport {
            starting_nodes,
            coherence,
            coherent,
            p_optimal,
            epsilon: if mean > 0.0 { self.dearest() / mean } else { 0.0 },
            full: self.full,
            box_tests: self.box_tests,
        }
    }

    fn dearest(&self) -> f64 {
        self.nodes().iter().fold(0.0, |most, node| most.max(node.cost.into()))
    }

    /// Descends level by level to the starting front.
    fn descend<Q: Bvtt>(&mut self, query: &impl Fn(u32) -> Q) {
        for depth in 1..=Path::MAX_LEVEL {
            let above = |node: &FrontNode, _: CostHistory<'_>| node.path.level() < depth;
            if self.len >= STARTING_NODES || !self.split(CostHistory::default(), query, &above) {
                break;
            }
        }
    }

    /// Sets the costs of a starting front: those of the last frame, and for nodes without one an estimate by overlap on
    /// the scale of the known ones.
    fn set_costs<Q: Bvtt>(&mut self, history: CostHistory<'_>, query: &impl Fn(u32) -> Q) {
        let mut rest = history;
        for node in self.nodes_mut() {
            node.cost = rest.advance(node).cost() as f32;
        }
        let weight = |node: &FrontNode| triangles_in_overlap(&query(node.query), node.pair);
        let is_known = |node: &FrontNode| node.cost > 0.0;
        if !self.nodes().iter().all(is_known) {
            let known = || self.nodes().iter().filter(|node| is_known(node));
            let cost: f64 = known().map(|node| f64::from(node.cost)).sum();
            let weights: f64 = known().map(weight).sum();
            let alpha = if weights > 0.0 { cost / weights } else { TESTS_PER_TRIANGLE };
            for node in self.nodes_mut().iter_mut().filter(|node| !is_known(node)) {
                node.cost = (alpha * weight(node)) as f32;
            }
        }
        for node in self.nodes_mut() {
            // Without any overlap to go by, all are alike.
            node.cost = if node.cost.is_finite() { node.cost.max(1.0) } else { 1.0 };
        }
    }

    /// Splits all nodes that exceed the bound which the present sum gives. Returns whether there were any.
    fn split_above<Q: Bvtt>(
        &mut self,
        options: &RefineOptions,
        history: CostHistory<'_>,
        query: &impl Fn(u32) -> Q,
    ) -> bool {
        let share = self.cost() / options.workers as f64;
        // A g that is negative or NaN asks for nothing, like 0.
        let bound = |g: f64| (share / g.max(0.0)).max(WORTH_SPLITTING);
        let [estimated, measured] = [options.g_estimated, options.g].map(bound);
        self.split(history, query, &|node, history| {
            let bound = if history.is_empty() { estimated } else { measured };
            let hold = if history.has_split(node) { HYSTERESIS } else { 1.0 };
            f64::from(node.cost) >= hold * bound
        })
    }

    /// Replaces nodes by their overlapping children for as long as there is one that `exceeds`, which is told its part of
    /// the history too, or until memory is used up. Leaf pairs stay. Returns whether any node was split.
    #[inline(never)] // One copy serves both uses: firmware has little room for code.
    fn split<Q: Bvtt>(
        &mut self,
        history: CostHistory<'_>,
        query: &impl Fn(u32) -> Q,
        exceeds: &dyn Fn(&FrontNode, CostHistory<'_>) -> bool,
    ) -> bool {
        let mut rest = history;
        let is_first = |node: &FrontNode| exceeds(node, rest.advance(node));
        let Some(first) = self.nodes().iter().position(is_first) else { return false };
        let (end, tests_before) = (self.nodes.len(), self.box_tests);
        let mut waiting = end - (self.len - first);
        for index in (first..self.len).rev() {
            let node = *at(self.nodes, index);
            *at_mut(self.nodes, index + end - self.len) = node;
        }
        self.len = first;
        let mut rest = history;
        while waiting < end {
            let node = *at(self.nodes, waiting);
            waiting += 1;
            let history = rest.advance(&node);
            if exceeds(&node, history) {
                if waiting - self.len >= 4 {
                    let mut children = Children::new();
                    let tests = children.of(&query(node.query), &node, history);
                    self.box_tests += u64::from(tests);
                    if tests > 0 {
                        waiting -= children.nodes().len();
                        for (child, index) in children.nodes().iter().zip(waiting..) {
                            *at_mut(self.nodes, index) = *child;
                        }
                        continue;
                    }
                } else {
                    self.full = true;
                }
            }
            self.push(node);
        }
        self.box_tests > tests_before
    }
}

/// The overlapping children of a node: at most four.
struct Children {
    nodes: [FrontNode; 4],
    len: usize,
}

impl Children {
    fn new() -> Self {
        Self { nodes: [FrontNode::default(); 4], len: 0 }
    }

    fn nodes(&self) -> &[FrontNode] {
        range(&self.nodes, 0, self.len as u32)
    }

    /// Finds the children of `parent`, in the order of their paths; returns the number of box tests, 0 for a leaf pair.
    fn of(&mut self, query: &impl Bvtt, parent: &FrontNode, history: CostHistory<'_>) -> u32 {
        let mut boxes = [[Aabb::EMPTY; 2]; 4];
        let tests = query.children(parent.pair, &mut |pair, both| {
            let path = parent.path.child(child_number(pair));
            *at_mut(&mut self.nodes, self.len) = FrontNode { pair, path, ..*parent };
            *at_mut(&mut boxes, self.len) = both;
            self.len += 1;
        });
        let boxes = range(&boxes, 0, self.len as u32);
        let costs = costs_of_children(query, parent, !history.is_empty(), boxes);
        let mut rest = if history.has_split(parent) { history } else { CostHistory::default() };
        for (child, cost) in self.nodes.iter_mut().zip(costs).take(self.len) {
            let known = rest.advance(child).cost() as f32;
            child.cost = if known > 0.0 { known } else { cost }.max(1.0);
        }
        tests
    }
}

/// The number of a child: siblings of a BVH are adjacent at an even and an odd index. Children come in the order of these
/// numbers.
fn child_number(pair: NodePair) -> u32 {
    (pair.a & 1) << 1 | (pair.b & 1)
}
