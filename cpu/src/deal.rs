//! Walking a front that has been dealt out: each worker its own nodes, and, where that is allowed, nodes
//! that others have not begun.

use crate::plan::Plan;
use crate::sink::Sink;
use crate::{Report, Schedule};
use pfront_core::bvtt::{Cursor, NodePair, Query, Work};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

/// A front that costs less than this in box tests, some 20 µs, is walked by the calling thread: waking
/// others takes as long.
const WORTH_THREADS: f64 = 2000.0;

/// Buffers of one schedule of nodes over workers.
#[derive(Debug, Default)]
pub(crate) struct Deal {
    /// Positions of the nodes in the dealt front, worker by worker, dearest first.
    order: Vec<u32>,
    /// Where the nodes of each worker begin in `order`, and after the last, their end.
    first: Vec<usize>,
    /// How many of its nodes each worker, or a thief, has begun.
    begun: Vec<AtomicUsize>,
    workers: Vec<Worker>,
    /// True cost of each node by its index.
    costs: Vec<f32>,
}

/// Nothing in the buffers outlives a frame.
impl Clone for Deal {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug, Default)]
struct Worker {
    work: Work,
    /// Index and cost of each node it has walked.
    costs: Vec<(u32, f32)>,
}

/// What all workers see.
struct Shared<'s, Q> {
    plan: &'s Plan,
    queries: &'s [Q],
    order: &'s [u32],
    first: &'s [usize],
    begun: &'s [AtomicUsize],
    triangle_cost: f32,
    steal: bool,
    /// How many workers have started.
    started: AtomicUsize,
    stop: AtomicBool,
    deadline: Option<Instant>,
    /// Whether it was missed.
    late: AtomicBool,
}

impl Deal {
    /// Walks the front into one sink per worker. Returns whether it came to the end; only then are the
    /// costs of all nodes known.
    pub(crate) fn walk<Q: Query + Sync, S: Sink>(
        &mut self,
        plan: &Plan,
        queries: &[Q],
        schedule: Schedule,
        deadline: Option<Instant>,
        sinks: &mut [S],
        report: &mut Report,
    ) -> bool {
        let clock = Instant::now();
        self.group(plan, sinks.len());
        let shared = Shared {
            plan,
            queries,
            order: &self.order,
            first: &self.first,
            begun: &self.begun,
            triangle_cost: report.triangle_cost,
            steal: schedule == Schedule::Hybrid,
            started: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
            deadline,
            late: AtomicBool::new(false),
        };
        let predicted: f64 = report.shares.iter().map(|share| share.predicted).sum();
        if sinks.len() == 1 || predicted < WORTH_THREADS {
            let workers = self.workers.iter_mut().zip(sinks).enumerate();
            workers.for_each(|(part, (worker, sink))| worker.run(&shared, part, sink));
        } else {
            let workers = self.workers.par_iter_mut().zip(sinks).enumerate().with_max_len(1);
            workers.for_each(|(part, (worker, sink))| worker.run(&shared, part, sink));
        }
        let complete = !shared.stop.load(Relaxed);
        report.late = shared.late.load(Relaxed);
        for (share, worker) in report.shares.iter_mut().zip(&self.workers) {
            share.work = worker.work;
        }
        self.costs.clear();
        self.costs.resize(plan.len(), 0.0);
        for &(index, cost) in self.workers.iter().flat_map(|worker| &worker.costs) {
            self.costs[index as usize] = cost;
        }
        report.dearest_node = f64::from(self.costs.iter().copied().fold(0.0, f32::max));
        report.walk_time = clock.elapsed();
        complete
    }

    /// True cost of each node by its index.
    pub(crate) fn costs(&self) -> &[f32] {
        &self.costs
    }

    /// Sorts nodes by worker, keeping their order otherwise.
    fn group(&mut self, plan: &Plan, workers: usize) {
        self.first.clear();
        self.first.resize(workers + 2, 0);
        for node in plan.nodes() {
            self.first[node.part as usize + 2] += 1;
        }
        for part in 0..workers {
            self.first[part + 2] += self.first[part + 1];
        }
        self.order.clear();
        self.order.resize(plan.nodes().len(), 0);
        for (node, position) in plan.nodes().iter().zip(0..) {
            let place = &mut self.first[node.part as usize + 1];
            self.order[*place] = position;
            *place += 1;
        }
        self.begun.resize_with(workers, AtomicUsize::default);
        self.begun.iter_mut().for_each(|begun| *begun.get_mut() = 0);
        self.workers.resize_with(workers, Worker::default);
        for worker in &mut self.workers {
            worker.work = Work::default();
            worker.costs.clear();
        }
    }
}

impl<Q: Query> Shared<'_, Q> {
    /// The next node of a worker's that nobody has begun, if it is not too late.
    fn next(&self, part: usize) -> Option<u32> {
        let nodes = &self.order[self.first[part]..self.first[part + 1]];
        // Without thieves nobody else counts, and the increment costs next to nothing.
        let next = nodes.get(self.begun[part].fetch_add(1, Relaxed)).copied()?;
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            self.late.store(true, Relaxed);
            self.stop.store(true, Relaxed);
            return None;
        }
        Some(next)
    }
}

impl Worker {
    fn run<Q: Query, S: Sink>(&mut self, shared: &Shared<'_, Q>, part: usize, sink: &mut S) {
        let workers = shared.begun.len();
        let mut cursor = Cursor::at(NodePair::default());
        shared.started.fetch_add(1, Relaxed);
        while let Some(position) = shared.next(part) {
            self.node(shared, position, &mut cursor, sink);
        }
        // While some worker has not started, this thread will rather be that one.
        if shared.steal && shared.started.load(Relaxed) == workers {
            for other in (part + 1..workers).chain(0..part) {
                while let Some(position) = shared.next(other) {
                    self.node(shared, position, &mut cursor, sink);
                }
            }
        }
        self.work = cursor.work();
    }

    fn node<Q: Query, S: Sink>(
        &mut self,
        shared: &Shared<'_, Q>,
        position: u32,
        cursor: &mut Cursor,
        sink: &mut S,
    ) {
        let node = &shared.plan.nodes()[position as usize];
        let before = cursor.work();
        cursor.restart(node.pair);
        walk(&shared.queries[node.query as usize], node.query, cursor, sink, &shared.stop);
        let after = cursor.work();
        let box_tests = (after.box_tests - before.box_tests) as f32;
        let triangle_tests = (after.triangle_tests - before.triangle_tests) as f32;
        // To look at the node at all costs a test.
        let cost = 1.0 + box_tests + shared.triangle_cost * triangle_tests;
        self.costs.push((node.index, cost));
    }
}

/// Walks from a cursor into a sink, unless some worker has said stop; says so when the sink does.
pub(crate) fn walk<Q: Query, S: Sink>(
    query: &Q,
    number: u32,
    cursor: &mut Cursor,
    sink: &mut S,
    stop: &AtomicBool,
) {
    if stop.load(Relaxed) {
        return;
    }
    let end = query.visit(cursor, |pair| {
        if stop.load(Relaxed) { ControlFlow::Break(()) } else { sink.take(number, pair) }
    });
    if end.is_break() {
        stop.store(true, Relaxed);
    }
}
