//! How a question was answered, and why so.

use std::fmt;
use std::time::Duration;

/// Who answers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub enum Backend {
    /// Nobody: nothing has changed since the last answer.
    Kept,
    /// The calling thread.
    Sequential,
    /// Threads of the CPU.
    Threads {
        /// How many.
        workers: u32,
    },
    /// The GPU.
    Gpu,
}

/// Why it was planned so.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub enum Reason {
    /// Neither what was asked nor where it is has changed.
    Unchanged,
    /// The question is too small to think about.
    Small,
    /// There is no other way here, or none that the limits allow.
    OnlyWay,
    /// Nothing is known yet of a question like this: it is begun as the cheapest, which was enough.
    Unknown,
    /// It was begun on the calling thread, and turned out to be larger than expected.
    Outgrown,
    /// Predicted to be the fastest.
    Fastest,
    /// Another way may be faster, but has not saved enough yet to pay for changing to it.
    NotWorthChanging,
    /// The GPU failed: see [`Plan::failure`].
    GpuFailed,
}

/// What one frame took, how it was answered, and why.
///
/// # Examples
/// ```
/// # use pfront::{Model, PairQuery, Pose, planner::{Backend, Machine, Planner}};
/// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
/// let mut query = PairQuery::new().with_planner(Planner::new(Machine::typical()));
/// query.all(&a, &a, &Pose::IDENTITY)?;
/// let plan = query.plan().expect("there was a question");
/// assert_eq!(plan.backend, Backend::Sequential);
/// println!("{plan}");
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Plan {
    /// Who answered.
    pub backend: Backend,
    /// Why.
    pub reason: Reason,
    /// How many box tests the question was expected to cost, if anything was known.
    pub expected_cost: Option<f64>,
    /// What it did cost, as far as that is counted, which a GPU does not.
    pub cost: Option<f64>,
    /// What it was expected to take.
    pub predicted: Option<Duration>,
    /// What each way would have taken, where it was thought of: alone, on threads, on the GPU.
    pub alternatives: [Option<Duration>; 3],
    /// What it took, deciding included; 0 for what is too small to look at the clock. Of a scene without a limit of
    /// time, the first frame after such a one leaves out what it took to find the bodies that may meet.
    pub actual: Duration,
    /// What deciding took when that was last timed, which is done in the first sixteen frames and in
    /// each sixteenth after these.
    pub deciding: Duration,
    /// What was given up to keep within the limits.
    pub concession: Option<super::Concession>,
    /// Why the GPU is not used any more.
    pub failure: Option<String>,
}

impl Plan {
    /// The plan of a question that is too small to plan.
    pub(crate) const SMALL: Self = Self {
        backend: Backend::Sequential,
        reason: Reason::Small,
        expected_cost: None,
        cost: None,
        predicted: None,
        alternatives: [None; 3],
        actual: Duration::ZERO,
        deciding: Duration::ZERO,
        concession: None,
        failure: None,
    };
}

impl Default for Plan {
    /// The plan of a question that is too small to plan.
    fn default() -> Self {
        Self::SMALL
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kept => f.write_str("kept answer"),
            Self::Sequential => f.write_str("one thread"),
            Self::Threads { workers } => write!(f, "{workers} threads"),
            Self::Gpu => f.write_str("GPU"),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unchanged => "nothing has changed",
            Self::Small => "too small to think about",
            Self::OnlyWay => "there is no other way here",
            Self::Unknown => "nothing is known yet, and this was enough",
            Self::Outgrown => "it turned out larger than expected",
            Self::Fastest => "predicted to be the fastest",
            Self::NotWorthChanging => "not worth changing",
            Self::GpuFailed => "the GPU failed",
        })
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {:.1?}", self.backend, self.reason, self.actual)?;
        if let Some(predicted) = self.predicted {
            write!(f, ", {predicted:.1?} predicted")?;
        }
        let names = ["one thread", "threads", "GPU"];
        let mut before = " (";
        for (name, time) in names.iter().zip(&self.alternatives) {
            if let Some(time) = time {
                write!(f, "{before}{name} {time:.1?}")?;
                before = ", ";
            }
        }
        if before == ", " {
            f.write_str(")")?;
        }
        if let Some(cost) = self.expected_cost {
            write!(f, "; {cost:.0} box tests expected")?;
        }
        if let Some(cost) = self.cost {
            write!(f, ", {cost:.0} counted")?;
        }
        if let Some(concession) = &self.concession {
            write!(f, "; {concession}")?;
        }
        if let Some(failure) = &self.failure {
            write!(f, "; {failure}")?;
        }
        Ok(())
    }
}
