//! One frame: alone for a while if that may do, and then divided by a front.

use crate::control::{Control, SLICE};
use crate::front::Start;
use crate::memory::{push, reserve, resize};
use crate::output::Output;
use crate::workers::DividedFrame;
use crate::{MemoryError, Queries, Report, Schedule, Traversal};
use pfront_core::bvtt::{Query, Work};
use pfront_core::environment::{Environment, with_default};
use pfront_core::front::estimate;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// Tests of both kinds that the calling thread does before it calls others, if nobody has measured what a call takes
/// ([`Pool::measured`](crate::Pool::measured)). A frame whose expected cost, in box tests, is lower than this begins there.
const ALONE: u64 = 2048;

/// Tests between two looks at the clock while others may be called, and in a search for one hit at whether a thread has nothing
/// to do. A frame that ends sooner is not timed: that would take as long as a part of such a frame.
const STEP: u64 = 512;

/// The remembered overhead of a frame on several threads shrinks to this part of it with each frame on the calling thread, so
/// that others are called again sooner or later, in case they have become faster.
const FADING: f64 = 31.0 / 32.0;

/// The part of its share of the work after which a thread looks whether another has nothing to do. A policy: another waits no
/// longer than this for work.
const LATENESS: f64 = 1.0 / 32.0;

/// The fewest tests between two such looks: after each, the triangles of some leaves are loaded anew.
const FEWEST: u64 = 256;

impl Traversal {
    /// A frame, into the first of `outputs` and others that are added as needed. Returns whether it came to the end.
    ///
    /// # Errors
    /// [`MemoryError`] if an output or the front cannot grow. All threads have stopped then, and the memory of the last frames
    /// is given back.
    pub(crate) fn run<Q: Queries + ?Sized, O: Output>(
        &mut self,
        queries: &Q,
        only_one_hit: bool,
        outputs: &mut Vec<O>,
        new_output: impl Fn() -> O,
    ) -> Result<bool, MemoryError> {
        let mut ended = self.try_run(queries, only_one_hit, outputs, new_output);
        if let Some(failure) = outputs.iter().find_map(Output::failure) {
            ended = Err(failure);
        }
        if ended.is_err() {
            self.release();
        }
        ended
    }

    fn try_run<Q: Queries + ?Sized, O: Output>(
        &mut self,
        queries: &Q,
        only_one_hit: bool,
        outputs: &mut Vec<O>,
        new_output: impl Fn() -> O,
    ) -> Result<bool, MemoryError> {
        if outputs.is_empty() {
            push(outputs, new_output())?;
        }
        let mut shares = std::mem::take(&mut self.report.shares);
        shares.clear();
        self.report = Report { shares, ..Report::default() };
        let control = Control::new(self.deadline, self.cancel.clone());
        outputs[0].begin(Environment::current());
        let from_roots =
            with_default(|| self.begin(queries, only_one_hit, &control, &mut outputs[0]))?;
        let is_divided = !self.starts.is_empty() && !control.is_over();
        let clock = is_divided.then(Instant::now);
        self.called = 0;
        if is_divided {
            let threads = with_default(|| self.threads(from_roots));
            let parts = if threads == self.pool.threads() { self.pool.p() } else { threads };
            resize(&mut self.report.shares, parts)?;
            let more = threads.saturating_sub(outputs.len());
            reserve(outputs, more)?;
            outputs.extend(std::iter::repeat_with(new_output).take(more));
            self.called = threads;
            let outputs = &mut outputs[..threads];
            self.divide(queries, from_roots, only_one_hit, &control, outputs)?;
        }
        self.report.late = control.was_late();
        self.report.cancelled = control.was_cancelled();
        let is_complete = !control.has_stopped();
        let time = clock.map(|clock| clock.elapsed());
        with_default(|| self.learn(time, from_roots, is_complete && !only_one_hit));
        Ok(is_complete)
    }

