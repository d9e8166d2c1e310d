//! The backend that answered the last frame, and the reason.

use std::fmt;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// The part of an executor that answers a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// The cache: nothing has changed since the last answer.
    Cached,
    /// One thread: the calling one; for a ticket of a GPU, the one that reads.
    Sequential,
    /// Several threads, after the calling one had begun or at once.
    Threads,
    /// The GPU.
    Gpu,
    /// The GPU, and the CPU for what only that answers: pairs of bodies in f64, bodies with themselves, and contacts.
    GpuAndCpu,
}

impl Backend {
    /// This and a part of the CPU.
    pub(crate) fn and(self, cpu: Self) -> Self {
        match (self, cpu) {
            (Self::Gpu | Self::GpuAndCpu, _) => Self::GpuAndCpu,
            (Self::Threads, _) | (_, Self::Threads) => Self::Threads,
            _ => cpu,
        }
    }
}

/// Sees which part of the CPU works: the calling thread alone, or others.
#[derive(Debug)]
pub(crate) struct CpuPart {
    caller: usize,
    is_other: AtomicBool,
}

impl CpuPart {
    /// Nobody has worked yet; the calling thread is this one.
    pub(crate) fn new() -> Self {
        Self { caller: this_thread(), is_other: AtomicBool::new(false) }
    }

    /// To be called by whoever works.
    pub(crate) fn works(&self) {
        if this_thread() != self.caller {
            self.is_other.store(true, Relaxed);
        }
    }

    pub(crate) fn backend(&self) -> Backend {
        match self.is_other.load(Relaxed) {
            true => Backend::Threads,
            false => Backend::Sequential,
        }
    }
}

/// A number that no other thread has while this one runs.
fn this_thread() -> usize {
    thread_local! {
        static OWN: u8 = const { 0 };
    }
    OWN.with(|own| ptr::from_ref(own).addr())
}

/// The reason for a choice of backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// Neither the question nor the models have changed.
    Unchanged,
    /// The executor has only a CPU, or only a GPU.
    NoChoice,
    /// A query begins on the CPU, whose first frame tells nothing yet; a batch has no frames, and stays there.
    Unknown,
    /// It is predicted to be at least as fast as the other.
    Faster,
    /// The other may be faster, but has not yet saved the price of a change.
    NotWorthChanging,
    /// The CPU answers one frame of many, in case it has become faster than the GPU.
    Check,
    /// Only a CPU answers this: contacts, visits, distances, relations, impacts, segments, which bodies meet, a mesh in f64 with itself,
    /// a mesh and itself within a distance, and in a scene bodies in f64, bodies with themselves and all within a distance.
    CpuOnly,
    /// The GPU has failed: see [`Plan::failure`].
    GpuFailed,
}

/// The backend that answered a frame, and the reason.
///
/// # Examples
/// ```
/// # use pfront::{Executor, Model, PairQuery, Pose, executor::Backend};
/// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
/// let mut query = PairQuery::new().on(&Executor::auto());
/// query.all(&a, &a, Pose::IDENTITY)?;
/// let plan = query.plan().expect("there was a question");
/// assert_eq!(plan.backend, Backend::Sequential);
/// println!("{plan}");
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Plan {
    /// The backend that answered.
    pub backend: Backend,
    /// The reason for it.
    pub reason: Reason,
    /// The predicted times of the CPU and of the GPU, if there was a choice and an earlier frame.
    pub predicted: Option<[Duration; 2]>,
    /// The last error of the GPU, if it has not answered since. It is asked again after a pause, unless the device is lost.
    pub failure: Option<String>,
}

impl Plan {
    /// One without predictions.
    pub(crate) fn new(backend: Backend, reason: Reason) -> Self {
        Self { backend, reason, predicted: None, failure: None }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cached => "cache",
            Self::Sequential => "one thread",
            Self::Threads => "threads",
            Self::Gpu => "GPU",
            Self::GpuAndCpu => "GPU and CPU",
        })
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unchanged => "nothing has changed",
            Self::NoChoice => "there is no choice between CPU and GPU",
            Self::Unknown => "nothing is known yet",
            Self::Faster => "predicted to be as fast as the other or faster",
            Self::NotWorthChanging => "the other has not yet saved the price of a change",
            Self::Check => "to see whether the CPU has become faster",
            Self::CpuOnly => "only a CPU answers this; about f64, and within a distance, a GPU answers for two models only",
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
