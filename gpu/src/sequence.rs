//! Dispatches that are the same each time, bound once.

use crate::GpuError;
use crate::clock::Clock;
use crate::gpu::Gpu;
use crate::groups::Dispatches;
use crate::moving::MovingPasses;
use crate::pass::{Named, Pass};
use std::sync::Arc;
use wgpu::{BindGroup, BindingResource, CommandEncoder};

/// Chooses the pass of a dispatch.
type Which = fn(&MovingPasses) -> &Pass;

/// Workgroups for so many jobs that do not touch each other: one each, as far as a dispatch goes.
pub(crate) fn groups_for(jobs: u32) -> u32 {
    jobs.min(65_535)
}

/// Dispatches in order.
#[derive(Debug)]
pub(crate) struct Sequence {
    passes: Arc<MovingPasses>,
    dispatches: Vec<(Which, [BindGroup; 2], u32)>,
}

impl Sequence {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self { passes: gpu.moving()?, dispatches: Vec::new() })
    }

    /// Adds a pass over buffers, which may be more than it uses, and parameters.
    pub(crate) fn add(
        &mut self,
        gpu: &Gpu,
        which: Which,
        buffers: Named<'_>,
        parameters: BindingResource<'_>,
        workgroups: u32,
    ) -> Result<(), GpuError> {
        let resources: Vec<_> =
            buffers.iter().map(|&(name, buffer)| (name, buffer.as_entire_binding())).collect();
        self.add_resources(gpu, which, &resources, parameters, workgroups)
    }

    /// The same over parts of buffers.
    pub(crate) fn add_resources(
        &mut self,
        gpu: &Gpu,
        which: Which,
        resources: &[(&str, BindingResource<'_>)],
        parameters: BindingResource<'_>,
        workgroups: u32,
    ) -> Result<(), GpuError> {
        let pass = which(&self.passes);
        let find = |name: &str| resources.iter().find(|(own, _)| *own == name);
        let buffers =
            pass.bind(gpu.device(), 0, |name| find(name).map(|(_, resource)| resource.clone()))?;
        let parameters = pass.bind(gpu.device(), 1, |_| Some(parameters.clone()))?;
        self.dispatches.push((which, [buffers, parameters], workgroups));
        Ok(())
    }

    /// Records all of them, and their times if those are wanted.
    pub(crate) fn run(&self, encoder: &mut CommandEncoder, mut clock: Option<&mut Clock>) {
        let mut dispatches = Dispatches::begin(encoder, clock.as_deref_mut());
        for (which, [buffers, parameters], workgroups) in &self.dispatches {
            dispatches.add(which(&self.passes), &[buffers, parameters], *workgroups);
        }
        drop(dispatches);
        if let Some(clock) = clock {
            clock.finish(encoder);
        }
    }
}
