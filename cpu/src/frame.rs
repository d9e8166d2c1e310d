//! One frame: alone for a while if that may do, and then by a front or by stealing.

use crate::control::{Control, tests};
use crate::front::Start;
use crate::output::Output;
use crate::report::sum;
use crate::stealing::Stealing;
use crate::workers::Frame;
use crate::{Report, Schedule, Settings, Share, Traversal};
use pfront_core::bvtt::{Cursor, Query, Work};
use pfront_core::front::estimate;
use std::time::Instant;

/// Tests of both kinds that the calling thread does before it calls others: about the time that the call takes. A frame
/// whose expected cost, in box tests, is lower than this begins there.
const ALONE: u64 = 2048;

impl Traversal {
    /// A frame, into the first of `outputs` and others that are added as needed. Returns whether it came to the end.
    pub(crate) fn run<Q: Query + Sync, O: Output>(
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
        self.report = Report { shares, ..Report::default() };
        let control = Control::new(self.deadline, self.cancel.clone());
        let alone = match self.p() {
            1 => u64::MAX,
            _ if !only_one_hit && self.expects_much(queries) => 0,
            _ => ALONE,
        };
        self.begin(queries, alone, &control, &mut outputs[0]);
        let from_roots = alone == 0;
        if !self.starts.is_empty() && !control.is_over() {
            match self.settings.schedule {
                Schedule::Stealing => self.steal(queries, &control, outputs, new_output),
                _ => self.divide(queries, from_roots, &control, outputs, new_output),
            }
        }
        self.report.late = control.was_late();
        let complete = !control.has_stopped();
        if complete && !only_one_hit {
            // A frame in which nothing overlapped says nothing about the cost of the next.
            self.last_cost = Some(self.report.work().cost()).filter(|&cost| cost > 0.0);
            if !from_roots {
                // This frame has not remembered its costs. The history is that of an earlier frame, which predicts the
                // next one worse than an estimate does, so it goes.
                self.front.forget();
            }
        }
        complete
    }

    /// Whether a frame is worth several threads from the start: by the cost of the last one, or, if there was none, by
    /// estimate.
    fn expects_much<Q: Query>(&self, queries: &[Q]) -> bool {
        let estimated = || {
            let roots = queries.iter().filter_map(|query| Some((query, query.root()?)));
            roots.map(|(query, root)| estimate(query, root)).sum()
        };
        self.last_cost.unwrap_or_else(estimated) >= ALONE as f64
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
            // The cursor is left with at most one leaf pair, which is visited to its end.
            control.traverse(query, number, &mut cursor, output, u64::MAX);
            work = sum(work, cursor.work);
        }
        self.report.alone = work;
        self.report.traversal_time = clock.elapsed();
    }

    /// Divides the pending node pairs by a front. Costs are remembered for a front that begins at the roots.
    fn divide<Q: Query + Sync, O: Output>(
        &mut self,
        queries: &[Q],
        from_roots: bool,
        control: &Control,
        outputs: &mut Vec<O>,
        new_output: impl Fn() -> O,
    ) {
        let (p, threads) = (self.p(), self.threads());
        let Self { settings, pool, front, starts, buffers, report, .. } = self;
        report.shares.resize(p, Share::default());
        let settings = Settings { coherence: settings.coherence && from_roots, ..*settings };
        front.divide(queries, starts, &settings, report);
        let clock = Instant::now();
        outputs.resize_with(threads, new_output);
        let frame = Frame { queries, nodes: front.nodes(), schedule: settings.schedule, control };
        buffers.traverse(&frame, pool.as_deref(), outputs, &mut report.shares);
        report.traversal_time += clock.elapsed();
        if from_roots && !control.has_stopped() {
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
