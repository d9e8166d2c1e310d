//! Algorithm 2: refining a front until its nodes are small enough to be dealt out evenly.

use super::estimate::{reprice, split};
use super::{Estimate, Front, FrontNode, Past, Path};
use crate::Aabb;
use crate::bvtt::{NodePair, Query};

/// How small the nodes of a front must be: the g of eq. 1, in nodes per worker. No node that can be
/// split costs more than 1/g of what a worker gets.
///
/// The paper has one g, and uses 2. Costs that were measured in the last frame can be relied on node by
/// node. Estimates cannot: on random poses of two bunnies the standard deviation of true over
/// estimated cost is 1.2 to 1.8, and many nodes must make up for it.
///
/// A g of 0 asks for nothing, an infinite one for nodes as small as are worth it: see [`Grain::sound`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// g where the cost of a node was measured.
    pub measured: f64,
    /// g where it is an estimate.
    pub estimated: f64,
}

impl Default for Grain {
    fn default() -> Self {
        Self { measured: 8.0, estimated: 48.0 }
    }
}

impl Grain {
    /// The same g for all nodes, as in the paper.
    #[must_use]
    pub const fn uniform(g: f64) -> Self {
        Self { measured: g, estimated: g }
    }

    /// The grain with which a predicted makespan is at most (1 + ε)·W/p, up to leaf pairs and nodes too
    /// small to be split; see [`crate::front::partition`].
    #[must_use]
    pub const fn epsilon(epsilon: f64) -> Self {
        Self::uniform(1.0 / epsilon)
    }

    /// What is made of any two numbers: less than 0 or none at all is 0, and no g is more than the
    /// number of nodes that there can be.
    #[must_use]
    pub const fn sound(self) -> Self {
        const MOST: f64 = u32::MAX as f64;
        let Self { measured, estimated } = self;
        Self { measured: measured.max(0.0).min(MOST), estimated: estimated.max(0.0).min(MOST) }
    }
}

/// Below this cost no node is split: a split takes about as long as 20 box tests (0.25 µs).
pub(super) const WORTH_SPLITTING: f32 = 64.0;

impl Front<'_> {
    /// Algorithm 2: replaces nodes by their overlapping children, down to leaf pairs, until each costs
    /// less than ΣF/(g·p) for `workers` = p (eq. 1; eq. 5 when the front serves many queries). `query`
    /// finds a query, or a reference to one, by its number.
    ///
    /// Children cost what they did in the last frame. Where that tells nothing, they share the measured
    /// cost of their parent by α·V (eq. 2), or, if it is itself an estimate, are estimated anew.
    ///
    /// # Complexity
    /// O(nodes added), one box test each at most, and a pass over the front for each time that new
    /// estimates have lowered the sum so far that more nodes exceed the bound.
    pub fn refine<Q: Query>(
        &mut self,
        workers: usize,
        grain: Grain,
        estimate: Estimate,
        past: Past<'_>,
        query: impl Fn(u32) -> Q,
    ) {
        let mean = |front: &Self| front.cost() / workers.max(1) as f64;
        let mut share = mean(self);
        while self.refine_below(share, grain, estimate, past, &query) && !self.full {
            share = mean(self);
        }
    }

    /// One pass, in which `share` is the ΣF/p that the bound derives from; for the parts of a front,
    /// which must go by the sum of the whole. Returns whether any node was split.
    pub fn refine_below<Q: Query>(
        &mut self,
        share: f64,
        grain: Grain,
        estimate: Estimate,
        past: Past<'_>,
        query: impl Fn(u32) -> Q,
    ) -> bool {
        let Grain { measured, estimated } = grain.sound();
        let bounds = [estimated, measured].map(|g| ((share / g) as f32).max(WORTH_SPLITTING));
        let exceeds = |at: &Step<'_>| {
            let bound = bounds[usize::from(!at.past.is_empty())];
            let again = at.past.goes_below(at.node.path);
            let least = if again { past.hold() * bound } else { bound };
            let mut cost = at.node.cost;
            if again && cost < least {
                cost += at.past.spent_above(at.node.path);
            }
            cost >= least && at.node.path.level() < Path::MAX_LEVEL
        };
        let mut rest = past;
        let mut step = |node: FrontNode| Step { node, past: rest.advance(node.query, node.path) };
        // Few passes but the first have much to do, and the last has nothing.
        let Some(first) = self.nodes().iter().position(|&node| exceeds(&step(node))) else {
            return false;
        };
        // From there on the front moves to the end of the slice and is read from there, so that what
        // is written in its place stays in depth-first order.
        let (count, capacity) = (core::mem::replace(&mut self.len, first), self.nodes.len());
        for from in (first..count).rev() {
            let node = self.nodes.get(from).copied().unwrap_or_default();
            if let Some(to) = self.nodes.get_mut(capacity - (count - from)) {
                *to = node;
            }
        }
        let tests_before = self.box_tests;
        let mut descent = Descent::new();
        let mut rest = past;
        for read in capacity - (count - first)..capacity {
            let node = self.nodes.get(read).copied().unwrap_or_default();
            let whole = Step { node, past: rest.advance(node.query, node.path) };
            if !exceeds(&whole) {
                self.push(node);
                continue;
            }
            let asked = query(node.query);
            descent.restart(whole);
            while let Some(at) = descent.pop() {
                let measured = !at.past.is_empty();
                let wanted = exceeds(&at);
                let room = self.len + descent.waiting() + 4 <= read + 1;
                let price = |children: &[[Aabb; 2]]| {
                    let price = if measured { split } else { reprice };
                    price(&asked, estimate, at.node, children)
                };
                let tests = if wanted && room { open(&asked, &at, &mut descent, price) } else { 0 };
                self.box_tests += u64::from(tests);
                if tests == 0 {
                    self.full |= wanted && !room;
                    self.push(at.node);
                }
            }
        }
        self.box_tests > tests_before
    }
}

