//! Bind groups, made once: those of a query's lists, and those of what it is about.

use crate::GpuError;
use crate::clock::Clock;
use crate::gpu::{Descent, Gpu};
use crate::lists::{Lists, REFINE};
use crate::pass::{Named, Pass};
use pfront_shaders::constants::FRONTS;
use wgpu::{BindGroup, CommandEncoder, ComputePass, ComputePassDescriptor};

#[cfg(test)]
thread_local! {
    /// Workgroups that a test adds to every dispatch of its thread: passes guard their own stores.
    pub(crate) static EXTRA: std::cell::Cell<u32> = const { std::cell::Cell::new(0) };
}

/// One bind group for each pass.
#[derive(Debug)]
pub(crate) struct EachPass {
    pub(crate) first: BindGroup,
    pub(crate) expand: BindGroup,
    pub(crate) narrow: BindGroup,
    pub(crate) decide: BindGroup,
    pub(crate) direct: Option<BindGroup>,
}

impl EachPass {
    fn new(
        passes: &Descent,
        bind: impl Fn(&Pass) -> Result<BindGroup, GpuError>,
    ) -> Result<Self, GpuError> {
        Ok(Self {
            first: bind(&passes.first)?,
            expand: bind(&passes.expand)?,
            narrow: bind(&passes.narrow)?,
            decide: bind(&passes.decide)?,
            direct: passes.direct.as_ref().map(bind).transpose()?,
        })
    }
}

/// Bind groups that last as long as the lists.
#[derive(Debug)]
pub(crate) struct Groups {
    /// The bind group of parameters that are copied.
    pub(crate) query: BindGroup,
    pub(crate) lists: EachPass,
    pub(crate) first_step: BindGroup,
    /// By the index of the front that is read.
    pub(crate) steps: Vec<BindGroup>,
    pub(crate) refine: BindGroup,
    pub(crate) bring: BindGroup,
    pub(crate) order: BindGroup,
    /// Groups of the passes that sort many hits, in order.
    pub(crate) sort: [BindGroup; 3],
}

impl Groups {
    pub(crate) fn new(gpu: &Gpu, descent: &Descent, lists: &Lists) -> Result<Self, GpuError> {
        let passes = gpu.passes();
        let step = |index| lists.bind_step(gpu, &descent.expand, index);
        Ok(Self {
            query: descent.expand.bind_buffers(gpu.device(), 0, &[("query", &lists.query)])?,
            lists: EachPass::new(descent, |pass| lists.bind(gpu, pass, 2))?,
            first_step: lists.bind_step(gpu, &descent.first, 0)?,
            steps: (0..FRONTS - 1).map(step).collect::<Result<_, _>>()?,
            refine: step(REFINE)?,
            bring: lists.bind(gpu, &passes.bring, 1)?,
            order: lists.bind(gpu, &passes.order, 1)?,
            sort: [
                lists.bind(gpu, &passes.sample, 1)?,
                lists.bind(gpu, &passes.deal, 1)?,
                lists.bind(gpu, &passes.settle, 1)?,
            ],
        })
    }
}

/// Bind groups of two models, or of bodies. They keep these buffers alive.
#[derive(Debug)]
pub(crate) struct Meshes {
    pub(crate) ids: [u64; 2],
    pub(crate) groups: EachPass,
}

impl Meshes {
    pub(crate) fn new(
        gpu: &Gpu,
        descent: &Descent,
        ids: [u64; 2],
        buffers: Named<'_>,
    ) -> Result<Self, GpuError> {
        let bind = |pass: &Pass| pass.bind_buffers(gpu.device(), 1, buffers);
        Ok(Self { ids, groups: EachPass::new(descent, bind)? })
    }
}

/// A compute pass, whose dispatches may be timed.
pub(crate) struct Dispatches<'e, 'c> {
    compute: ComputePass<'e>,
    clock: Option<&'c mut Clock>,
}

impl<'e, 'c> Dispatches<'e, 'c> {
    pub(crate) fn begin(encoder: &'e mut CommandEncoder, clock: Option<&'c mut Clock>) -> Self {
        let mut clock = clock;
        let mut compute = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("pfront"),
            timestamp_writes: clock.as_mut().and_then(|clock| clock.start()),
        });
        if let Some(clock) = &mut clock {
            clock.mark(&mut compute, None);
        }
        Self { compute, clock }
    }

    /// Dispatches a pass with its bind groups in order.
    pub(crate) fn add(&mut self, pass: &Pass, groups: &[&BindGroup], workgroups: u32) {
        self.compute.set_pipeline(&pass.pipeline);
        for (index, group) in (0..).zip(groups) {
            self.compute.set_bind_group(index, *group, &[]);
        }
        #[cfg(test)]
        let workgroups = workgroups + EXTRA.get();
        self.compute.dispatch_workgroups(workgroups, 1, 1);
        if let Some(clock) = &mut self.clock {
            clock.mark(&mut self.compute, Some(pass.entry));
        }
    }
}
