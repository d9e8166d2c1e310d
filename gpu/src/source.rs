//! A mesh on the device, without a tree.

use crate::GpuError;
use crate::buffer::Usage;
use crate::device::release;
use crate::gpu::Gpu;
use crate::groups::Dispatches;
use crate::layout::Corner;
use crate::sequence::groups_for;
use pfront_core::Mesh;
use pfront_shaders::constants::GROUP;
use wgpu::Buffer;

/// The mesh that a tree is built of.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) positions: Buffer,
    pub(crate) triangles: Buffer,
    pub(crate) vertices: usize,
    pub(crate) count: usize,
}

impl Drop for Source {
    fn drop(&mut self) {
        release([&self.positions, &self.triangles]);
    }
}

impl Source {
    /// Uploads a mesh; of one in f64 its shadow.
    pub(crate) fn new(gpu: &Gpu, mesh: Mesh<'_>) -> Result<Self, GpuError> {
        let (positions, triangles) = (mesh.shadow(), mesh.triangles());
        Ok(Self {
            vertices: positions.len(),
            count: triangles.len(),
            positions: gpu.upload("the positions", positions, Usage::Input)?,
            triangles: gpu.upload("the vertices of triangles", triangles, Usage::Input)?,
        })
    }

    /// The corners of the triangles in an order.
    pub(crate) fn corners(&self, gpu: &Gpu, order: &Buffer) -> Result<Buffer, GpuError> {
        let bytes = self.count as u64 * size_of::<[Corner; 3]>() as u64;
        let corners = gpu.buffer("the triangles", bytes, Usage::List)?;
        if self.count == 0 {
            return Ok(corners);
        }
        let pass = &gpu.passes().gather;
        let buffers = [
            ("order", order),
            ("corners", &corners),
            ("positions", &self.positions),
            ("triangles", &self.triangles),
        ];
        let group = pass.bind_buffers(gpu.device(), 0, &buffers)?;
        gpu.checked(|| {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let groups = groups_for((self.count as u32).div_ceil(GROUP));
            let mut dispatches = Dispatches::begin(&mut encoder, None);
            dispatches.add(pass, &[&group], groups);
            drop(dispatches);
            gpu.queue().submit([encoder.finish()]);
            gpu.check()
        })?;
        Ok(corners)
    }
}
