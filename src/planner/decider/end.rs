//! How a frame ends, and what is learned of it.

use super::Decider;
use crate::planner::Concession;
use crate::planner::history::{Frame, Known, Way};
use crate::planner::plan::{Backend, Reason};
use std::time::Duration;

impl Decider {
    /// A question that was begun with no thought is over.
    pub(crate) fn was_brief(&mut self, cost: f64) {
        self.histories[self.asked].learn_cost(self.planner.machine(), cost);
        self.end_small(cost);
    }

    /// There was nothing to ask, which tells nothing of other frames.
    pub(crate) fn was_nothing(&mut self) {
        self.forget_ahead();
        self.end_small(0.0);
    }

    fn end_small(&mut self, cost: f64) {
        self.was_elsewhere = true;
        let has_failed = std::mem::take(&mut self.has_failed);
        let reason = if has_failed { Reason::GpuFailed } else { Reason::Small };
        self.end_as(Backend::Sequential, reason, Some(cost));
    }

    /// There is nothing to do.
    pub(crate) fn keep(&mut self) {
        self.forget_ahead();
        self.end_as(Backend::Kept, Reason::Unchanged, None);
    }

    fn end_as(&mut self, backend: Backend, reason: Reason, cost: Option<f64>) {
        self.untimed = Some((backend, reason, cost));
    }

    /// Goes on without a GPU, and says how.
    #[cfg(feature = "gpu")]
    pub(crate) fn gpu_failed(&mut self, error: &crate::gpu::Error) -> Way {
        self.clock.lose();
        self.has_failed = true;
        self.failure = Some(format!("the GPU is not used any more: {error}"));
        match self.planner.threads(0) {
            1 => Way::Alone,
            threads => Way::Threads(threads),
        }
    }

    /// Ends a frame.
    pub(crate) fn end(&mut self, way: Way, cost: Option<f64>, leaf_pairs: Option<u32>) {
        let prepared = std::mem::take(&mut self.prepared);
        let actual = self.finish(way, prepared, cost);
        let nanoseconds = |time: Duration| time.as_secs_f64() * 1e9;
        let frame = Frame {
            nanoseconds: nanoseconds(actual),
            beside: nanoseconds(self.clock.lost() + prepared),
            gpu_upkeep: self.last.map_or(0.0, |last| last.choice.gpu_upkeep),
            known: self.last.map_or(Known::default(), |last| last.choice.known),
            look: self.looked,
            pace: self.pace,
            cost,
            leaf_pairs,
        };
        self.histories[self.asked].learn(self.planner.machine(), way, &frame);
    }

    /// Ends a frame for which time ran out, and which tells nothing of others.
    pub(crate) fn end_incomplete(&mut self, way: Way) {
        let prepared = std::mem::take(&mut self.prepared);
        self.finish(way, prepared, None);
        if let Some(last) = &mut self.last {
            last.concession = Some(Concession::Incomplete);
        }
    }

    fn finish(&mut self, way: Way, prepared: Duration, cost: Option<f64>) -> Duration {
        let actual = self.clock.elapsed() + prepared;
        self.was_elsewhere = !matches!(way, Way::Threads(_));
        let has_failed = std::mem::take(&mut self.has_failed);
        if let Some(last) = &mut self.last {
            (last.backend, last.cost, last.actual) = (way.into(), cost, actual);
            if has_failed {
                last.reason = Reason::GpuFailed;
            }
        }
        actual
    }
}
