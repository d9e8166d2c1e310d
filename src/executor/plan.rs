//! Who answered the last frame, and why.

use std::fmt;
use std::time::Duration;

/// Who answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// Nobody had to: nothing has changed since the last answer.
    Kept,
    /// The calling thread.
    Sequential,
    /// Several threads, after the calling one had begun or at once.
    Threads,
    /// The GPU.
    Gpu,
}

/// Why it was that one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// Neither the question nor the models have changed.
    Unchanged,
    /// The executor has no other.
    OnlyOne,
    /// It is predicted to be at least as fast as the other.
    Faster,
    /// The other may be faster, but has not yet saved what changing to it costs.
    NotWorthChanging,
    /// The GPU answers exactly, and something else was asked for.
    Inexact,
    /// The GPU has failed: see [`Plan::failure`].
    GpuFailed,
}

/// Who answered a frame, and why.
///
/// # Examples
/// ```
/// # use pfront::{Executor, Model, PairQuery, Pose, executor::Backend};
/// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
/// let mut query = PairQuery::new().on(&Executor::auto());
/// query.all(&a, &a, &Pose::IDENTITY)?;
/// let plan = query.plan().expect("there was a question");
/// assert_eq!(plan.backend, Backend::Sequential);
/// println!("{plan}");
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Plan {
    /// Who answered.
    pub backend: Backend,
    /// Why.
    pub reason: Reason,
    /// What the CPU and the GPU were predicted to take, where there was a choice and something to go by.
    pub predicted: Option<[Duration; 2]>,
    /// Why the GPU is not asked any more.
    pub failure: Option<String>,
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Kept => "kept answer",
            Self::Sequential => "one thread",
            Self::Threads => "threads",
            Self::Gpu => "GPU",
        })
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unchanged => "nothing has changed",
            Self::OnlyOne => "the executor has no other",
            Self::Faster => "predicted to be as fast as the other or faster",
            Self::NotWorthChanging => "the other has not yet saved what changing to it costs",
            Self::Inexact => "a GPU answers exactly, and that was not asked for",
            Self::GpuFailed => "the GPU has failed",
        })
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.backend, self.reason)?;
        if let Some([cpu, gpu]) = self.predicted {
            write!(f, " (predicted: CPU {cpu:.1?}, GPU {gpu:.1?})")?;
        }
        match &self.failure {
            Some(failure) => write!(f, "; {failure}"),
            None => Ok(()),
        }
    }
}
