//! Positions that are on the device already, in a buffer of the caller's.

use crate::layout::Taking;
use crate::model::Outside;
use crate::parameters::Parameters;
use crate::refit::{Origin, Refit};
use crate::sequence::{Sequence, groups_for};
use crate::source::Source;
use crate::{Gpu, GpuError};
use pfront_core::Aabb;
use pfront_shaders::constants::GROUP;
use std::sync::Arc;
use wgpu::{BindingResource, Buffer, BufferBinding, BufferSize, BufferUsages};

/// Vertices in a buffer of the caller's: what a skinning pass or a simulation wrote. Each begins with its position, three `f32`.
///
/// # Examples
/// ```no_run
/// # use pfront_core::Aabb;
/// # use pfront_gpu::{Deforming, GpuError, GpuQuery, GpuQuestion, VertexBuffer, wgpu};
/// # fn demo(mut cloth: Deforming, mut query: GpuQuery, skinned: wgpu::Buffer) -> Result<(), GpuError> {
/// // Vertices of 32 bytes, of a cloth that stays within five metres.
/// let bounds = Aabb { min: [-5.0; 3], max: [5.0; 3] };
/// cloth.set_positions_from(&VertexBuffer { buffer: &skinned, offset: 0, stride: 32, bounds })?;
/// println!("{} pairs", query.count(&GpuQuestion::itself(&cloth))?);
/// # Ok(()) }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct VertexBuffer<'b> {
    /// The buffer, of the device of the model, with [`BufferUsages::STORAGE`].
    pub buffer: &'b Buffer,
    /// The bytes before the first vertex, a multiple of 4.
    pub offset: u64,
    /// The bytes from one vertex to the next, a multiple of 4 and 12 at least.
    pub stride: u64,
    /// A box that holds all vertices. The host does not see them, and has to know how far poses may take them; a box that is larger
    /// than it need be costs nothing.
    pub bounds: Aabb,
}

/// The refit to positions from a buffer, and where they were.
#[derive(Debug)]
pub(super) struct Taken {
    buffer: Buffer,
    offset: u64,
    stride: u64,
    bounds: Aabb,
    pub(super) refit: Arc<Refit>,
}

impl Taken {
    /// # Errors
    /// As [`Deforming::set_positions_from`](super::Deforming::set_positions_from).
    pub(super) fn new(
        gpu: &Gpu,
        source: &Source,
        outside: &Outside,
        fit: &Arc<Sequence>,
        vertices: &VertexBuffer<'_>,
    ) -> Result<Self, GpuError> {
        let count = source.vertices;
        let needed = vertices.bytes(count)?;
        let VertexBuffer { buffer, offset, stride, bounds } = *vertices;
        let limits = gpu.device().limits();
        // A binding begins at a multiple of this.
        let before = offset % u64::from(limits.min_storage_buffer_offset_alignment);
        let (needed, available) = (before + needed, limits.max_storage_buffer_binding_size);
        if needed > available {
            return Err(GpuError::TooLarge { what: "the caller's vertices", needed, available });
        }
        let taking = Taking {
            low: bounds.min.map(|x| in_order(if x == 0.0 { -0.0 } else { x })),
            vertices: count as u32,
            high: bounds.max.map(|x| in_order(x + 0.0)),
            stride: (stride / 4) as u32,
            first: (before / 4) as u32,
            padding_1: 0,
            padding_2: 0,
            padding_3: 0,
        };
        let given =
            BufferBinding { buffer, offset: offset - before, size: BufferSize::new(needed) };
        let resources = [
            ("given", BindingResource::Buffer(given)),
            ("taken", source.positions.as_entire_binding()),
            ("outside", outside.buffer.as_entire_binding()),
        ];
        let parameters = Parameters::new(gpu, "the layout of vertices", &[taking])?;
        let groups = groups_for((count as u32).div_ceil(GROUP));
        let mut sequence = Sequence::new(gpu)?;
        sequence.add_resources(gpu, |p| &p.take, &resources, parameters.binding(0), groups)?;
        let origin = Origin::Device(outside.buffer.clone());
        let refit = Refit::new(gpu, origin, vec![Arc::new(sequence), fit.clone()]);
        Ok(Self { buffer: buffer.clone(), offset, stride, bounds, refit })
    }

    pub(super) fn is_from(&self, vertices: &VertexBuffer<'_>) -> bool {
        let VertexBuffer { buffer, offset, stride, bounds } = *vertices;
        (&self.buffer, self.offset, self.stride, self.bounds) == (buffer, offset, stride, bounds)
    }
}

impl VertexBuffer<'_> {
    /// The bytes of so many vertices, from the first on.
    fn bytes(&self, vertices: usize) -> Result<u64, GpuError> {
        let refused = |reason| Err(GpuError::VertexBuffer { reason });
        let Self { buffer, offset, stride, bounds } = self;
        if offset % 4 != 0 || stride % 4 != 0 || *stride < 12 {
            return refused(format!(
                "its offset of {offset} bytes and its stride of {stride} have to be multiples of 4, and the stride 12 at least"
            ));
        }
        if !bounds.min.iter().chain(&bounds.max).all(|x| x.is_finite()) {
            return refused(format!(
                "its box from {:?} to {:?} is not finite",
                bounds.min, bounds.max
            ));
        }
        if !buffer.usage().contains(BufferUsages::STORAGE) {
            return refused("it lacks BufferUsages::STORAGE".to_owned());
        }
        let before_last = stride.checked_mul(vertices as u64 - 1);
        let bytes = before_last.and_then(|bytes| bytes.checked_add(12));
        let end = bytes.and_then(|bytes| bytes.checked_add(*offset));
        match (bytes, end) {
            (Some(bytes), Some(end)) if end <= buffer.size() => Ok(bytes),
            _ => refused(format!(
                "it has {} bytes, too few for {vertices} vertices of {stride} bytes from byte {offset} on",
                buffer.size()
            )),
        }
    }
}

/// Whole numbers in the order of finite numbers, as `take.wgsl` has them.
fn in_order(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    if bits < 0 { bits ^ i32::MAX } else { bits }
}
