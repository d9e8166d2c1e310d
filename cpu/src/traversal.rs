//! Frames of queries on p workers, with memory that is kept in between.

use crate::control::{Control, tests};
use crate::front::{FrontMemory, Start};
use crate::output::{self, Element, Output, Visitor};
use crate::stealing::Stealing;
use crate::workers::{Frame, Workers};
use crate::{Hit, Report, Schedule, Settings, Share};
use pfront_core::bvtt::{Cursor, Query, TrianglePair, Work};
use pfront_core::front::estimate;
use rayon::ThreadPool;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::slice::from_ref;
use std::sync::Arc;
use std::time::Instant;

/// Tests that the calling thread does before it calls others: about the time that the call takes.
const ALONE: u64 = 2048;

/// A frame that is expected to cost no more than this in box tests begins on the calling thread.
const WORTH_THREADS: f64 = 2000.0;

/// The largest number of workers p.
pub const MAX_WORKERS: usize = 4096;

/// Answers queries frame after frame with p workers.
///
/// Use one for each series of frames that resemble each other: the costs of the last frame tell how to
/// divide the next. Nothing but speed depends on it, and a jump is noticed. Verbs ending in `_of` ask
/// many queries at once, under one bound and one partition (eq. 5); a query is remembered by its number
/// in the slice, see [`Traversal::renumber`].
///
/// A frame that is expected to be small, and any search for one hit, begins on the calling thread. After as much work as
/// it takes to call others, the pending node pairs of its cursor start a front for them; nothing is done twice.
///
/// After a break or a panic in a visitor it can be used as before.
#[derive(Clone, Debug)]
pub struct Traversal {
    workers: usize,
    settings: Settings,
    pool: Option<Arc<ThreadPool>>,
    deadline: Option<Instant>,
    front: FrontMemory,
    /// The cost of the last whole frame.
    last_cost: Option<f64>,
    starts: Vec<Start>,
    buffers: Workers,
    pairs: Vec<Vec<TrianglePair>>,
    hits: Vec<Vec<Hit>>,
    report: Report,
}

impl Traversal {
    /// A traversal with p = `workers` parts, in the rayon pool of the calling thread. The number is clamped to 1 to
    /// [`MAX_WORKERS`], as for every p the answer is the same and memory grows with p: see [`Traversal::workers`].
    #[must_use]
    pub fn new(workers: usize) -> Self {
        Self {
            workers: workers.clamp(1, MAX_WORKERS),
            settings: Settings::default(),
            pool: None,
            deadline: None,
            front: FrontMemory::default(),
            last_cost: None,
            starts: Vec::new(),
            buffers: Workers::default(),
            pairs: Vec::new(),
            hits: Vec::new(),
            report: Report::default(),
        }
    }

    /// A traversal with one worker for each thread of `pool`, in which it runs.
    #[must_use]
    pub fn with_pool(pool: Arc<ThreadPool>) -> Self {
        Self { pool: Some(pool.clone()), ..Self::new(pool.current_num_threads()) }
    }

