//! The p-partition front: a cut through the BVTT whose work splits evenly over p workers.
//!
//! Zhang & Kim 2014, section 3. A frame goes through four steps, all in the caller's memory:
//!
//! 1. [`Front::start`] puts the starting front F_s of each query into the front: its overlapping
//!    BVTT nodes at depth d_s, with what each cost in the last frame ([`Past`]), or an estimate from its
//!    overlap where that frame tells nothing.
//! 2. [`Front::refine`] (Algorithm 2) replaces every node that costs at least ΣF_s/(g·p) by its
//!    children.
//! 3. [`crate::partition::greedy`] deals the nodes out.
//! 4. Each worker walks from its nodes ([`Cursor::at`](crate::query::Cursor::at)); the work it counts
//!    becomes the [`Past`] of the next frame.
//!
//! A front that is full stops refining. It is coarser then, but still a whole cut: nothing is lost.
//!
//! # Where we depart from the paper, and why
//! - The paper remembers one cost per starting node and splits it among descendants by overlap
//!   volume (eq. 3). That guess is weak: two dragons on 64 workers end up with an imbalance of 2.
//!   We remember a cost per node of the *whole* front, found again by its [`Path`], which makes the
//!   same use of coherence at the grain that is dealt out, in the same O(N_p) memory. The backward
//!   index is [`Path::ancestor`].
//! - The starting front is not cached. What overlaps at depth d_s is found anew each frame, at 4^d_s
//!   box tests at most, so objects may move freely.
//! - Eq. 3 divides by a volume that is 0 for flat or touching boxes, and ignores how many
//!   triangles there are. Boxes are dilated by half the edge of a leaf, every node has a floor of one
//!   test, and α is by default the density of triangles: see [`Alpha`].
//! - A jump makes the last frame's costs worthless. [`Front::start`] reports how much of them it found
//!   again, and below [`COHERENT`] the frame does better without.

mod estimate;
mod past;

pub use estimate::{Alpha, Estimate, Extent};
pub use past::{Past, PastCost, Path};

use crate::CapacityError;
use crate::query::{NodePair, Query};
use estimate::split;

/// The least share of the last frame's cost that must lie in nodes that still overlap for its costs to
/// be trusted.
pub const COHERENT: f64 = 0.5;

/// One node of a front: 40 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrontNode {
    /// The BVTT node.
    pub pair: NodePair,
    /// Its way from the root.
    pub path: Path,
    /// Its expected cost |n| = m1 + k·m2, in box tests.
    pub cost: f32,
    /// The query it belongs to, where one front serves many.
    pub query: u32,
    /// The worker it is dealt to.
    pub part: u32,
    /// Its place in the front, which dealing out does not change.
    pub index: u32,
}

/// A front in the caller's slice.
#[derive(Debug)]
pub struct Front<'a> {
    nodes: &'a mut [FrontNode],
    len: usize,
    full: bool,
    box_tests: u64,
    /// Cost of the last frame in nodes that overlap again.
    found: f64,
}

impl<'a> Front<'a> {
    /// An empty front of fixed capacity.
    pub fn new(nodes: &'a mut [FrontNode]) -> Self {
        Self { nodes, len: 0, full: false, box_tests: 0, found: 0.0 }
    }

    /// The nodes.
    #[must_use]
    pub fn nodes(&self) -> &[FrontNode] {
        &self.nodes[..self.len]
    }

    /// The nodes, to deal them out.
    pub fn nodes_mut(&mut self) -> &mut [FrontNode] {
        &mut self.nodes[..self.len]
    }