/// Puts the overlapping children of a node in its place and returns the number of box tests, 0 for a leaf
/// pair, which stays. `price` costs children that the last frame did not tell apart.
pub(super) fn open<'p>(
    query: &impl Query,
    at: &Step<'p>,
    descent: &mut Descent<'p>,
    price: impl Fn(&[[Aabb; 2]]) -> [f32; 4],
) -> u32 {
    let (mut pairs, mut boxes) = ([NodePair::default(); 4], [[Aabb::EMPTY; 2]; 4]);
    let mut count = 0;
    let tests = query.children(at.node.pair, &mut |pair, both| {
        (pairs[count % 4], boxes[count % 4]) = (pair, both);
        count += 1;
    });
    let boxes = boxes.get(..count).unwrap_or_default();
    let mut rest = if at.past.goes_below(at.node.path) { at.past } else { Past::NOTHING };
    let mut costs = None;
    // Last first, so that they come off the stack in the order of their paths.
    for (i, step) in descent.grow(count).iter_mut().rev().enumerate() {
        let pair = pairs[i % 4];
        let path = at.node.path.child(child_number(pair));
        let past = rest.advance(at.node.query, path);
        let cost = if past.is_empty() {
            costs.get_or_insert_with(|| price(boxes))[i % 4]
        } else {
            past.cost() as f32
        };
        *step = Step { node: FrontNode { pair, path, cost: cost.max(1.0), ..at.node }, past };
    }
    tests
}

/// Which child a node pair is: siblings of a BVH are adjacent at an even and an odd index. Children come
/// in the order of these numbers.
fn child_number(pair: NodePair) -> u32 {
    (pair.a & 1) << 1 | (pair.b & 1)
}

/// A node to be looked at, and what the last frame knew below it.
#[derive(Clone, Copy)]
pub(super) struct Step<'p> {
    pub(super) node: FrontNode,
    pub(super) past: Past<'p>,
}

/// A depth-first descent from one node.
pub(super) struct Descent<'p> {
    /// Each of at most [`Path::MAX_LEVEL`] levels leaves at most three siblings waiting.
    stack: [Step<'p>; 3 * Path::MAX_LEVEL as usize + 1],
    len: usize,
}

impl<'p> Descent<'p> {
    pub(super) fn new() -> Self {
        let nothing = Step { node: FrontNode::default(), past: Past::NOTHING };
        Self { stack: [nothing; 3 * Path::MAX_LEVEL as usize + 1], len: 0 }
    }

    pub(super) fn restart(&mut self, from: Step<'p>) {
        self.stack[0] = from;
        self.len = 1;
    }

    pub(super) fn waiting(&self) -> usize {
        self.len
    }

    pub(super) fn pop(&mut self) -> Option<Step<'p>> {
        self.len = self.len.checked_sub(1)?;
        self.stack.get(self.len).copied()
    }

    /// Room for `count` more.
    fn grow(&mut self, count: usize) -> &mut [Step<'p>] {
        let free = self.stack.get_mut(self.len..).unwrap_or_default();
        self.len += count;
        free.get_mut(..count).unwrap_or_default()
    }
}
