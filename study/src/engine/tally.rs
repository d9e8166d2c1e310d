//! What a planner did over many frames.

use crate::chart::median;
use pfront::planner::{Backend, Plan};
use std::fmt;
use std::time::Duration;

/// How often which backend answered, and what deciding took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Frames of each kind of [`Backend`], in the order of [`Tally::NAMES`].
    pub frames: [usize; 4],
    /// How often one frame was answered otherwise than the last.
    pub changes: usize,
    /// Of frames that took [`Tally::LONG`] or more: all of them together, and deciding in them, which is nothing
    /// where the planner did not even look at the clock.
    pub long: [Duration; 2],
    /// Of frames for which a time was predicted: by which factor it was off, up or down.
    errors: Vec<f64>,
    last: Option<usize>,
}

impl Tally {
    /// What kinds of backend are called.
    pub const NAMES: [&str; 4] = ["kept", "one thread", "threads", "GPU"];

    /// In frames that take less, deciding may take a larger share.
    pub const LONG: Duration = Duration::from_micros(10);

    /// Adds a frame, which took so long; returns whether it was answered otherwise than the last.
    pub fn add(&mut self, plan: &Plan, took: Duration) -> bool {
        let kind = match plan.backend {
            Backend::Kept => 0,
            Backend::Threads { .. } => 2,
            Backend::Gpu => 3,
            _ => 1,
        };
        self.frames[kind] += 1;
        if took >= Self::LONG {
            self.long[0] += took;
            self.long[1] += if plan.actual.is_zero() { Duration::ZERO } else { plan.deciding };
        }
        if let Some(predicted) = plan.predicted {
            let ratio = predicted.as_secs_f64() / plan.actual.as_secs_f64().max(1e-9);
            self.errors.push(ratio.max(1.0 / ratio.max(1e-9)));
        }
        let is_new = self.last.replace(kind).is_some_and(|last| last != kind);
        self.changes += usize::from(is_new);
        is_new
    }

    /// Who answered most often.
    #[must_use]
    pub fn mostly(&self) -> &'static str {
        let most = (0..self.frames.len()).rev().max_by_key(|&kind| self.frames[kind]);
        most.map_or("", |kind| Self::NAMES[kind])
    }

    /// By which factor predictions were off, the median; `None` where there was none.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        let mut errors = self.errors.clone();
        (!errors.is_empty()).then(|| median(&mut errors))
    }

    /// The share of deciding in frames that took [`Tally::LONG`] or more.
    #[must_use]
    pub fn deciding(&self) -> f64 {
        let [all, deciding] = self.long.map(|time| time.as_secs_f64());
        if all > 0.0 { deciding / all } else { 0.0 }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} frames", self.frames.iter().sum::<usize>())?;
        let mut before = ": ";
        for (name, count) in Self::NAMES.iter().zip(self.frames).filter(|(_, count)| *count > 0) {
            write!(f, "{before}{count} {name}")?;
            before = ", ";
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_told_apart_by_who_answered() {
        let mut tally = Tally::default();
        let mut plan = Plan::default();
        let backends = [Backend::Sequential, Backend::Threads { workers: 2 }, Backend::Kept];
        for (i, backend) in [0, 1, 1, 2, 1].map(|i| backends[i]).into_iter().enumerate() {
            plan.backend = backend;
            plan.predicted = Some(Duration::from_micros(40));
            let took = Duration::from_micros(if i == 0 { 9 } else { 20 });
            plan.actual = if i == 1 { Duration::ZERO } else { took };
            plan.deciding = Duration::from_micros(1);
            assert_eq!(tally.add(&plan, took), matches!(i, 1 | 3 | 4), "{i}");
        }
        assert_eq!((tally.changes, tally.mostly()), (3, "threads"));
        assert_eq!(tally.to_string(), "5 frames: 1 kept, 1 one thread, 3 threads");
        assert!((tally.deciding() - 0.0375).abs() < 1e-12);
        assert!(tally.error().is_some_and(|error| (error - 2.0).abs() < 1e-9), "{tally:?}");
    }
}
