//! The p-partition front: a cut through the BVTT whose work splits evenly over p workers.
//!
//! Zhang & Kim 2014, section 3. A frame goes through four steps, all in the caller's memory:
//!
//! 1. [`Front::add`] adds the roots of the queries, or the node pairs that a cursor gives away.
//! 2. [`Front::refine`] descends from there to a starting front F_s, gives its nodes the costs that the last frame measured
//!    or estimates from their overlap, and splits nodes until none costs more than a given share of the whole
//!    (Algorithm 2).
//! 3. [`Front::partition`] assigns the nodes to workers.
//! 4. Each worker traverses from its nodes ([`Cursor::at`](crate::bvtt::Cursor::at)) and sets their costs to the work that
//!    it counted. The nodes are then the cost history of the next frame.
//!
//! A front that is full stops refining. It is coarser then, but still a whole cut: nothing is lost.
//!
//! # Examples
//! Two frames for two workers:
//! ```
//! use pfront_core::bvtt::{Cursor, Query};
//! use pfront_core::{CapacityError, front::*};
//! # fn frames(query: &impl Query) -> Result<(), CapacityError> {
//! let (mut memory, mut history) = ([FrontNode::default(); 400], Vec::new());
//! for _ in 0..2 {
//!     let mut front = Front::new(&mut memory);
//!     if let Some(root) = query.root() {
//!         front.add(0, root)?;
//!     }
//!     front.refine(&RefineOptions::new(2), &mut history, |_| query);
//!     let nodes = front.partition(&mut [Part::default(); 2]);
//!     for node in &mut *nodes {
//!         let mut cursor = Cursor::at(node.pair); // A worker's, by node.part.
//!         let _ = query.visit(&mut cursor, |_| std::ops::ControlFlow::Continue(()));
//!         node.cost = 1.0 + cursor.work.cost() as f32;
//!     }
//!     history = nodes.to_vec();
//! }
//! # Ok(()) }
//! ```
//!
//! # How to read this folder
//! `refine` is the loop and its bound, `estimate` and `history` say what a node costs, and `partition` assigns nodes.
//!
//! # Where we depart from the paper, and why
//! - The paper remembers one cost for each starting node and shares it among descendants by overlap volume (eq. 3).
//!   This is a weak guess, so we remember a cost for each node of the *whole* front: the same use of coherence at the grain
//!   that is assigned, in the same O(N_p) memory. The children of those nodes get their costs by eq. 3 as printed.
//! - Estimates are not shared by eq. 3, which would carry an error down: a child of an estimated node gets as much of its
//!   parent's estimate as it has of its parent's overlap volume, whatever its siblings have.
//!   The sum then changes, so refinement is repeated until it meets its bound. No overlap measure tells much about a
//!   single node, so estimated nodes are refined further than measured ones, and errors average out:
//!   [`RefineOptions::g_estimated`].
//! - A first frame is divided by the density of triangles in the overlap, where the paper takes all nodes of F_s to cost
//!   the same (section 3.4) or α to be constant (eq. 4); flat and touching boxes, whose volume is 0, are dilated.
//! - F_s is not cached and its depth d_s is not fixed: each frame descends level by level until there are 32 nodes or all
//!   are leaf pairs, where the paper has 4^3 to 4^5 nodes at a depth set beforehand. So objects may move freely, and many
//!   queries begin at their roots.
//! - A jump makes the last frame's costs worthless. A frame does without them if less than half of them lie in nodes
//!   that overlap again.
//! - A node that the last frame split is split again until it costs less than half the bound, and no bound is lower than
//!   the cost of a few splits: without this a still scene may swing between two fronts.

mod estimate;
mod history;
mod node;
mod partition;
mod refine;
#[cfg(test)]
mod tests;

pub use estimate::estimate;
pub use node::FrontNode;
pub use partition::Part;
pub use refine::{FrontReport, RefineOptions, STARTING_NODES};

use crate::CapacityError;
use crate::bvtt::NodePair;

/// A front in the caller's slice, whose length bounds its nodes, 40 bytes each.
///
/// Its nodes are pairwise disjoint and cost at least 1. Their order is arbitrary.
#[derive(Debug)]
pub struct Front<'a> {
    nodes: &'a mut [FrontNode],
    len: usize,
}

impl<'a> Front<'a> {
    /// An empty front.
    pub fn new(nodes: &'a mut [FrontNode]) -> Self {
        Self { nodes, len: 0 }
    }

    /// Adds a node to start from: the root of query number `query`, or the node pairs that
    /// [`Cursor::take_pending`](crate::bvtt::Cursor::take_pending) took from a cursor of it. A node pair that is merely
    /// pending may have been visited in part.
    ///
    /// A query whose history is to be used has no node but its root.
    ///
    /// # Errors
    /// [`CapacityError`] if there is no room; the front is unchanged.
    pub fn add(&mut self, query: u32, pair: NodePair) -> Result<(), CapacityError> {
        CapacityError::check("front", self.len + 1, self.nodes.len())?;
        self.push(FrontNode { pair, query, cost: 1.0, ..FrontNode::default() });
        Ok(())
    }

    fn nodes(&self) -> &[FrontNode] {
        &self.nodes[..self.len]
    }

    fn nodes_mut(&mut self) -> &mut [FrontNode] {
        &mut self.nodes[..self.len]
    }

    fn push(&mut self, node: FrontNode) {
        self.nodes[self.len] = node;
        self.len += 1;
    }

    /// Σ|n| over the front.
    fn cost(&self) -> f64 {
        self.nodes().iter().map(|node| f64::from(node.cost)).sum()
    }

    fn max_cost(&self) -> f64 {
        self.nodes().iter().fold(0.0, |max, node| max.max(node.cost.into()))
    }
}