    /// Σ|n| over the front.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.nodes().iter().map(|n| f64::from(n.cost)).sum()
    }

    /// Whether some node was left coarser than asked for want of room.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.full
    }

    /// Box tests spent on the front, which are part of the whole work of the frame.
    #[must_use]
    pub fn box_tests(&self) -> u64 {
        self.box_tests
    }

    /// How much of the cost in `past` lies in nodes of the starting front, 0 to 1. Motion is coherent
    /// above [`COHERENT`].
    #[must_use]
    pub fn found(&self, past: Past<'_>) -> f64 {
        let cost = past.cost();
        if cost > 0.0 { self.found / cost } else { 0.0 }
    }

    /// Adds the starting front of the query with number `number`: its overlapping nodes at level `depth`
    /// and the leaf pairs above. Queries are added in ascending order of their numbers.
    ///
    /// Where there is little room it is less deep.
    ///
    /// # Errors
    /// [`CapacityError`] if there is no room for even the root; the front is unchanged.
    ///
    /// # Complexity
    /// At most 4^depth box tests; usually far fewer, since only overlapping nodes are met.
    pub fn start(
        &mut self,
        query: &impl Query,
        number: u32,
        depth: u32,
        estimate: Estimate,
        past: Past<'_>,
    ) -> Result<(), CapacityError> {
        let Some(root) = query.root() else { return Ok(()) };
        CapacityError::check("front", self.len + 1, self.nodes.len())?;
        let past = past.of_query(number);
        let first = self.len;
        let root = FrontNode { pair: root, query: number, cost: 1.0, ..FrontNode::default() };
        let mut descent = Descent::new();
        descent.restart(root, past);
        while let Some(at) = descent.pop() {
            let wanted = at.node.path.level() < depth.min(Path::MAX_LEVEL);
            let room = self.len + descent.len + 4 <= self.nodes.len();
            if !(wanted && room && self.open(query, &at, &mut descent, |_| [1.0; 4])) {
                self.full |= wanted && !room;
                self.found += at.past.cost();
                self.push(at.node);
            }
        }
        self.price(first, query, estimate, past);
        Ok(())
    }

    /// Costs for a starting front: those of the last frame, and overlap for what it did not have, on
    /// the scale of what it had.
    fn price(&mut self, first: usize, query: &impl Query, estimate: Estimate, past: Past<'_>) {
        let (mut weights, mut known_weights, mut known) = (0.0, 0.0, 0.0);
        for node in &mut self.nodes[first..self.len] {
            let weight = estimate.weight(query, node.pair);
            let cost = past.below(node.path).cost();
            weights += weight;
            if cost > 0.0 {
                known += cost;
                known_weights += weight;
            }
            // Both until the scale is known: a positive cost, or a negative weight.
            node.cost = if cost > 0.0 { cost } else { -weight } as f32;
        }
        // α fitted to the last frame; any α will do for a first. Without any overlap to go by, all
        // are alike.
        let usable = weights > 0.0 && weights.is_finite();
        let alpha = if known_weights > 0.0 { known / known_weights } else { 1.0 };
        for node in &mut self.nodes[first..self.len] {
            if node.cost <= 0.0 {
                node.cost = if usable { (alpha * -f64::from(node.cost)) as f32 } else { 1.0 };
            }
            node.cost = if node.cost.is_finite() { node.cost.max(1.0) } else { 1.0 };
        }
    }

    /// Algorithm 2: replaces nodes that cost `bound` or more by their overlapping children, down to leaf
    /// pairs. The children cost what they did in the last frame, or share the cost of their parent,
    /// less the tests made, by α·V (eq. 2).
    ///
    /// The paper's bound is ΣF_s/(g·p), eq. 1 and, summed over many queries, eq. 5. A bound of ε·W/p
    /// makes the predicted makespan at most (1 + ε)·W/p, see [`crate::partition`]. `query` finds a query
    /// by its number.
    ///
    /// # Complexity
    /// O(nodes added), one box test each at most.
    pub fn refine<'q, Q: Query + 'q>(
        &mut self,
        bound: f32,
        estimate: Estimate,
        past: Past<'_>,
        query: impl Fn(u32) -> &'q Q,
    ) {
        // Below this a split costs more than it can balance.
        const WORTH_SPLITTING: f32 = 8.0;
        let bound = bound.max(WORTH_SPLITTING);
        // The starting front moves to the end of the slice and is read from there, so that what is
        // written from the beginning on stays in depth-first order.
        let capacity = self.nodes.len();
        let count = core::mem::take(&mut self.len);
        self.nodes.copy_within(..count, capacity - count);
        let mut descent = Descent::new();
        for read in capacity - count..capacity {
            let node = self.nodes[read];
            let asked = query(node.query);
            descent.restart(node, past.of_query(node.query).below(node.path));
            while let Some(at) = descent.pop() {
                let parent = at.node;
                let wanted = parent.cost >= bound && parent.path.level() < Path::MAX_LEVEL;
                let room = self.len + descent.len + 4 <= read + 1;
                let costs = |pairs: &[NodePair]| split(asked, estimate, pairs, parent.cost);
                if !(wanted && room && self.open(asked, &at, &mut descent, costs)) {
                    self.full |= wanted && !room;
                    self.push(parent);
                }
            }
        }
    }

    /// Replaces the node `at` by its overlapping children, unless it is a leaf pair. `estimated` prices
    /// children that the last frame did not tell apart.
    fn open<'p>(
        &mut self,
        query: &impl Query,
        at: &Step<'p>,
        descent: &mut Descent<'p>,
        estimated: impl Fn(&[NodePair]) -> [f32; 4],
    ) -> bool {
        let mut children = [None; 4];
        let tests = query.expand(at.node.pair, &mut |pair| {
            children[child_number(pair) as usize] = Some(pair);
        });
        if tests == 0 {
            return false;
        }
        self.box_tests += u64::from(tests);
        let known = at.past.goes_below(at.node.path);
        let (mut pairs, mut count) = ([NodePair::default(); 4], 0);
        for pair in children.into_iter().flatten() {
            pairs[count] = pair;
            count += 1;
        }
        let mut costs = None;
        // Last first, so that they come off the stack in the order of their paths.
        for i in (0..count).rev() {
            let path = at.node.path.child(child_number(pairs[i]));
            let past = if known { at.past.below(path) } else { Past::NOTHING };
            let cost = if past.is_empty() {
                costs.get_or_insert_with(|| estimated(&pairs[..count]))[i]
            } else {
                past.cost() as f32
            };
            let node = FrontNode { pair: pairs[i], path, cost: cost.max(1.0), ..at.node };
            descent.push(Step { node, past });
        }
        true
    }

    fn push(&mut self, node: FrontNode) {
        self.nodes[self.len] = FrontNode { index: self.len as u32, ..node };
        self.len += 1;
    }
}

