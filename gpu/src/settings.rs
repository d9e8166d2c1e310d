//! Settings of a query. None of them changes an answer.

use crate::GpuError;
use crate::layout::{Query, Rest};
use pfront_shaders::constants::{BUCKET, BUCKETS};

/// How a query works on the device.
///
/// # Examples
/// ```no_run
/// use pfront_gpu::{Budget, Gpu, GpuQuery, GpuSettings};
/// let gpu = Gpu::new()?;
/// let settings = GpuSettings { depth: 2, budget: Budget { bytes: 16 << 20 }, ..gpu.settings() };
/// let query = GpuQuery::with_settings(&gpu, settings)?;
/// # Ok::<(), pfront_gpu::GpuError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuSettings {
    /// The depth bound d_b of the paper: how many levels a pass descends at most. 0 counts as 1. A query
    /// takes as few passes as it allows, and these descend about equally far.
    pub depth: u32,
    /// Workgroups of a dispatch. A fixed number that suits the device, over which each pass deals out
    /// what it finds: the count is on the device, and reading it there is cheaper than a dispatch that
    /// turns it into arguments.
    pub groups: u32,
    /// Memory for fronts and lists.
    pub budget: Budget,
    /// Bytes of device memory in which meshes stay that no query holds any more: a question about the same meshes does not
    /// upload them again. The meshes that were asked about longest ago go first.
    pub mesh_bytes: u64,
}

impl Default for GpuSettings {
    /// Settings for a large GPU, with 256 MiB for meshes. [`Gpu::settings`](crate::Gpu::settings) suits the device.
    fn default() -> Self {
        Self { depth: 7, groups: 512, budget: Budget::default(), mesh_bytes: 256 << 20 }
    }
}

/// Device memory of a query: fronts, lists and results. When they are full, the query goes on in
/// parts; nothing is lost.
///
/// With n = bytes / 64, a front holds n node pairs (there are two), the lists of leaf pairs and of the
/// triangle pairs that the first tests leave 2n each, that of hits n, and that of triangle
/// pairs for the CPU n / 16. Counters, parameters and what sorts the hits take 32 KiB more; a read-back
/// buffer of the host is as large as the answer, and another of the device where the host cannot map what shaders write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// At least [`Budget::LEAST`].
    pub bytes: u64,
}

impl Budget {
    /// 64 KiB: room for all results of a leaf pair, and for the children of 64 node pairs.
    pub const LEAST: Self = Self { bytes: 1024 * UNIT };
}

impl Default for Budget {
    /// 64 MiB.
    fn default() -> Self {
        Self { bytes: 64 << 20 }
    }
}

/// Bytes for each n.
const UNIT: u64 = 64;
const _: () = assert!(UNIT as usize >= 8 * (2 + 2 + 2 + 1) + size_of::<Rest>() / 16);

/// How many elements each list holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Capacities {
    pub(crate) front: u32,
    pub(crate) leaves: u32,
    pub(crate) hits: u32,
    pub(crate) kept: u32,
    pub(crate) rest: u32,
}

impl Capacities {
    pub(crate) fn new(budget: Budget) -> Result<Self, GpuError> {
        let least = Budget::LEAST.bytes;
        if budget.bytes < least {
            return Err(GpuError::Budget { bytes: budget.bytes, least });
        }
        // Far more than any device binds, and counters still cannot wrap before they overflow.
        let n = (budget.bytes / UNIT).min(1 << 28) as u32;
        Ok(Self { front: n, leaves: 2 * n, hits: n, kept: 2 * n, rest: n / 16 })
    }

    /// So many hits the device surely puts in order: then a bucket has room for four times the mean (`sample.wgsl`).
    pub(crate) fn ordered(&self) -> u64 {
        u64::from(BUCKET.min(self.kept / BUCKETS) * BUCKETS / 4).max(1)
    }

    /// A query that knows them.
    pub(crate) fn in_query(&self, query: Query) -> Query {
        Query {
            front_capacity: self.front,
            leaf_capacity: self.leaves,
            hit_capacity: self.hits,
            kept_capacity: self.kept,
            rest_capacity: self.rest,
            ..query
        }
    }
}
