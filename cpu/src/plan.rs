//! The front of a frame, and what it remembers of the last.
//!
//! Memory is N nodes of 32 bytes and, for those of the last frame, 16 bytes each: at most 48·N. At first
//! N = max(1024, 80·p) and one for each query. Estimated nodes are made finer only as long as all of
//! them fit in; where the grain of measured ones asks for more, N doubles, up to `most_nodes`.

use crate::damping::Damping;
use crate::{Report, Schedule, Settings, parts};
use pfront_core::bvtt::Query;
use pfront_core::front::{COHERENT, Front, FrontNode, Past, PastCost};
use pfront_core::front::{Load, greedy, p_optimal};
use std::time::Instant;

/// Fronts of fewer nodes are not worth several threads: a node takes about 0.1 µs.
const PARALLEL_FROM: usize = 4096;

/// What a front may have without asking twice, see above.
const FEWEST_NODES: usize = 1024;
const NODES_PER_WORKER: usize = 80;

/// The starting front is kept at this many nodes or more, as far as there are any, and ...
const FEW: usize = 8;
/// ... at no more than this. One level more or less changes the number by at most a factor of 4, which is
/// less than MANY / FEW, so that the depth does not swing to and fro.
const MANY: usize = 16 * FEW;

#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    nodes: Vec<FrontNode>,
    len: usize,
    past: Vec<PastCost>,
    remembered: usize,
    loads: Vec<Load>,
    /// Depth of the starting front, once there was one.
    depth: Option<u32>,
    damping: Damping,
}

/// How a front came out.
#[derive(Clone, Copy, Default)]
pub(crate) struct Outcome {
    pub(crate) nodes: usize,
    pub(crate) box_tests: u64,
    /// Whether there was too little room.
    pub(crate) full: bool,
}

impl Plan {
    /// The nodes, dearest first.
    pub(crate) fn nodes(&self) -> &[FrontNode] {
        &self.nodes[..self.len]
    }

    /// How many nodes the whole front has.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Generates the front of `queries` and deals it out.
    pub(crate) fn make<Q: Query + Sync>(
        &mut self,
        queries: &[Q],
        workers: usize,
        settings: &Settings,
        report: &mut Report,
    ) {
        let clock = Instant::now();
        let most = settings.most_nodes.max(queries.len());
        self.grow(FEWEST_NODES.max(NODES_PER_WORKER * workers) + queries.len(), most);
        // One worker needs no front: the roots will do.
        report.depth = if workers == 1 { 0 } else { self.depth(queries) };
        report.coherent = settings.coherence && self.remembered > 0;
        self.start(queries, settings, report);
        if report.coherent && report.found < COHERENT {
            report.coherent = false;
            self.start(queries, settings, report);
        }
        if workers > 1 {
            self.refine(queries, workers, settings, report);
        }
        self.damping.note(self.len, report.coherent);
        self.adjust_depth(report.starting_nodes);
        report.front_time = clock.elapsed();
        self.deal(workers, report);
    }

    /// The starting fronts of all queries.
    fn start<Q: Query>(&mut self, queries: &[Q], settings: &Settings, report: &mut Report) {
        let past = Past::new(&self.past[..if report.coherent { self.remembered } else { 0 }]);
        let triangles = |query: &Q| -> u64 {
            let below = query.root().map(|root| query.triangles_below(root));
            below.into_iter().flatten().map(u64::from).sum()
        };
        let all: u64 = if report.depth > 0 { queries.iter().map(triangles).sum() } else { 0 };
        // Of all the nodes that there may be, each query gets a share by its size.
        let depth = |query: &Q| match all {
            0 => 0,
            _ => (triangles(query) << (2 * report.depth)).div_ceil(all).max(1).ilog2() / 2,
        };
        let mut front = Front::new(&mut self.nodes);
        for (query, number) in queries.iter().zip(0..) {
            front.keep_free(queries.len() - 1 - number as usize);
            // There is room for the root of each query.
            let started = front.start(query, number, depth(query), settings.estimate, past);
            debug_assert!(started.is_ok());
        }
        self.len = front.nodes().len();
        report.starting_nodes = self.len;
        report.found = front.found(past);
        report.front_box_tests += front.box_tests();
    }

