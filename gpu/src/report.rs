//! Counts and times of an answer.

use crate::layout::Counters;

/// Counts and times of the last answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct GpuReport {
    /// Runs of all passes: 1 where the budget holds everything.
    pub runs: u32,
    /// The longest front, in node pairs, over all runs; so are the others. Above what the budget
    /// holds, it is the demand.
    pub longest_front: u32,
    /// Leaf pairs.
    pub leaf_pairs: u32,
    /// Triangle pairs that meet, and those that the first tests left open.
    pub triangle_pairs: u32,
    /// Triangle pairs that f32 left open.
    pub open: u32,
    /// Triangle pairs that were left to the CPU.
    pub on_cpu: u32,
    /// Node pairs whose children were tested, four box tests each at most, of all runs together.
    pub node_pairs: u64,
    /// Tests of boxes and of the triangles of leaves, of all runs together: what grows as trees wear.
    pub box_tests: u64,
    /// Hits that the host has put in order, since the device had no room for it.
    pub sorted_on_host: u64,
}

impl GpuReport {
    pub(crate) fn add(&mut self, counters: &Counters, leaf_size: u32) {
        self.runs += 1;
        let triangles = u64::from(leaf_size) * u64::from(leaf_size) * u64::from(counters.leaves);
        self.node_pairs += u64::from(counters.node_pairs);
        self.box_tests += 4 * u64::from(counters.node_pairs) + triangles;
        for (most, now) in [
            (&mut self.longest_front, counters.longest_front()),
            (&mut self.leaf_pairs, counters.leaves),
            // Without `decide`, those that are left are the results.
            (&mut self.triangle_pairs, counters.kept.max(counters.hits + counters.rest)),
            (&mut self.open, counters.open.max(counters.rest)),
            (&mut self.on_cpu, counters.rest),
        ] {
            *most = now.max(*most);
        }
    }
}

impl GpuReport {
    /// Adds that of another part of the same question.
    pub(crate) fn join(&mut self, other: &Self) {
        let most = |most: &mut u32, now: u32| *most = now.max(*most);
        most(&mut self.longest_front, other.longest_front);
        most(&mut self.leaf_pairs, other.leaf_pairs);
        most(&mut self.triangle_pairs, other.triangle_pairs);
        most(&mut self.open, other.open);
        most(&mut self.on_cpu, other.on_cpu);
        self.runs += other.runs;
        self.node_pairs += other.node_pairs;
        self.box_tests += other.box_tests;
        self.sorted_on_host += other.sorted_on_host;
    }
}

/// Adds to a query, which has an `answer`, what tells about the last one.
macro_rules! reports {
    ($query:ident) => {
        impl $query {
            /// The same, keeping the device time of a run as a whole.
            ///
            /// # Errors
            /// [`GpuError::OutOfMemory`].
            pub fn with_time(mut self) -> Result<Self, crate::GpuError> {
                self.runner.engine.keep_time(false)?;
                Ok(self)
            }

            /// The same, keeping the device time of each pass, which takes some microseconds for
            /// each.
            ///
            /// # Errors
            /// [`GpuError::OutOfMemory`].
            pub fn with_timings(mut self) -> Result<Self, crate::GpuError> {
                self.runner.engine.keep_time(true)?;
                Ok(self)
            }

            /// The passes of the last run with their times on the device; empty without
            /// [`Self::with_time`] or [`Self::with_timings`], or if the device cannot tell.
            ///
            /// # Errors
            /// [`GpuError::DeviceLost`], [`GpuError::Device`].
            pub fn timings(&self) -> Result<Vec<crate::Timing>, crate::GpuError> {
                self.runner.engine.timings()
            }

            /// Counts and times of the last answer.
            #[must_use]
            pub fn report(&self) -> crate::GpuReport {
                self.runner.report
            }
        }
    };
}
pub(crate) use reports;
