//! Traversing a front that has been partitioned: each worker its own part, and, where that is allowed, nodes that others
//! have not begun.
//!
//! Threads take the parts, one after the other if there are more parts than threads; the calling thread is one of them.

use crate::control::Control;
use crate::output::Output;
use crate::{Schedule, Share};
use pfront_core::bvtt::{Cursor, Query, Work};
use pfront_core::front::FrontNode;
use rayon::{Scope, ThreadPool};
use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

/// Buffers for one partition, and its counters.
#[derive(Debug, Default)]
pub(crate) struct Workers {
    parts: Vec<PartOfFront>,
    /// The bits of the true cost of each node, an `f32`.
    costs: Vec<AtomicU32>,
}

/// Nothing in the buffers outlives a frame.
impl Clone for Workers {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug, Default)]
struct PartOfFront {
    /// Positions of its nodes in the front, dearest first.
    nodes: Vec<u32>,
    /// How many of them have been begun.
    begun: AtomicUsize,
    /// The work that its worker has done.
    box_tests: AtomicU64,
    triangle_tests: AtomicU64,
}

/// A frame, as all threads see it.
pub(crate) struct Frame<'f, Q> {
    pub(crate) queries: &'f [Q],
    pub(crate) nodes: &'f [FrontNode],
    pub(crate) schedule: Schedule,
    pub(crate) control: &'f Control,
}

impl Workers {
    /// Traverses the nodes of `frame`, with a thread for each of `outputs`.
    pub(crate) fn traverse<Q: Query + Sync, O: Output>(
        &mut self,
        frame: &Frame<'_, Q>,
        pool: Option<&ThreadPool>,
        outputs: &mut [O],
        shares: &mut [Share],
    ) {
        self.parts.resize_with(shares.len(), PartOfFront::default);
        for part in &mut self.parts {
            let nodes = std::mem::take(&mut part.nodes);
            *part = PartOfFront { nodes, ..PartOfFront::default() };
            part.nodes.clear();
        }
        for (node, position) in frame.nodes.iter().zip(0..) {
            self.parts[node.part as usize].nodes.push(position);
        }
        self.costs.clear();
        self.costs.resize_with(frame.nodes.len(), AtomicU32::default);
        let begun = AtomicUsize::new(0);
        let (workers, begun) = (&*self, &begun);
        in_scope(pool, |scope| {
            let Some((own, others)) = outputs.split_first_mut() else { return };
            for output in others {
                scope.spawn(move |_| workers.thread(frame, begun, output));
            }
            workers.thread(frame, begun, own);
        });
        for (share, part) in shares.iter_mut().zip(&mut self.parts) {
            let tests = [&mut part.box_tests, &mut part.triangle_tests].map(|n| *n.get_mut());
            share.work = Work { box_tests: tests[0], triangle_tests: tests[1] };
        }
    }

    /// The true cost of each node.
    pub(crate) fn costs(&self) -> impl Iterator<Item = f32> {
        self.costs.iter().map(|cost| f32::from_bits(cost.load(Relaxed)))
    }

    /// Takes parts of which none is begun, and after the last nodes of any part.
    fn thread<Q: Query>(
        &self,
        frame: &Frame<'_, Q>,
        begun: &AtomicUsize,
        output: &mut impl Output,
    ) {
        let (count, mut last) = (self.parts.len(), None);
        while let Some(part) = Some(begun.fetch_add(1, Relaxed)).filter(|&part| part < count) {
            self.take_nodes(frame, part, part, output);
            last = Some(part);
        }
        if frame.schedule == Schedule::Hybrid {
            let first = last.map_or(0, |part| part + 1);
            for other in (first..count).chain(0..first) {
                self.take_nodes(frame, other, last.unwrap_or(other), output);
            }
        }
        output.finish();
    }

    /// Traverses from the nodes of one part that nobody has begun, as the work of `worker`.
    fn take_nodes<Q: Query>(
        &self,
        frame: &Frame<'_, Q>,
        part: usize,
        worker: usize,
        output: &mut impl Output,
    ) {
        let Frame { queries, nodes, control, .. } = *frame;
        let (part, worker) = (&self.parts[part], &self.parts[worker]);
        while !control.is_over()
            && let Some(&position) = part.nodes.get(part.begun.fetch_add(1, Relaxed))
        {
            let node = &nodes[position as usize];
            let mut cursor = Cursor::at(node.pair);
            let query = &queries[node.query as usize];
            control.traverse(query, node.query, &mut cursor, output, u64::MAX);
            worker.box_tests.fetch_add(cursor.work.box_tests, Relaxed);
            worker.triangle_tests.fetch_add(cursor.work.triangle_tests, Relaxed);
            // Looking at the node at all costs a test.
            let cost = 1.0 + cursor.work.cost() as f32;
            self.costs[position as usize].store(cost.to_bits(), Relaxed);
        }
    }
}

/// Runs a function on the calling thread, with a scope to call others.
pub(crate) fn in_scope<'s>(pool: Option<&ThreadPool>, run: impl FnOnce(&Scope<'s>)) {
    match pool {
        Some(pool) => pool.in_place_scope(run),
        None => rayon::in_place_scope(run),
    }
}
