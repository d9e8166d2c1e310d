//! Counts of what a device has been given to do.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Counts of what a [`Gpu`](crate::Gpu) and its copies have submitted since it was opened.
///
/// # Examples
/// ```no_run
/// # fn demo(bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// use pfront_gpu::{Gpu, GpuModel};
/// let gpu = Gpu::new()?;
/// let model = GpuModel::new(&gpu, bvh)?;
/// assert_eq!(gpu.totals().uploads, 1);
/// # Ok(()) }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct GpuTotals {
    /// Runs of the passes of a query that were submitted. A question takes one, or as many as its budget makes necessary.
    pub runs: u64,
    /// Meshes that were uploaded.
    pub uploads: u64,
    /// Trees that were built on the device.
    pub builds: u64,
    /// Tests of boxes and of the triangles of leaves, of all runs that were read: see [`GpuReport`](crate::GpuReport).
    pub box_tests: u64,
}

/// The same while they are counted.
#[derive(Debug, Default)]
pub(crate) struct Totals {
    pub(crate) runs: AtomicU64,
    pub(crate) uploads: AtomicU64,
    pub(crate) builds: AtomicU64,
    pub(crate) box_tests: AtomicU64,
}

impl Totals {
    pub(crate) fn now(&self) -> GpuTotals {
        let Self { runs, uploads, builds, box_tests } = self;
        let [runs, uploads, builds, box_tests] =
            [runs, uploads, builds, box_tests].map(|total| total.load(Relaxed));
        GpuTotals { runs, uploads, builds, box_tests }
    }
}

/// Counts one more.
pub(crate) fn count(total: &AtomicU64) {
    add(total, 1);
}

/// Counts so many more.
pub(crate) fn add(total: &AtomicU64, more: u64) {
    total.fetch_add(more, Relaxed);
}
