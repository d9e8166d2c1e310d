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
    pub undecided: u32,
    /// Triangle pairs that were left to the CPU.
    pub on_cpu: u32,
}

impl GpuReport {
    pub(crate) fn add(&mut self, counters: &Counters) {
        self.runs += 1;
        for (most, now) in [
            (&mut self.longest_front, counters.longest_front()),
            (&mut self.leaf_pairs, counters.leaves),
            (&mut self.triangle_pairs, counters.kept),
            (&mut self.undecided, counters.undecided),
            (&mut self.on_cpu, counters.rest),
        ] {
            *most = now.max(*most);
        }
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
                self.answer.engine.keep_time(false)?;
                Ok(self)
            }

            /// The same, keeping the device time of each pass, which takes some microseconds for
            /// each.
            ///
            /// # Errors
            /// [`GpuError::OutOfMemory`].
            pub fn with_timings(mut self) -> Result<Self, crate::GpuError> {
                self.answer.engine.keep_time(true)?;
                Ok(self)
            }

            /// The passes of the last run with their times on the device; empty without
            /// [`Self::with_time`] or [`Self::with_timings`], or if the device cannot tell.
            ///
            /// # Errors
            /// [`GpuError::DeviceLost`], [`GpuError::Device`].
            pub fn timings(&self) -> Result<Vec<crate::Timing>, crate::GpuError> {
                self.answer.engine.timings()
            }

            /// Counts and times of the last answer.
            #[must_use]
            pub fn report(&self) -> crate::GpuReport {
                self.answer.report
            }
        }
    };
}
pub(crate) use reports;