/// Which child a node pair is: siblings of a BVH are adjacent at an even and an odd index.
fn child_number(pair: NodePair) -> u32 {
    (pair.a & 1) << 1 | (pair.b & 1)
}

/// A node to be looked at, and what the last frame knew below it.
#[derive(Clone, Copy)]
struct Step<'p> {
    node: FrontNode,
    past: Past<'p>,
}

/// A depth-first descent from one node.
struct Descent<'p> {
    /// Each of at most [`Path::MAX_LEVEL`] levels leaves at most three siblings waiting.
    stack: [Step<'p>; 3 * Path::MAX_LEVEL as usize + 1],
    len: usize,
}

impl<'p> Descent<'p> {
    fn new() -> Self {
        let nothing = Step { node: FrontNode::default(), past: Past::NOTHING };
        Self { stack: [nothing; 3 * Path::MAX_LEVEL as usize + 1], len: 0 }
    }

    fn restart(&mut self, node: FrontNode, past: Past<'p>) {
        self.len = 0;
        self.push(Step { node, past });
    }

    fn push(&mut self, step: Step<'p>) {
        self.stack[self.len] = step;
        self.len += 1;
    }

    fn pop(&mut self) -> Option<Step<'p>> {
        self.len = self.len.checked_sub(1)?;
        Some(self.stack[self.len])
    }
}
