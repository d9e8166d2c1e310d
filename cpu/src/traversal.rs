//! The engine: frames of queries on p workers, with all memory kept in between.

use crate::deal::Deal;
use crate::plan::Plan;
use crate::pool::in_pool;
use crate::sink::{self, Element, Sink, Visitor};
use crate::stealing::Stealing;
use crate::{Hit, Report, Schedule, Settings, Share};
use pfront_core::bvtt::{Query, TrianglePair};
use rayon::ThreadPool;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::slice::from_ref;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Instant;

/// From so many elements on, sorting on all threads is faster than on one.
const PARALLEL_SORT: usize = 1 << 14;

/// Answers queries frame after frame with p workers.
///
/// Use one for each series of frames that resemble each other: what the last frame cost tells how to
/// divide the next. Nothing but speed depends on it, and a jump is noticed. Verbs ending in `_of` ask
/// many queries at once, under one bound and one partition (eq. 5); a query is remembered by its number
/// in the slice, see [`Traversal::renumber`].
///
/// After a break or a panic in a visitor it can be used as before.
#[derive(Clone, Debug)]
pub struct Traversal {
    workers: usize,
    settings: Settings,
    pool: Option<Arc<ThreadPool>>,
    deadline: Option<Instant>,
    plan: Plan,
    deal: Deal,
    pairs: Vec<Vec<TrianglePair>>,
    hits: Vec<Vec<Hit>>,
    report: Report,
}

impl Traversal {
    /// With p = `workers` partitions, at least 1, in the rayon pool of whoever asks.
    #[must_use]
    pub fn new(workers: usize) -> Self {
        Self {
            workers: workers.max(1),
            settings: Settings::default(),
            pool: None,
            deadline: None,
            plan: Plan::default(),
            deal: Deal::default(),
            pairs: Vec::new(),
            hits: Vec::new(),
            report: Report::default(),
        }
    }

    /// With one worker for each thread of a pool, in which all work is done.
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
        self.workers = workers.max(1);
    }

    /// Frames end at this instant, complete or not: see [`Report::late`]. Workers look at the clock before
    /// each node of the front.
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

    /// How it works.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The number of workers p.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.workers
    }

    /// What the last frame did.
    #[must_use]
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Forgets the last frame: the next one is something else.
    pub fn forget(&mut self) {
        self.plan.forget();
    }

    /// Runs something else where its work is done: in its pool if it has one.
    ///
    /// # Examples
    /// ```
    /// let traversal = pfront_cpu::Traversal::new(2);
    /// assert_eq!(traversal.install(|| rayon::join(|| 1, || 2)), (1, 2));
    /// ```
    pub fn install<R: Send>(&self, run: impl FnOnce() -> R + Send) -> R {
        in_pool(self.pool.as_deref(), run)
    }

    /// Where the next frame asks other queries than the last: tells the number that each query of the
    /// last will have, or `None` if it is gone, so that what is remembered of it stays with it.
    ///
    /// # Examples
    /// ```
    /// # use pfront_cpu::Traversal;
    /// let mut traversal = Traversal::new(8);
    /// // ... a frame of four queries, of which the third is then taken out:
    /// traversal.renumber(|query| [Some(0), Some(1), None, Some(2)][query as usize]);
    /// ```
    pub fn renumber(&mut self, number: impl FnMut(u32) -> Option<u32>) {
        self.plan.renumber(number);
    }

    /// Replaces the contents of `out` by all pairs that meet, sorted.
    pub fn all<Q: Query + Sync>(&mut self, query: &Q, out: &mut Vec<TrianglePair>) {
        let mut sinks = std::mem::take(&mut self.pairs);
        self.collect(from_ref(query), &mut sinks, out);
        self.pairs = sinks;
    }

    /// How many pairs meet.
    pub fn count<Q: Query + Sync>(&mut self, query: &Q) -> u64 {
        self.count_of(from_ref(query))
    }

    /// Some pair that meets, if any does: the first that some worker finds, at which all stop. Which one
    /// that is may differ from call to call.
    pub fn any<Q: Query + Sync>(&mut self, query: &Q) -> Option<TrianglePair> {
        Some(self.any_of(from_ref(query))?.pair)
    }

    /// Calls `visit` from all workers for each pair that meets, in no particular order, until one of the
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
        let mut sinks = std::mem::take(&mut self.hits);
        self.collect(queries, &mut sinks, out);
        self.hits = sinks;
    }

    /// [`Traversal::count`] of many queries together.
    pub fn count_of<Q: Query + Sync>(&mut self, queries: &[Q]) -> u64 {
        let mut counts = vec![0_u64; self.workers];
        self.run(queries, &mut counts, || 0);
        counts.iter().sum()
    }

    /// [`Traversal::any`] of many queries.
    pub fn any_of<Q: Query + Sync>(&mut self, queries: &[Q]) -> Option<Hit> {
        let mut found = vec![None; self.workers];
        self.run(queries, &mut found, || None);
        found.into_iter().flatten().min()
    }

    /// [`Traversal::visit`] of many queries.
    pub fn visit_of<Q: Query + Sync>(
        &mut self,
        queries: &[Q],
        visit: impl Fn(Hit) -> ControlFlow<()> + Sync,
    ) -> ControlFlow<()> {
        let mut visitors: Vec<_> = (0..self.workers).map(|_| Visitor(&visit)).collect();
        let complete = self.run(queries, &mut visitors, || Visitor(&visit));
        if complete { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn collect<Q: Query + Sync, T: Element>(
        &mut self,
        queries: &[Q],
        sinks: &mut Vec<Vec<T>>,
        out: &mut Vec<T>,
    ) {
        sink::clear(sinks, self.workers);
        self.run(queries, sinks, Vec::new);
        self.gather(sinks, out);
    }

    /// Puts what was found in order.
    fn gather<T: Element>(&mut self, sinks: &[Vec<T>], out: &mut Vec<T>) {
        let clock = Instant::now();
        out.clear();
        sinks.iter().for_each(|found| out.extend_from_slice(found));
        if out.len() >= PARALLEL_SORT && self.workers > 1 {
            in_pool(self.pool.as_deref(), || out.par_sort_unstable());
        } else {
            out.sort_unstable();
        }
        self.report.gather_time = clock.elapsed();
    }

    /// A frame, into one sink per worker; `new_sink` makes more of them for stealing. Returns whether it
    /// came to the end.
    fn run<Q: Query + Sync, S: Sink>(
        &mut self,
        queries: &[Q],
        sinks: &mut Vec<S>,
        new_sink: impl Fn() -> S + Send + Sync,
    ) -> bool {
        let Self { workers, settings, pool, deadline, plan, deal, report, .. } = self;
        report.reset(settings.triangle_cost);
        in_pool(pool.as_deref(), || {
            if settings.schedule == Schedule::Stealing {
                let clock = Instant::now();
                let stealing = Stealing { queries, new_sink, stop: AtomicBool::new(false) };
                let found = stealing.run();
                sinks.extend(found.sinks);
                report.shares.push(Share { predicted: 0.0, work: found.work });
                report.walk_time = clock.elapsed();
                return !stealing.stop.load(Relaxed);
            }
            report.shares.resize(*workers, Share::default());
            plan.make(queries, *workers, settings, report);
            let complete = deal.walk(plan, queries, settings.schedule, *deadline, sinks, report);
            if complete {
                plan.remember(deal.costs());
            }
            complete
        })
    }
}