    /// Begins a frame on the calling thread, unless it is expected to be worth several from the start; returns whether it is.
    fn begin<Q: Queries + ?Sized>(
        &mut self,
        queries: &Q,
        only_one_hit: bool,
        control: &Control,
        output: &mut impl Output,
    ) -> Result<bool, MemoryError> {
        let from_roots = self.pool.p() > 1 && !only_one_hit && self.expects_much(queries);
        // Nearly as long as predicted is no reason to call others shortly before the end.
        let predicted = if only_one_hit { 0.0 } else { self.predicted() };
        let alone = self.pool.worth().map(|worth| worth.max(2.0 * predicted));
        self.traverse_alone(queries, from_roots, alone, control, output)?;
        Ok(from_roots)
    }

    /// Takes note of what a frame took, for the next: the time that others worked on it, if they did, and the costs, if it
    /// `is_whole`.
    fn learn(&mut self, divided: Option<Duration>, from_roots: bool, is_whole: bool) {
        if let Some(time) = divided {
            let work = self.report.work().cost() - self.report.alone.cost();
            let ideal = work * self.pace.unwrap_or_default() / self.called as f64;
            self.overhead = (time.as_secs_f64() - ideal).max(0.0);
            let idle = time.saturating_sub(self.report.busy_time).as_secs_f64();
            let calls = self.pool.calls.as_deref().unwrap_or_default();
            if let Some(call) = calls.iter().find(|call| call.threads == self.called) {
                self.calls = (idle / call.seconds).max(1.0);
            }
        } else {
            self.overhead *= FADING;
        }
        if is_whole {
            // A frame in which nothing overlapped says nothing about the cost of the next.
            self.last_cost = Some(self.report.work().cost()).filter(|&cost| cost > 0.0);
            if !from_roots {
                // This frame has not remembered its costs. The history is that of an earlier frame, which predicts the
                // next one worse than an estimate does, so it goes.
                self.front.forget();
            }
        }
    }

    /// Whether a frame is worth several threads from the start: by the last one. If nobody has measured what a call takes, a
    /// first frame goes by an estimate; else nothing is expected of it, since estimates are often too high.
    fn expects_much<Q: Queries + ?Sized>(&self, queries: &Q) -> bool {
        if self.pool.calls.is_some() {
            let predicted = self.predicted();
            let fastest = self.pool.fastest(predicted, self.calls);
            let is_worth = fastest.is_some_and(|call| predicted >= call.worth(self.overhead));
            return self.last_cost.is_some() && is_worth;
        }
        let estimated = || {
            let roots = (0..queries.len() as u32).filter_map(|n| Some((n, queries.root(n)?)));
            roots.map(|(number, root)| estimate(&queries.query(number), root)).sum()
        };
        self.last_cost.unwrap_or_else(estimated) >= ALONE as f64
    }

    /// The seconds that a frame like the last one takes the calling thread.
    fn predicted(&self) -> f64 {
        self.last_cost.unwrap_or_default() * self.pace.unwrap_or_default()
    }

    /// The threads for a frame that is like the last one, or of which as much is left as was done.
    fn threads(&self, from_roots: bool) -> usize {
        let left = if from_roots { self.predicted() } else { self.report.alone_time.as_secs_f64() };
        let fastest = self.pool.fastest(left, self.calls);
        fastest.map_or_else(|| self.pool.threads(), |call| call.threads)
    }

