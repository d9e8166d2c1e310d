//! The buffers of a query: fronts, lists, counters, parameters.

use crate::buffer::Usage;
use crate::device::release;
use crate::gpu::Gpu;
use crate::layout::{Counters, Query, Rest, Step};
use crate::parameters::Parameters;
use crate::pass::Pass;
use crate::settings::Capacities;
use crate::task::GpuVerb;
use crate::{GpuError, GpuSettings};
use pfront_shaders::constants::{BUCKETS, FRONTS};
use wgpu::{BindGroup, Buffer};

/// The step that puts the children of front 0, leaf pairs among them, into front 1.
pub(crate) const REFINE: u32 = FRONTS;

/// Buffers of fixed size.
#[derive(Debug)]
pub(crate) struct Lists {
    pub(crate) capacities: Capacities,
    /// Read and written in turn: front p is in buffer p mod 2.
    pub(crate) fronts: [Buffer; 2],
    /// In no order.
    pub(crate) hits: Buffer,
    pub(crate) rest: Buffer,
    pub(crate) counters: Buffer,
    pub(crate) query: Buffer,
    /// Leaf pairs; in their place hits in order, once nothing reads them any more.
    pub(crate) leaves: Buffer,
    kept: Buffer,
    /// For sorting the hits.
    buckets: Buffer,
    steps: Parameters<Step>,
}

impl Lists {
    pub(crate) fn new(gpu: &Gpu, settings: &GpuSettings) -> Result<Self, GpuError> {
        let capacities = Capacities::new(settings.budget)?;
        let list = |what, elements: u32, size: usize| {
            gpu.buffer(what, u64::from(elements) * size as u64, Usage::List)
        };
        let front = || list("a front", capacities.front, 8);
        Ok(Self {
            capacities,
            fronts: [front()?, front()?],
            leaves: list("the leaf pairs", capacities.leaves, 8)?,
            hits: list("the results", capacities.hits, 8)?,
            kept: list("the triangle pairs", capacities.kept, 8)?,
            buckets: list("the buckets", BUCKETS, 12)?,
            rest: list("the pairs for the CPU", capacities.rest, size_of::<Rest>())?,
            counters: list("the counters", 1, size_of::<Counters>())?,
            query: gpu.buffer("the query", size_of::<Query>() as u64, Usage::Uniform)?,
            steps: Parameters::new(gpu, "the steps", &steps())?,
        })
    }

    /// The bind group of a pass for everything but meshes and steps.
    pub(crate) fn bind(&self, gpu: &Gpu, pass: &Pass, group: usize) -> Result<BindGroup, GpuError> {
        let buffers = [
            ("counters", &self.counters),
            ("leaves", &self.leaves),
            ("sorted", &self.leaves),
            ("hits", &self.hits),
            ("kept", &self.kept),
            ("rest", &self.rest),
            ("buckets", &self.buckets),
        ];
        pass.bind_buffers(gpu.device(), group, &buffers)
    }

    /// The hits of a run: put in order, as far as that is possible, where all are wanted.
    pub(crate) fn results(&self, verb: GpuVerb) -> &Buffer {
        if verb == GpuVerb::All { &self.leaves } else { &self.hits }
    }

    /// The fronts of pass `index` and its parameters.
    pub(crate) fn bind_step(
        &self,
        gpu: &Gpu,
        pass: &Pass,
        index: u32,
    ) -> Result<BindGroup, GpuError> {
        let from = if index == REFINE { 0 } else { index as usize % 2 };
        pass.bind(gpu.device(), 3, |name| match name {
            "step" => Some(self.steps.binding(index as usize)),
            "front_in" => Some(self.fronts[from].as_entire_binding()),
            "front_out" => Some(self.fronts[1 - from].as_entire_binding()),
            _ => None,
        })
    }
}

impl Drop for Lists {
    fn drop(&mut self) {
        let Self { fronts, hits, rest, counters, query, leaves, kept, buckets, .. } = self;
        release(fronts.iter().chain([&*hits, rest, counters, query, leaves, kept, buckets]));
    }
}

/// The parameters of every pass, and of [`REFINE`].
fn steps() -> Vec<Step> {
    let descend = (0..FRONTS).map(|pass_index| Step { pass_index, keep_leaves: 0 });
    descend.chain([Step { pass_index: 0, keep_leaves: 1 }]).collect()
}
