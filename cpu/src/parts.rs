//! Refining a large front in parallel: it is cut into parts, each with its share of the memory, and put
//! together again in order.
//!
//! How many parts there are, and so the number of threads, must not show in the front. A part may run
//! out of memory where the whole does not: then the calling thread finishes the pass, on the whole.

use crate::Settings;
use crate::plan::Outcome;
use pfront_core::bvtt::Query;
use pfront_core::front::{Front, FrontNode, Past};
use rayon::prelude::*;

/// Parts per thread, since some take longer than others.
const PARTS_PER_THREAD: usize = 4;

/// What [`Front::refine`] is told.
pub(crate) struct Task<'t, Q> {
    pub(crate) queries: &'t [Q],
    pub(crate) workers: usize,
    pub(crate) settings: &'t Settings,
    pub(crate) past: Past<'t>,
}

impl<Q: Query> Task<'_, Q> {
    /// Does to the first `len` of `nodes` what [`Front::refine`] does.
    pub(crate) fn refine(&self, nodes: &mut [FrontNode], len: usize) -> Outcome {
        let mut front = Front::resume(nodes, len);
        self.all_passes(&mut front);
        Outcome { nodes: front.nodes().len(), box_tests: front.box_tests(), full: front.is_full() }
    }

    fn all_passes(&self, front: &mut Front<'_>) {
        let Settings { grain, estimate, .. } = *self.settings;
        front.refine(self.workers, grain, estimate, self.past, |n| &self.queries[n as usize]);
    }

    fn pass(&self, front: &mut Front<'_>, share: f64) -> bool {
        let Settings { grain, estimate, .. } = *self.settings;
        front.refine_below(share, grain, estimate, self.past, |n| &self.queries[n as usize])
    }
}

/// A stretch of the memory and how many nodes it holds.
struct Part<'p> {
    nodes: &'p mut [FrontNode],
    len: usize,
    cost: f64,
    box_tests: u64,
    full: bool,
}

/// [`Task::refine`] on all threads of the pool.
pub(crate) fn refine<Q: Query + Sync>(
    task: &Task<'_, Q>,
    nodes: &mut [FrontNode],
    len: usize,
) -> Outcome {
    let count = (PARTS_PER_THREAD * rayon::current_num_threads()).min(len).max(1);
    let size = nodes.len() / count;
    if size < len.div_ceil(count) {
        return task.refine(nodes, len);
    }
    // From the last to the first, so that none is overwritten before it has moved: part i has at most
    // as many nodes before it as room.
    let bounds = |part: usize| part * len / count..(part + 1) * len / count;
    for part in (0..count).rev() {
        nodes.copy_within(bounds(part), part * size);
    }
    let mut parts: Vec<Part<'_>> = nodes
        .chunks_mut(size)
        .take(count)
        .enumerate()
        .map(|(i, nodes)| Part::new(nodes, bounds(i).len()))
        .collect();
    let (share, full) = loop {
        let share = parts.iter().map(|part| part.cost).sum::<f64>() / task.workers as f64;
        let split = parts.par_iter_mut().with_max_len(1).map(|part| part.refine(task, share));
        // All must have their turn.
        let split = split.reduce(|| false, |x, y| x | y);
        let full = parts.iter().any(|part| part.full);
        if full || !split {
            break (share, full);
        }
    };
    let box_tests: u64 = parts.iter().map(|part| part.box_tests).sum();
    let lengths: Vec<usize> = parts.iter().map(|part| part.len).collect();
    let mut len = 0;
    for (part, own) in lengths.into_iter().enumerate() {
        nodes.copy_within(part * size..part * size + own, len);
        len += own;
    }
    // Numbers the nodes anew.
    let mut front = Front::resume(nodes, len);
    if full {
        task.pass(&mut front, share);
        if !front.is_full() {
            task.all_passes(&mut front);
        }
    }
    Outcome {
        nodes: front.nodes().len(),
        box_tests: box_tests + front.box_tests(),
        full: front.is_full(),
    }
}

impl<'p> Part<'p> {
    fn new(nodes: &'p mut [FrontNode], len: usize) -> Self {
        let cost = nodes[..len].iter().map(|node| f64::from(node.cost)).sum();
        Self { nodes, len, cost, box_tests: 0, full: false }
    }

    fn refine<Q: Query>(&mut self, task: &Task<'_, Q>, share: f64) -> bool {
        let mut front = Front::resume(self.nodes, self.len);
        let split = task.pass(&mut front, share);
        self.len = front.nodes().len();
        self.cost = front.cost();
        self.box_tests += front.box_tests();
        self.full |= front.is_full();
        split
    }
}
