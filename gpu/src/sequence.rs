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
        let pass = which(&self.passes);
        let buffers = pass.bind_buffers(gpu.device(), 0, buffers)?;
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