    /// The same with other settings.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Self { settings, ..self }
    }

    /// Changes the number of workers p. What is remembered of the last frame stays.
    pub fn set_workers(&mut self, workers: usize) {
        self.workers = workers.clamp(1, MAX_WORKERS);
    }

    /// Sets the instant at which frames end, complete or not: see [`Report::late`]. Under every schedule each thread looks at the
    /// clock before every 4096 tests, about 0.1 ms. Generating a front and sorting are not interrupted.
    ///
    /// # Examples
    /// ```
    /// # use pfront_cpu::Traversal;
    /// use std::time::{Duration, Instant};
    /// let mut traversal = Traversal::new(2);
    /// traversal.set_deadline(Instant::now().checked_add(Duration::from_millis(2)));
    /// ```
    pub fn set_deadline(&mut self, deadline: Option<Instant>) {
        self.deadline = deadline;
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The number of workers p.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.workers
    }

    /// The report of the last frame.
    #[must_use]
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Forgets the costs of the last frame, for a next one that does not resemble it.
    pub fn forget(&mut self) {
        self.front.forget();
        self.last_cost = None;
    }

    /// Runs a function in the pool of this traversal.
    ///
    /// # Examples
    /// ```
    /// let traversal = pfront_cpu::Traversal::new(2);
    /// assert_eq!(traversal.install(|| rayon::join(|| 1, || 2)), (1, 2));
    /// ```
    pub fn install<R: Send>(&self, run: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(run),
            None => run(),
        }
    }

    /// Renumbers the queries of the last frame, for a next frame that asks other ones: `number` returns the new number
    /// of a query, or `None` if it is gone. Its costs stay with it.
    ///
    /// # Examples
    /// ```
    /// # use pfront_cpu::Traversal;
    /// let mut traversal = Traversal::new(8);
    /// // ... a frame of four queries, of which the third is then taken out:
    /// traversal.renumber(|query| [Some(0), Some(1), None, Some(2)][query as usize]);
    /// ```
    pub fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        self.front.renumber(number);
    }

    /// Replaces the contents of `out` by all intersecting pairs, sorted.
    pub fn all<Q: Query + Sync>(&mut self, query: &Q, out: &mut Vec<TrianglePair>) {
        let mut found = std::mem::take(&mut self.pairs);
        self.collect(from_ref(query), &mut found, out);
        self.pairs = found;
    }

    /// The number of intersecting pairs.
    pub fn count<Q: Query + Sync>(&mut self, query: &Q) -> u64 {
        self.count_of(from_ref(query))
    }

    /// Some intersecting pair, if there is one: the first that some worker finds, at which all stop. Which one
    /// that is may differ from call to call. Costs are neither used nor remembered.
    pub fn any<Q: Query + Sync>(&mut self, query: &Q) -> Option<TrianglePair> {
        Some(self.any_of(from_ref(query))?.pair)
    }

    /// Calls `visit` from all workers for each intersecting pair, in no particular order, until one of the
    /// calls breaks; calls that others have begun by then still end.
    pub fn visit<Q: Query + Sync>(
        &mut self,
        query: &Q,
        visit: impl Fn(TrianglePair) -> ControlFlow<()> + Sync,
    ) -> ControlFlow<()> {
        self.visit_of(from_ref(query), |hit| visit(hit.pair))
    }

    /// [`Traversal::all`] of many queries, sorted by query, then by pair.
    pub fn all_of<Q: Query + Sync>(&mut self, queries: &[Q], out: &mut Vec<Hit>) {
        let mut found = std::mem::take(&mut self.hits);
        self.collect(queries, &mut found, out);
        self.hits = found;
    }

    /// [`Traversal::count`] of many queries together.
    pub fn count_of<Q: Query + Sync>(&mut self, queries: &[Q]) -> u64 {
        let mut counts = Vec::new();
        self.run(queries, false, &mut counts, || 0);
        counts.into_iter().sum()
    }

    /// [`Traversal::any`] of many queries.
    pub fn any_of<Q: Query + Sync>(&mut self, queries: &[Q]) -> Option<Hit> {
        let mut found = Vec::new();
        self.run(queries, true, &mut found, || None);
        found.into_iter().flatten().min()
    }

    /// [`Traversal::visit`] of many queries.
    pub fn visit_of<Q: Query + Sync>(
        &mut self,
        queries: &[Q],
        visit: impl Fn(Hit) -> ControlFlow<()> + Sync,
    ) -> ControlFlow<()> {
        let complete = self.run(queries, false, &mut Vec::new(), || Visitor(&visit));
        if complete { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn collect<Q: Query + Sync, T: Element>(
        &mut self,
        queries: &[Q],
        found: &mut Vec<Vec<T>>,
        out: &mut Vec<T>,
    ) {
        found.truncate(self.workers);
        found.iter_mut().for_each(Vec::clear);
        self.run(queries, false, found, Vec::new);
        let clock = Instant::now();
        out.clear();
        found.iter().for_each(|found| out.extend_from_slice(found));
        if output::is_worth_threads(out.len(), self.workers) {
            self.install(|| out.par_sort_unstable());
        } else if let Some(scratch) = found.first_mut() {
            output::sort(out, scratch);
        }
        self.report.gather_time = clock.elapsed();
    }

    /// A frame, into the first of `outputs` and others that are added as needed. Returns whether it came to the end.
    fn run<Q: Query + Sync, O: Output>(
        &mut self,
        queries: &[Q],
        only_one_hit: bool,
        outputs: &mut Vec<O>,
        new_output: impl Fn() -> O + Send + Sync,
    ) -> bool {
        if outputs.is_empty() {
            outputs.push(new_output());
        }
        let mut shares = std::mem::take(&mut self.report.shares);
        shares.clear();
        let triangle_cost = self.settings.triangle_cost;
        self.report = Report { shares, triangle_cost, ..Report::default() };
        let control = Control::new(self.deadline);
        let alone = match self.workers {
            1 => u64::MAX,
            _ if !only_one_hit && self.expects_much(queries) => 0,
            _ => ALONE,
        };
        self.begin(queries, alone, &control, &mut outputs[0]);
        let is_whole = alone == 0;
        if !self.starts.is_empty() && !control.is_over() {
            match self.settings.schedule {
                Schedule::Stealing => self.steal(queries, &control, outputs, new_output),
                _ => self.divide(queries, is_whole, &control, outputs, new_output),
            }
        }
        self.report.late = control.was_late();
        let complete = !control.has_stopped();
        if complete && !only_one_hit {
            // Where nothing overlapped, nothing is known.
            let cost = self.report.cost(self.report.work());
            self.last_cost = Some(cost).filter(|&cost| cost > 0.0);
            if !is_whole {
                // What is left from earlier frames says less than an estimate.
                self.front.forget();
            }
        }
        complete
    }

    /// Whether a frame is worth several threads from the start: as the last one was, or, if there was none, by estimate.
    fn expects_much<Q: Query>(&self, queries: &[Q]) -> bool {
        self.last_cost.map_or_else(
            || {
                let roots = queries.iter().filter_map(|query| Some((query, query.root()?)));
                let mut costs = roots.map(|(query, root)| estimate(query, root));
                let sum = costs.try_fold(0.0, |sum, cost| {
                    if sum < WORTH_THREADS { Ok(sum + cost) } else { Err(sum) }
                });
                sum.map_or(true, |sum| sum >= WORTH_THREADS)
            },
            |cost| cost >= WORTH_THREADS,
        )
    }

    /// Traverses the queries in turn on the calling thread for `most` tests, and notes what is left.
    fn begin<Q: Query>(
        &mut self,
        queries: &[Q],
        most: u64,
        control: &Control,
        output: &mut impl Output,
    ) {
        let clock = Instant::now();
        self.starts.clear();
        let mut work = Work::default();
        for (query, number) in queries.iter().zip(0..) {
            let Some(root) = query.root() else { continue };
            let left = most.saturating_sub(tests(work));
            if left == 0 {
                self.starts.push(Start { query: number, pair: root });
                continue;
            }
            let mut cursor = Cursor::at(root);
            control.traverse(query, number, &mut cursor, output, left);
            let left = cursor.take_pending().iter().map(|&pair| Start { query: number, pair });
            self.starts.extend(left);
            // At most one leaf pair.
            control.traverse(query, number, &mut cursor, output, u64::MAX);
            work.box_tests += cursor.work.box_tests;
            work.triangle_tests += cursor.work.triangle_tests;
        }
        self.report.alone = work;
        self.report.traversal_time = clock.elapsed();
    }

    /// Divides the pending node pairs by a front. Costs are remembered for a front that begins at the roots.
    fn divide<Q: Query + Sync, O: Output>(
        &mut self,
        queries: &[Q],
        is_whole: bool,
        control: &Control,
        outputs: &mut Vec<O>,
        new_output: impl Fn() -> O,
    ) {
        let Self { workers, settings, pool, front, starts, buffers, report, .. } = self;
        report.shares.resize(*workers, Share::default());
        let settings = Settings { coherence: settings.coherence && is_whole, ..*settings };
        front.divide(queries, starts, &settings, report);
        let clock = Instant::now();
        let threads = pool
            .as_ref()
            .map_or_else(rayon::current_num_threads, |pool| pool.current_num_threads());
        outputs.resize_with(threads.min(*workers), new_output);
        let Settings { schedule, triangle_cost, .. } = settings;
        let frame = Frame { queries, nodes: front.nodes(), schedule, triangle_cost, control };
        buffers.traverse(&frame, pool.as_deref(), outputs, &mut report.shares);
        report.traversal_time += clock.elapsed();
        if is_whole && !control.has_stopped() {
            front.remember(buffers.costs());
        }
    }

    /// Traverses the pending node pairs by work stealing.
    fn steal<Q: Query + Sync, O: Output>(
        &mut self,
        queries: &[Q],
        control: &Control,
        outputs: &mut Vec<O>,
        new_output: impl Fn() -> O + Send + Sync,
    ) {
        let clock = Instant::now();
        let stealing = Stealing { queries, new_output, control };
        let found = self.install(|| stealing.run(&self.starts));
        outputs.extend(found.outputs);
        self.report.shares.push(Share { predicted: 0.0, work: found.work });
        self.report.traversal_time += clock.elapsed();
    }
}

/// The number of threads in the rayon pool of the calling thread.
#[must_use]
pub fn current_threads() -> usize {
    rayon::current_num_threads()
}
