//! The front of a frame and the cost history for the next one, in memory that grows on demand.
//!
//! Memory is N nodes of 40 bytes and as much for those of the last frame: at most 80·N. At first
//! N = max(1024, 16·p) and one for each node that the front starts from; while that is too little, N doubles, up to
//! `max_nodes` or as far as there is memory, and then g is halved.

use crate::memory::resize;
use crate::{MemoryError, Queries, Report, Schedule, Settings, Share};
use pfront_core::bvtt::NodePair;
use pfront_core::front::{Front, FrontNode, FrontReport, Part, RefineOptions};
use std::time::Instant;

/// The first N. A policy: 40 KiB, or twice what a front of g = 8 takes for each worker.
const FEWEST_NODES: usize = 1024;
const NODES_PER_WORKER: usize = 16;

/// How much finer estimated nodes are than measured ones where nobody takes from others: as in [`RefineOptions::new`].
const ESTIMATED: f64 = 6.0;

/// The g that the paper uses.
const PAPER: f64 = 2.0;

/// A node pair that a front starts from: the root of a query, or a pending node pair of its cursor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    pub(crate) query: u32,
    pub(crate) pair: NodePair,
}

/// How fine a front is. Threads that take from each other need one that is even on the whole only: that of the paper's g, or
/// the starting front if the last frame was unlike the one before, or none.
fn options(settings: &Settings, workers: usize, is_coherent: bool) -> RefineOptions {
    let (g, coarse) = (settings.g, settings.g.min(PAPER));
    match settings.schedule {
        Schedule::Static => RefineOptions { workers, g, g_estimated: ESTIMATED * g },
        Schedule::Hybrid => RefineOptions {
            workers,
            g: coarse,
            g_estimated: if is_coherent { coarse } else { 0.0 },
        },
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct FrontMemory {
    nodes: Vec<FrontNode>,
    /// Nodes of the last front.
    len: usize,
    parts: Vec<Part>,
    /// Nodes of the last front with their measured costs.
    history: Vec<FrontNode>,
    /// Whether the last front made use of the one before.
    is_coherent: bool,
}

impl FrontMemory {
    /// The nodes of the front, in descending order of cost.
    pub(crate) fn nodes(&self) -> &[FrontNode] {
        &self.nodes[..self.len]
    }

    /// Makes a front of so many node pairs as they are, all in one part.
    ///
    /// # Errors
    /// [`MemoryError`] if there is no room for them.
    pub(crate) fn list(
        &mut self,
        starts: impl ExactSizeIterator<Item = Start>,
    ) -> Result<(), MemoryError> {
        self.len = starts.len();
        self.grow(self.len)?;
        add_all(&mut Front::new(&mut self.nodes), starts);
        Ok(())
    }

    /// Generates a front for as many workers as `report` has shares, and assigns it to them.
    ///
    /// # Errors
    /// [`MemoryError`] if there is no room for the nodes that it starts from.
    pub(crate) fn divide<Q: Queries + ?Sized>(
        &mut self,
        queries: &Q,
        starts: &[Start],
        settings: &Settings,
        report: &mut Report,
    ) -> Result<(), MemoryError> {
        let clock = Instant::now();
        let workers = report.shares.len();
        let mut most = settings.max_nodes.max(starts.len());
        self.grow((FEWEST_NODES.max(NODES_PER_WORKER * workers) + starts.len()).min(most))?;
        resize(&mut self.parts, workers)?;
        let mut options = options(settings, workers, self.is_coherent);
        let mut box_tests = 0;
        loop {
            // Memory that an earlier frame grew may be larger.
            let capacity = self.nodes.len().min(most);
            let mut front = Front::new(&mut self.nodes[..capacity]);
            add_all(&mut front, starts.iter().copied());
            let query = |number| queries.query(number);
            let history = if settings.coherence { &mut self.history[..] } else { &mut [] };
            let refined = front.refine(&options, history, query);
            box_tests += refined.box_tests;
            let can_coarsen = options.g > 1.0 || options.g_estimated > 1.0;
            if refined.full && capacity < most {
                if self.grow((2 * capacity).min(most)).is_err() {
                    most = capacity;
                }
            } else if refined.full && can_coarsen {
                options.g = options.g.min(ESTIMATED * u32::MAX as f64) / 2.0;
                options.g_estimated = options.g_estimated.min(ESTIMATED * u32::MAX as f64) / 2.0;
            } else {
                report.front = FrontReport { box_tests, ..refined };
                self.len = front.partition(&mut self.parts).len();
                break;
            }
        }
        for (share, part) in report.shares.iter_mut().zip(&self.parts) {
            *share = Share { predicted: part.cost, ..Share::default() };
        }
        report.nodes = self.len;
        let held = self.nodes.capacity() + self.history.capacity();
        report.front_bytes = held * size_of::<FrontNode>();
        report.front_time = clock.elapsed();
        Ok(())
    }

    /// Keeps the measured costs of the nodes for the next frame, if there is memory, and whether those of the last one were used.
    pub(crate) fn remember(&mut self, costs: impl IntoIterator<Item = f32>, is_coherent: bool) {
        self.forget();
        // The capacity does not double, which would break the bound on memory.
        if self.history.try_reserve_exact(self.len).is_err() {
            return;
        }
        self.is_coherent = is_coherent;
        self.history.extend_from_slice(&self.nodes[..self.len]);
        for (node, cost) in self.history.iter_mut().zip(costs) {
            node.cost = cost;
        }
    }

    pub(crate) fn forget(&mut self) {
        self.history.clear();
        self.is_coherent = false;
    }

    pub(crate) fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        self.history.retain_mut(|node| match number(node.query) {
            Some(new) => {
                node.query = new;
                true
            }
            None => false,
        });
    }

    fn grow(&mut self, to: usize) -> Result<(), MemoryError> {
        let len = to.max(self.nodes.len());
        resize(&mut self.nodes, len)
    }
}

/// Adds node pairs to a front that has room for them.
fn add_all(front: &mut Front<'_>, starts: impl Iterator<Item = Start>) {
    for Start { query, pair } in starts {
        let added = front.add(query, pair);
        debug_assert!(added.is_ok(), "there is room for all starts");
    }
}
