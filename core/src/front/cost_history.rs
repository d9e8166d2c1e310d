//! The cost history: the measured cost of each node of the last frame's front, by query and path.
//!
//! The paper keeps one cost for each node of the starting front. Here each node of the whole front has its own, in the
//! same O(N_p) memory, so that a frame refines by measured costs as far as the last one did.

use super::{FrontNode, Path};
use crate::CapacityError;
use crate::front::heap::sort;
use bytemuck::{Pod, Zeroable};

/// The measured cost of one node of a front: 24 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CostEntry {
    path: Path,
    cost: f32,
    query: u32,
}

impl CostEntry {
    fn key(&self) -> (u32, Path) {
        (self.query, self.path)
    }
}

/// The measured costs of the last front, in its depth-first order. The default is empty: a first frame, or motion
/// without coherence.
#[derive(Clone, Copy, Debug, Default)]
pub struct CostHistory<'a> {
    entries: &'a [CostEntry],
}

impl<'a> CostHistory<'a> {
    /// The history in `entries`, which [`CostHistory::record`] or [`CostHistory::renumber`] left.
    #[must_use]
    pub fn new(entries: &'a [CostEntry]) -> Self {
        Self { entries }
    }

    /// Records a frame: `nodes` are all nodes of a front as [`Front::partition`](super::Front::partition) returned them,
    /// and `costs` the measured costs of the traversals from them, in the same order. Returns the number of entries of
    /// `memory` in use, one per node.
    ///
    /// # Errors
    /// [`CapacityError`] if `memory` is shorter than `nodes`.
    pub fn record(
        memory: &mut [CostEntry],
        nodes: &[FrontNode],
        costs: impl IntoIterator<Item = f32>,
    ) -> Result<usize, CapacityError> {
        CapacityError::check("memory", nodes.len(), memory.len())?;
        for (node, cost) in nodes.iter().zip(costs) {
            // The index of a node is below their number, unless they were in a caller's hands meanwhile.
            if let Some(entry) = memory.get_mut(node.index as usize) {
                *entry = CostEntry { path: node.path, cost, query: node.query };
            }
        }
        Ok(nodes.len())
    }

    /// Changes the numbers of queries, for a next frame that asks other ones: `number` tells the new number of each
    /// query that has entries, or `None` if it is gone. No two get the same. Returns how many entries are left.
    ///
    /// # Complexity
    /// O(entries), and O(n log n) if the order of the queries changes; `number` is called once per query.
    pub fn renumber(
        entries: &mut [CostEntry],
        mut number: impl FnMut(u32) -> Option<u32>,
    ) -> usize {
        let (mut left, mut last, mut before, mut sorted) = (0, None, 0, true);
        for read in 0..entries.len() {
            let Some(&entry) = entries.get(read) else { break };
            let (_, new) = match last {
                Some((old, new)) if old == entry.query => (old, new),
                _ => *last.insert((entry.query, number(entry.query))),
            };
            if let (Some(query), Some(free)) = (new, entries.get_mut(left)) {
                *free = CostEntry { query, ..entry };
                sorted &= before <= query;
                before = query;
                left += 1;
            }
        }
        if !sorted && let Some(left) = entries.get_mut(..left) {
            sort(left, CostEntry::key);
        }
        left
    }

    /// The sum of all costs.
    #[must_use]
    pub fn cost(self) -> f64 {
        self.entries.iter().map(|entry| f64::from(entry.cost)).sum()
    }

    /// The part of the history at and below a node, for nodes in the order of a front: drops what lies before it, so
    /// that all nodes of a front together take one pass.
    #[inline]
    pub(super) fn advance(&mut self, node: &FrontNode) -> Self {
        let before = |e: &&CostEntry| e.key() < (node.query, node.path);
        let skipped = self.entries.iter().take_while(before).count();
        self.entries = self.entries.get(skipped..).unwrap_or_default();
        let within = |e: &&CostEntry| e.query == node.query && e.path <= node.path.last();
        let count = self.entries.iter().take_while(within).count();
        Self { entries: self.entries.get(..count).unwrap_or_default() }
    }

    /// The cost of the entries that lie at, above or below one of `nodes`, which are in the order of a front.
    pub(super) fn cost_found_in(self, mut nodes: &[FrontNode]) -> f64 {
        let mut found = 0.0;
        for entry in self.entries {
            while let Some((first, rest)) = nodes.split_first()
                && (first.query, first.path.last()) < entry.key()
            {
                nodes = rest;
            }
            let Some(node) = nodes.first() else { break };
            if node.query == entry.query && node.path <= entry.path.last() {
                found += f64::from(entry.cost);
            }
        }
        found
    }

    pub(super) fn is_empty(self) -> bool {
        self.entries.is_empty()
    }

    /// Whether the last frame split the node whose part of the history this is.
    pub(super) fn has_split(self, node: &FrontNode) -> bool {
        self.entries.last().is_some_and(|entry| entry.path > node.path)
    }
}
