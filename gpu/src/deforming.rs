//! A mesh that moves: positions are uploaded, everything else happens on the device.

use crate::clock::{Clock, Timing};
use crate::gpu::Gpu;
use crate::groups::Dispatches;
use crate::layout::Stage;
use crate::memory::Usage;
use crate::schedule::Schedule;
use crate::{Error, Model};
use pfront_core::{Aabb, Bvh, MeshError};
use std::ops::Deref;
use wgpu::{BindGroup, BindingResource, Buffer, BufferBinding, BufferSize, CommandEncoder};

/// Parameters of stages lie this far apart, as uniform bindings must.
const STAGE_STRIDE: usize = 256;

/// A [`Model`] whose vertices move. Ask about it as about any other.
///
/// Takes 12 bytes a vertex and about 5 a node beside those of the model.
///
/// # Examples
/// ```no_run
/// # fn demo(gpu: pfront_gpu::Gpu, bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::Error> {
/// use pfront_gpu::{Deforming, SelfQuery};
/// let mut cloth = Deforming::new(&gpu, bvh)?;
/// let mut query = SelfQuery::new(&gpu)?;
/// # let frames: [Vec<[f32; 3]>; 0] = [];
/// for positions in &frames {
///     cloth.set_positions(positions)?;
///     println!("{} pairs", query.all(&cloth)?.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Deforming {
    gpu: Gpu,
    model: Model,
    vertices: usize,
    positions: Buffer,
    mesh: BindGroup,
    /// The parameters of each stage, and how many workgroups it is for.
    stages: Vec<(BindGroup, u32)>,
    /// If times are wanted.
    clock: Option<Clock>,
}

impl Deref for Deforming {
    type Target = Model;

    fn deref(&self) -> &Model {
        &self.model
    }
}

impl Deforming {
    /// Uploads a mesh with its BVH.
    ///
    /// # Errors
    /// As [`Model::new`].
    ///
    /// # Complexity
    /// O(triangles).
    pub fn new(gpu: &Gpu, bvh: Bvh<'_>) -> Result<Self, Error> {
        let model = Model::new(gpu, bvh)?;
        let points = bvh.mesh().positions();
        let positions = gpu.upload("the positions", points, Usage::Input)?;
        let Schedule { nodes, rounds, jobs, stages } = Schedule::new(bvh.nodes());
        let schedule = gpu.upload("the schedule", &nodes, Usage::Input)?;
        let rounds = gpu.upload("the rounds", &rounds, Usage::Input)?;
        let jobs = gpu.upload("the jobs", &jobs, Usage::Input)?;
        let pass = &gpu.passes().refit;
        let mesh = pass.bind(gpu.device(), 0, |name| {
            let buffer = match name {
                "nodes" => &model.nodes,
                "corners" => &model.corners,
                "positions" => &positions,
                "schedule" => &schedule,
                "rounds" => &rounds,
                "jobs" => &jobs,
                _ => return None,
            };
            Some(buffer.as_entire_binding())
        })?;
        let mut bytes = vec![0; stages.len() * STAGE_STRIDE];
        for (slot, jobs) in bytes.chunks_exact_mut(STAGE_STRIDE).zip(&stages) {
            let stage = Stage { first_job: jobs.start, end_job: jobs.end };
            slot[..size_of::<Stage>()].copy_from_slice(bytemuck::bytes_of(&stage));
        }
        let parameters = gpu.upload("the stages", &bytes, Usage::Uniform)?;
        let most = gpu.settings().groups;
        let stage = |(index, jobs): (usize, std::ops::Range<u32>)| {
            let group = pass.bind(gpu.device(), 1, |_| {
                Some(BindingResource::Buffer(BufferBinding {
                    buffer: &parameters,
                    offset: (index * STAGE_STRIDE) as u64,
                    size: BufferSize::new(size_of::<Stage>() as u64),
                }))
            })?;
            Ok((group, most.min(jobs.len() as u32)))
        };
        let stages = stages.into_iter().enumerate().map(stage).collect::<Result<_, Error>>()?;
        Ok(Self {
            gpu: gpu.clone(),
            model,
            vertices: points.len(),
            positions,
            mesh,
            stages,
            clock: None,
        })
    }

    /// The same, keeping the device time of each refit.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn with_timings(mut self) -> Result<Self, Error> {
        self.clock = Clock::new(&self.gpu)?;
        Ok(self)
    }

    /// The stages of the last refit with their times on the device; empty without
    /// [`Deforming::with_timings`], or if the device cannot tell.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::Device`].
    pub fn timings(&self) -> Result<Vec<Timing>, Error> {
        self.clock.as_ref().map_or(Ok(Vec::new()), |clock| clock.read(&self.gpu))
    }

    /// Moves the vertices and refits the BVH. On error nothing has changed.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is not finite or the number of vertices differs.
    ///
    /// # Complexity
    /// O(vertices) on the host, which waits for nothing; O(triangles) on the device.
    pub fn set_positions(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        let mut encoder = self.gpu.device().create_command_encoder(&Default::default());
        self.record_positions(&mut encoder, positions)?;
        self.gpu.queue().submit([encoder.finish()]);
        self.gpu.check()
    }

    /// The same in an encoder of the caller's, which has to be submitted before anything else is asked
    /// about the model.
    ///
    /// # Errors
    /// As [`Deforming::set_positions`].
    pub fn record_positions(
        &mut self,
        encoder: &mut CommandEncoder,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        if positions.len() != self.vertices {
            let (expected, found) = (self.vertices, positions.len());
            return Err(MeshError::VertexCount { expected, found }.into());
        }
        if let Some(vertex) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(MeshError::NonFinite { vertex }.into());
        }
        self.gpu.queue().write_buffer(&self.positions, 0, bytemuck::cast_slice(positions));
        let mut dispatches = Dispatches::begin(encoder, self.clock.as_mut());
        for (stage, workgroups) in &self.stages {
            dispatches.add(&self.gpu.passes().refit, &[&self.mesh, stage], *workgroups);
        }
        drop(dispatches);
        if let Some(clock) = &self.clock {
            clock.finish(encoder);
        }
        // Of all vertices, so that no read-back is needed; it only bounds what a pose may do.
        self.model.bounds = self.model.bounds.map(|_| Aabb::of(positions));
        Ok(())
    }
}
