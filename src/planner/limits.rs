//! What a frame may take, and what may be given up for that.

use crate::Accuracy;
use std::fmt;
use std::time::Duration;

/// What a frame may take. Without leave nothing is given up: a frame that cannot be answered in time is
/// answered late.
///
/// # Examples
/// ```
/// use pfront::planner::{Limits, Machine, Planner};
/// use std::time::Duration;
/// let limits = Limits { time: Some(Duration::from_millis(2)), incomplete: true, ..Limits::default() };
/// let planner = Planner::new(Machine::typical()).with_limits(limits);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// How long a frame should take at most.
    pub time: Option<Duration>,
    /// Bytes that a query may hold on the CPU and on the GPU, beside models of the caller's and the answer:
    /// ways that take more are not taken, and GPU lists and fronts are made to fit.
    pub memory: Option<usize>,
    /// The least [`Accuracy`] that may be promised where time would run out; by default exact, so that
    /// nothing changes.
    pub accuracy: Accuracy,
    /// Whether what was found in time may be returned as the answer where time runs out. It is sorted and
    /// true, but not all; the plan says so.
    pub incomplete: bool,
}

/// What was given up.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub enum Concession {
    /// Triangles were tested less accurately.
    LessAccurate,
    /// Time ran out: there may be more pairs.
    Incomplete,
}

impl fmt::Display for Concession {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::LessAccurate => "tested less accurately, to be in time",
            Self::Incomplete => "incomplete: time ran out",
        })
    }
}
