//! The p-partition front: a cut through the BVTT whose work splits evenly over p workers.
//!
//! Zhang & Kim 2014, section 3. A frame goes through four steps, all in the caller's memory:
//!
//! 1. [`Front::start`] puts the starting front F_s of each query into the front: its overlapping
//!    BVTT nodes at depth d_s, with what each cost in the last frame ([`Past`]), or an estimate from its
//!    overlap where that frame tells nothing.
//! 2. [`Front::refine`] (Algorithm 2) replaces nodes by their children until none costs more than a
//!    given share of the whole.
//! 3. [`crate::front::partition::greedy`] deals the nodes out.
//! 4. Each worker walks from its nodes ([`Cursor::at`](crate::bvtt::Cursor::at)); the work it counts
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
//! - No overlap measure tells much about the cost of a single node: of 15 tried on random poses of
//!   two bunnies, none was better than another by more than the noise. What helps is to deal out
//!   smaller nodes, so that errors average out: estimated nodes are refined further than measured
//!   ones, see [`Grain`].
//! - For the same reason a node below an estimated one is priced anew, by the density of its own
//!   overlap, and not as a share of its parent (eq. 3), which would carry the error down. Since the sum
//!   then changes, refinement is repeated until it meets its bound.
//! - The starting front is not cached. What overlaps at depth d_s is found anew each frame, at
//!   4^(d_s + 1) / 3 box tests at most, so objects may move freely.
//! - Eq. 3 divides by a volume that is 0 for flat or touching boxes, and ignores how many
//!   triangles there are. Boxes are dilated by half the edge of a leaf, every node has a floor of one
//!   test, and α is by default the density of triangles: see [`Alpha`].
//! - A jump makes the last frame's costs worthless. [`Front::found`] tells how much of them was found
//!   again, and below [`COHERENT`] the frame does better without.

mod check;
mod estimate;
mod heap;
mod partition;
mod past;
mod refine;
#[cfg(test)]
mod tests;

pub use estimate::{Alpha, Estimate, Extent};
pub use partition::{Load, dearest_first, greedy, p_optimal};
pub use past::{HOLD, Past, PastCost, Path};
pub use refine::Grain;

use crate::CapacityError;
use crate::bvtt::{NodePair, Query};
use refine::{Descent, Step, open};

/// The least share of the last frame's cost that must lie in nodes that still overlap for its costs to
/// be trusted.
pub const COHERENT: f64 = 0.5;

/// What a triangle that may lie in an overlap costs in box tests, before a frame has told: 13 for two
/// spheres, 20 for finer ones.
const FIRST_ALPHA: f64 = 16.0;

/// One node of a front: 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
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

/// A front in the caller's slice: N_p nodes of 32 bytes, and 16 bytes each for their [`Past`].
#[derive(Debug)]
pub struct Front<'a> {
    nodes: &'a mut [FrontNode],
    len: usize,
    full: bool,
    box_tests: u64,
    /// Cost of the last frame in nodes that overlap again.
    found: f64,
    /// How far the past of the queries added so far reaches.
    read: usize,
    /// Nodes that [`Front::start`] may not use.
    free: usize,
}

impl<'a> Front<'a> {
    /// An empty front of fixed capacity.
    pub fn new(nodes: &'a mut [FrontNode]) -> Self {
        Self::resume(nodes, 0)
    }

    /// The front of which the first `len` of `nodes` are left from another: to refine the parts of one
    /// front side by side, or to put them together again. Numbers the nodes anew.
    pub fn resume(nodes: &'a mut [FrontNode], len: usize) -> Self {
        let len = len.min(nodes.len());
        for (index, node) in nodes.iter_mut().take(len).enumerate() {
            node.index = index as u32;
        }
        Self { nodes, len, full: false, box_tests: 0, found: 0.0, read: 0, free: 0 }
    }

    /// The nodes.
    #[must_use]
    pub fn nodes(&self) -> &[FrontNode] {
        self.nodes.get(..self.len).unwrap_or_default()
    }

    /// The nodes, to deal them out.
    pub fn nodes_mut(&mut self) -> &mut [FrontNode] {
        self.nodes.get_mut(..self.len).unwrap_or_default()
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
    /// from [`COHERENT`] on.
    #[must_use]
    pub fn found(&self, past: Past<'_>) -> f64 {
        let cost = past.cost();
        if cost > 0.0 { self.found / cost } else { 0.0 }
    }

    /// Makes [`Front::start`] leave so many nodes free, for the roots of queries still to be added.
    pub fn keep_free(&mut self, nodes: usize) {
        self.free = nodes;
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
    /// Below 4^(depth + 1) / 3 box tests; usually far fewer, since only overlapping nodes are met.
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
        let past = past.of_query(number, &mut self.read);
        let first = self.len;
        let root = FrontNode { pair: root, query: number, cost: 1.0, ..FrontNode::default() };
        let mut descent = Descent::new();
        descent.restart(Step { node: root, past });
        while let Some(at) = descent.pop() {
            if !at.past.goes_below(at.node.path) {
                self.found += at.past.cost();
            }
            let wanted = at.node.path.level() < depth.min(Path::MAX_LEVEL);
            let room = self.len + descent.waiting() + 4 + self.free <= self.nodes.len();
            let tests =
                if wanted && room { open(query, &at, &mut descent, |_| [1.0; 4]) } else { 0 };
            self.box_tests += u64::from(tests);
            if tests == 0 {
                self.full |= wanted && !room;
                if at.past.goes_below(at.node.path) {
                    self.found += at.past.cost();
                }
                self.push(at.node);
            }
        }
        self.price(first, query, estimate, past);
        Ok(())
    }

    /// Costs for a starting front: those of the last frame, and overlap for what it did not have, on
    /// the scale of what it had.
    fn price(&mut self, first: usize, query: &impl Query, estimate: Estimate, past: Past<'_>) {
        let nodes = self.nodes_mut().get_mut(first..).unwrap_or_default();
        let mut rest = past;
        for node in &mut *nodes {
            node.cost = rest.advance(node.query, node.path).cost() as f32;
        }
        let is_known = |node: &FrontNode| node.cost > 0.0;
        if !nodes.iter().all(is_known) {
            let weight = |node: &FrontNode| estimate.weight(query, node.pair);
            let known = || nodes.iter().filter(|node| is_known(node));
            let cost: f64 = known().map(|node| f64::from(node.cost)).sum();
            let weights: f64 = known().map(weight).sum();
            let alpha = match estimate.alpha {
                // Fitted to the last frame.
                _ if weights > 0.0 => cost / weights,
                Alpha::Density => FIRST_ALPHA,
                // All that lies in overlaps costs the same whatever V is.
                Alpha::Constant => {
                    let density = Estimate { alpha: Alpha::Density, ..estimate };
                    let triangles: f64 = nodes.iter().map(|n| density.weight(query, n.pair)).sum();
                    FIRST_ALPHA * triangles / nodes.iter().map(weight).sum::<f64>()
                }
            };
            for node in nodes.iter_mut().filter(|node| !is_known(node)) {
                node.cost = (alpha * weight(node)) as f32;
            }
        }
        for node in nodes {
            // Without any overlap to go by, all are alike.
            node.cost = if node.cost.is_finite() { node.cost.max(1.0) } else { 1.0 };
        }
    }

    fn push(&mut self, node: FrontNode) {
        if let Some(free) = self.nodes.get_mut(self.len) {
            *free = FrontNode { index: self.len as u32, ..node };
            self.len += 1;
        }
    }
}