    /// Algorithm 2: first to the grain of measured nodes, for which memory grows; from there on finer and
    /// finer where costs are estimates.
    fn refine<Q: Query + Sync>(
        &mut self,
        queries: &[Q],
        workers: usize,
        settings: &Settings,
        report: &mut Report,
    ) {
        let most = settings.most_nodes.max(queries.len());
        let mut settings = Settings { grain: settings.grain.sound(), ..*settings };
        let finest = match settings.schedule {
            // Stealing makes up for wrong estimates at less cost than a finer front: on random poses of
            // two bunnies, p = 8, a front of g = 8 takes 21 µs and leaves an imbalance of 1.16, one of
            // g = 48 takes 132 µs and leaves 1.01, of a walk of 80 µs. (Without stealing 1.6, 1.26.)
            Schedule::Hybrid => settings.grain.measured.min(settings.grain.estimated),
            Schedule::Static | Schedule::Stealing => settings.grain.estimated,
        };
        let coarsest = finest.min(settings.grain.measured);
        // In one go where all is likely to fit in: hardly any cost is an estimate while motion is coherent,
        // and of estimated nodes there are about 2.5 for each that is asked for.
        let fits = 2.5 * workers as f64 * finest <= self.nodes.len() as f64;
        let mut in_steps = !(report.coherent || fits);
        settings.grain.estimated = if in_steps { coarsest } else { finest };
        loop {
            let past = Past::new(&self.past[..if report.coherent { self.remembered } else { 0 }])
                .with_hold(self.damping.hold());
            let task = parts::Task { queries, workers, settings: &settings, past };
            let grain = settings.grain;
            let goal = workers as f64 * grain.measured.max(grain.estimated);
            let refined = if goal as usize >= PARALLEL_FROM && rayon::current_num_threads() > 1 {
                parts::refine(&task, &mut self.nodes, self.len)
            } else {
                task.refine(&mut self.nodes, self.len)
            };
            self.len = refined.nodes;
            report.front_box_tests += refined.box_tests;
            if !refined.full {
                if grain.estimated >= finest {
                    break;
                }
                // From 0, which does not grow by doubling, to one node for each worker.
                settings.grain.estimated = (2.0 * grain.estimated).max(1.0).min(finest);
            } else if grain.estimated <= coarsest {
                if !self.grow(2 * self.nodes.len(), most) {
                    break;
                }
            } else if in_steps {
                break;
            } else {
                in_steps = true;
                settings.grain.estimated = coarsest;
                self.start(queries, &settings, report);
            }
        }
    }

    /// Deals the front out to the workers.
    fn deal(&mut self, workers: usize, report: &mut Report) {
        let clock = Instant::now();
        report.p_optimal = p_optimal(&self.nodes[..self.len]);
        self.loads.resize(workers, Load::default());
        greedy(&mut self.nodes[..self.len], &mut self.loads);
        for load in &self.loads {
            report.shares[load.part as usize].predicted = load.cost;
        }
        report.nodes = self.len;
        report.front_bytes = self.nodes.capacity() * size_of::<FrontNode>()
            + self.past.capacity() * size_of::<PastCost>();
        report.partition_time = clock.elapsed();
    }

    /// Keeps what each node of the front really cost, by its index, for the next frame.
    pub(crate) fn remember(&mut self, costs: &[f32]) {
        if self.past.len() < self.len {
            // In steps, but not by doubling, which would break the bound on memory.
            let to = self.len.next_multiple_of(256);
            self.past.reserve_exact(to - self.past.len());
            self.past.resize(to, PastCost::default());
        }
        let cost = |node: &FrontNode| costs[node.index as usize];
        let past = Past::record(&mut self.past, &self.nodes[..self.len], cost);
        // The memory has just been made large enough.
        self.remembered = if past.is_ok() { self.len } else { 0 };
    }

    pub(crate) fn forget(&mut self) {
        self.remembered = 0;
    }

    /// Changes the numbers of the queries that were asked last to those that they will have; forgets the
    /// ones that get none.
    pub(crate) fn renumber(&mut self, number: impl FnMut(u32) -> Option<u32>) {
        self.remembered = Past::renumber(&mut self.past[..self.remembered], number);
    }

    /// Before the first frame with an overlap, from the size of the models: 4^2 to 4^5 nodes if all
    /// overlapped.
    fn depth<Q: Query>(&mut self, queries: &[Q]) -> u32 {
        if self.depth.is_none() {
            let roots = queries.iter().filter_map(|query| Some((query, query.root()?)));
            let triangles = roots.map(|(query, root)| query.triangles_below(root).iter().sum());
            self.depth = triangles.max().map(|n: u32| (n.max(1).ilog2() / 3).clamp(2, 5));
        }
        self.depth.unwrap_or(0)
    }

    /// Afterwards from how much overlaps.
    fn adjust_depth(&mut self, starting: usize) {
        let Some(depth) = &mut self.depth else { return };
        if starting > MANY {
            *depth = depth.saturating_sub(1);
        } else if (1..FEW).contains(&starting) && *depth < 8 {
            *depth += 1;
        }
    }

    fn grow(&mut self, to: usize, most: usize) -> bool {
        let to = to.min(most);
        let grows = to > self.nodes.len();
        if grows {
            self.nodes.resize(to, FrontNode::default());
        }
        grows
    }
}
