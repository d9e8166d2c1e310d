//! What a machine can do, in a handful of constants.

use std::fmt;
use std::num::NonZero;
use std::thread::available_parallelism;

/// How long things take on a machine, from which a [`Planner`](super::Planner) predicts what a question
/// will take. Wrong constants cost time, never an answer.
///
/// Measure once, keep the result where you like (with the feature `serde` as JSON or whatever you
/// prefer), and read it at the next start; nothing is written without being asked:
///
/// ```no_run
/// use pfront::planner::{Machine, Planner};
/// let machine = Machine::measure(); // takes less than a second
/// println!("{machine}");
/// let planner = Planner::new(machine);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Machine {
    /// Threads that can work at once.
    pub threads: u32,
    /// A box test on one thread, in nanoseconds; a triangle test counts as
    /// [`TRIANGLE_COST`](pfront_core::bvtt::Work::TRIANGLE_COST) of them.
    pub test: f64,
    /// How many times faster all threads are than one, on a long question.
    pub speedup: f64,
    /// To get a second thread to work and wait for it, in nanoseconds.
    pub fork: f64,
    /// What each further one adds, in nanoseconds.
    pub fork_more: f64,
    /// The GPU that was measured.
    pub device: Option<Device>,
}

/// How long things take on a GPU.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Device {
    /// The name of the adapter: of another one, nothing is known.
    pub name: String,
    /// To ask anything at all and read the answer, in nanoseconds.
    pub question: f64,
    /// A box test, in nanoseconds: what a long question takes over how many the CPU needs for it.
    pub test: f64,
    /// To make a query and its buffers, and bring anything at all there, in nanoseconds.
    #[cfg_attr(feature = "serde", serde(default = "typical_setup"))]
    pub setup: f64,
    /// To bring a triangle there, in nanoseconds.
    pub upload: f64,
}

/// Where that was not measured, as on an H200.
#[cfg(feature = "serde")]
fn typical_setup() -> f64 {
    6e5
}

/// What surrounds a question of nothing, in nanoseconds.
const AROUND: f64 = 300.0;

impl Machine {
    /// A machine that was not measured: this one's number of threads, and times that were found on an Intel
    /// Xeon of 2.7 GHz.
    #[must_use]
    pub fn typical() -> Self {
        let threads = match cfg!(feature = "threads") {
            true => available_parallelism().map_or(1, NonZero::get) as u32,
            false => 1,
        };
        let speedup = 1.0 + 0.8 * f64::from(threads - 1);
        Self { threads, test: 3.0, speedup, fork: 10_000.0, fork_more: 1500.0, device: None }
    }

    /// The same, without numbers that are none, as a file can hold.
    pub(crate) fn sound(mut self) -> Self {
        let typical = Self::typical();
        let sane = |x: f64, or: f64| if (0.0..1e12).contains(&x) { x } else { or };
        self.threads = self.threads.clamp(1, 1 << 16);
        self.test = sane(self.test, typical.test).max(1e-3);
        self.speedup = sane(self.speedup, 1.0).clamp(1.0, f64::from(self.threads));
        self.fork = sane(self.fork, typical.fork);
        self.fork_more = sane(self.fork_more, typical.fork_more);
        self.device = self.device.filter(|device| {
            let Device { question, test, setup, upload, .. } = device;
            [question, test, setup, upload].into_iter().all(|x| (0.0..1e12).contains(x))
        });
        self
    }

    /// A question of so many box tests on one thread, in nanoseconds.
    pub(crate) fn alone(&self, cost: f64) -> f64 {
        AROUND + cost * self.test
    }

    /// The same on several threads.
    pub(crate) fn threaded(&self, cost: f64, workers: u32) -> f64 {
        AROUND + cost * self.test / self.speedup_of(workers) + self.fork_of(workers)
    }

    /// How many times faster some threads are than one.
    pub(crate) fn speedup_of(&self, workers: u32) -> f64 {
        let each = (self.speedup - 1.0) / f64::from(self.threads.max(2) - 1);
        1.0 + each * f64::from(workers.min(self.threads).max(1) - 1)
    }

    /// What it takes to get them to work.
    pub(crate) fn fork_of(&self, workers: u32) -> f64 {
        match workers {
            0 | 1 => 0.0,
            _ => self.fork + self.fork_more * f64::from(workers - 2),
        }
    }

    /// The numbers of workers that are worth a thought: powers of two, and all.
    pub(crate) fn worker_counts(most: u32) -> impl Iterator<Item = u32> {
        let doubled = std::iter::successors(Some(2_u32), |p| p.checked_mul(2));
        doubled.take_while(move |&p| p < most).chain([most])
    }
}

impl Device {
    /// A question that takes the CPU so many box tests, in nanoseconds.
    pub(crate) fn ask(&self, cost: f64) -> f64 {
        self.question + cost * self.test
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { threads, test, speedup, fork, fork_more, device } = self;
        write!(f, "a box test takes {test:.2} ns")?;
        if *threads > 1 {
            let (fork, more) = (fork / 1e3, fork_more / 1e3);
            write!(f, "; {threads} threads are {speedup:.1} times faster, after {fork:.1} us ")?;
            write!(f, "for the second and {more:.1} for each more")?;
        }
        if let Some(Device { name, question, test, setup, upload }) = device {
            let (question, setup) = (question / 1e3, setup / 1e3);
            write!(f, "; {name}: {question:.0} us a question, {test:.3} ns a box test, ")?;
            write!(f, "{setup:.0} us to get ready and {upload:.1} ns to upload a triangle")?;
        }
        Ok(())
    }
}
