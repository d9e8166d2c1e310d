//! The clock of a frame, which is looked at as late and as rarely as possible: on some machines that takes as long as
//! a small question.

use std::time::{Duration, Instant};

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clock {
    begun: Option<Instant>,
    /// What was done in vain, or is the same each way.
    lost: Duration,
    /// When a question that was begun alone had cost how much.
    marked: Option<(f64, Duration)>,
}

impl Clock {
    /// At the beginning of a frame.
    pub(super) fn started(is_timed: bool) -> Self {
        Self { begun: is_timed.then(Instant::now), ..Self::default() }
    }

    /// Looks, if that has not been done. What was done before the last `alone` is the same each way.
    pub(super) fn look(&mut self, alone: Duration) {
        match self.begun {
            None => self.begun = Instant::now().checked_sub(alone),
            Some(_) => self.lost = self.elapsed().saturating_sub(alone),
        }
    }

    pub(super) fn begun(&self) -> Option<Instant> {
        self.begun
    }

    pub(super) fn elapsed(&self) -> Duration {
        self.begun.map_or(Duration::ZERO, |begun| begun.elapsed())
    }

    pub(super) fn lost(&self) -> Duration {
        self.lost
    }

    /// Without what is lost.
    pub(super) fn spent(&self) -> Duration {
        self.elapsed().saturating_sub(self.lost)
    }

    /// All that was done up to now was done in vain.
    pub(super) fn lose(&mut self) {
        self.lost = self.elapsed();
    }

    /// So much of a question is done.
    pub(super) fn mark(&mut self, cost: f64) {
        self.marked = Some((cost, self.elapsed()));
    }

    pub(super) fn is_marked(&self) -> bool {
        self.marked.is_some()
    }

    /// What this much of a question takes, in nanoseconds, at the pace since the mark.
    pub(super) fn pace(&self, cost: f64) -> Option<f64> {
        let (before, time) = self.marked?;
        let took = self.elapsed().saturating_sub(time).as_secs_f64() * 1e9;
        Some(took * cost / (cost - before).max(1.0))
    }
}