    /// Traverses the queries in turn on the calling thread, for so many seconds `alone` if they are known, unless the frame
    /// is to be divided `from_roots`; notes what is left.
    fn traverse_alone<Q: Queries + ?Sized>(
        &mut self,
        queries: &Q,
        from_roots: bool,
        alone: Option<f64>,
        control: &Control,
        output: &mut impl Output,
    ) -> Result<(), MemoryError> {
        self.starts.clear();
        let (mut work, mut is_enough) = (Work::default(), from_roots);
        // The end of the first step, and the work until then.
        let mut clock: Option<(Instant, f64)> = None;
        for number in 0..queries.len() as u32 {
            if is_enough {
                if let Some(pair) = queries.root(number) {
                    push(&mut self.starts, Start { query: number, pair })?;
                }
                continue;
            }
            let query = &queries.query(number);
            let mut cursor = query.start();
            while !cursor.is_done() && !is_enough && !control.is_over() {
                let next = if self.pool.p() == 1 { u64::MAX } else { cursor.work.tests() + STEP };
                control.traverse(query, number, &mut cursor, output, next, &|| false);
                let done = work + cursor.work;
                if self.pool.p() > 1 && done.tests() >= STEP {
                    let (clock, _) = clock.get_or_insert_with(|| (Instant::now(), done.cost()));
                    is_enough = match alone {
                        Some(alone) => clock.elapsed().as_secs_f64() >= alone,
                        None => done.tests() >= ALONE,
                    };
                }
            }
            let left = cursor.take_pending().iter().map(|&pair| Start { query: number, pair });
            reserve(&mut self.starts, left.len())?;
            self.starts.extend(left);
            // The cursor is left with at most one leaf pair, which is visited to its end.
            control.traverse(query, number, &mut cursor, output, u64::MAX, &|| false);
            work = work + cursor.work;
        }
        self.report.alone = work;
        if let Some((clock, before)) = clock {
            self.report.alone_time = clock.elapsed();
            self.report.traversal_time = self.report.alone_time;
            if is_enough {
                let cost = (work.cost() - before).max(1.0);
                self.pace = Some(self.report.alone_time.as_secs_f64() / cost);
            }
        }
        Ok(())
    }

    /// Divides the pending node pairs by a front, or, for one hit, as they are: a front would change the order, since the dearest
    /// nodes would come first, and a hit that is near for one thread might be far. Costs are remembered for a front that
    /// begins at the roots.
    fn divide<Q: Queries + ?Sized, O: Output>(
        &mut self,
        queries: &Q,
        from_roots: bool,
        only_one_hit: bool,
        control: &Control,
        outputs: &mut [O],
    ) -> Result<(), MemoryError> {
        let (threads, expected) = (outputs.len(), self.last_cost);
        let Self { pool, front, starts, buffers, report, .. } = self;
        let mut settings = pool.settings;
        settings.coherence &= from_roots;
        // A thread of the pool may have other things to do than to wait for this front.
        let in_pool = rayon::current_thread_index().is_some();
        let waiting = if in_pool || only_one_hit { 1 } else { threads };
        pool.awake(waiting, |is_ready| {
            let divided = with_default(|| {
                if only_one_hit {
                    front.list(in_order(starts))
                } else {
                    front.divide(queries, starts, &settings, report)
                }
            });
            // Nobody stays awake for a front that there is no memory for.
            is_ready.store(divided.is_err(), Relaxed);
            divided?;
            let slice = with_default(|| {
                let predicted = || report.shares.iter().map(|share| share.predicted).sum();
                let mean = expected.unwrap_or_else(predicted) / threads as f64;
                match settings.schedule {
                    _ if only_one_hit => Some(STEP),
                    Schedule::Static => None,
                    Schedule::Hybrid => Some(((mean * LATENESS) as u64).clamp(FEWEST, SLICE)),
                }
            });
            let clock = Instant::now();
            let frame =
                DividedFrame { queries, nodes: front.nodes(), slice, only_one_hit, control };
            is_ready.store(true, Relaxed);
            [report.waking_time, report.busy_time] =
                buffers.traverse(&frame, pool, outputs, &mut report.shares)?;
            report.traversal_time += clock.elapsed();
            Ok(())
        })?;
        if from_roots && !control.has_stopped() {
            with_default(|| front.remember(buffers.costs(), report.front.coherent));
        }
        Ok(())
    }
}

/// Pending node pairs in the order in which one thread would go on: the last that its cursor left is the next, and the roots of
/// other queries follow as they are.
fn in_order(starts: &[Start]) -> impl ExactSizeIterator<Item = Start> {
    let query = starts.first().map(|start| start.query);
    let pending = starts.iter().take_while(|start| Some(start.query) == query).count();
    (0..starts.len()).map(move |i| starts[if i < pending { pending - 1 - i } else { i }])
}
