//! Meshes in vertex and index buffers: strided positions, and indices of 16 or 32 bits.
//!
//! [`Mesh`] borrows packed positions and 32-bit indices. A buffer that is laid out so is borrowed; any other one is
//! copied, once, into memory of the caller's.

#[cfg(feature = "std")]
use crate::memory::reserve;
use crate::memory::{Call, Done};
use crate::mesh::pfront_mesh_t;
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use bytemuck::Pod;
use core::ffi::{CStr, c_void};
use core::marker::PhantomData;
use pfront_capi_entry::entry;
use pfront_core::Mesh;

/// How an index buffer holds its indices.
#[repr(u32)]
#[derive(Clone, Copy)]
pub enum pfront_index_type_t {
    /// 32 bits each.
    PFRONT_INDEX_U32 = 0,
    /// 16 bits each.
    PFRONT_INDEX_U16 = 1,
}

/// A mesh as an engine keeps it: a vertex buffer and an index buffer. Positions that are not packed, and indices of 16
/// bits, may lie at any address.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_buffers_t {
    /// x, y and z of the first vertex, three floats in turn; those of vertex i lie i * `stride` bytes further on.
    pub positions: *const c_void,
    /// How many vertices.
    pub vertex_count: usize,
    /// Bytes from one vertex to the next, at least 12; 0 stands for 12, which is packed.
    pub stride: usize,
    /// The three vertices of each triangle in turn.
    pub triangles: *const c_void,
    /// How many triangles: a third of the indices.
    pub triangle_count: usize,
    /// A `pfront_index_type_t`.
    pub index_type: u32,
}

/// The names that C has for the members of some buffers.
pub(crate) struct Names {
    pub(crate) positions: &'static CStr,
    pub(crate) stride: &'static CStr,
    pub(crate) triangles: &'static CStr,
    pub(crate) index_type: &'static CStr,
}

/// The names where there is one mesh.
pub(crate) const NAMES: Names = Names {
    positions: c"positions",
    stride: c"stride",
    triangles: c"triangles",
    index_type: c"index_type",
};

/// Buffers whose stride and index type are checked; of positions that are each a `P`.
#[derive(Clone, Copy)]
pub(crate) struct Buffers<P = [f32; 3]> {
    buffers: pfront_buffers_t,
    names: &'static Names,
    stride: usize,
    is_u16: bool,
    position: PhantomData<P>,
}

impl pfront_buffers_t {
    /// Vertices without triangles.
    pub(crate) fn of_vertices(
        positions: *const c_void,
        vertex_count: usize,
        stride: usize,
    ) -> Self {
        let triangles = core::ptr::null();
        Self { positions, vertex_count, stride, triangles, triangle_count: 0, index_type: 0 }
    }

    pub(crate) fn checked<P>(self, names: &'static Names) -> Result<Buffers<P>, Fault> {
        let packed = size_of::<P>();
        let stride = if self.stride == 0 { packed } else { self.stride };
        Fault::room(names.stride, stride, packed)?;
        Fault::below(names.index_type, self.index_type as usize, 2)?;
        let is_u16 = self.index_type == pfront_index_type_t::PFRONT_INDEX_U16 as u32;
        Ok(Buffers { buffers: self, names, stride, is_u16, position: PhantomData })
    }
}

impl<P: Pod> Buffers<P> {
    pub(crate) fn names(&self) -> &'static Names {
        self.names
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.buffers.vertex_count
    }

    pub(crate) fn triangle_count(&self) -> usize {
        self.buffers.triangle_count
    }

    /// Copies the positions, of which there is one for each of `out`.
    fn copy_positions(&self, call: &Call<'_>, out: &mut [P]) -> Done {
        let packed = size_of::<P>();
        let (what, count, stride) = (self.names.positions, self.vertex_count(), self.stride);
        // The bytes of the last vertex behind its position may not be there.
        let bytes = count.saturating_sub(1).checked_mul(stride);
        let bytes = bytes.and_then(|bytes| bytes.checked_add(packed.min(count * packed)));
        let bytes = bytes.ok_or(Fault::of(PFRONT_TOO_LONG, what).numbers(0, count))?;
        let bytes = call.read(what, self.buffers.positions.cast::<u8>(), bytes)?;
        let vertices = bytes.chunks(stride).filter_map(|vertex| vertex.get(..packed));
        for (out, vertex) in out.iter_mut().zip(vertices) {
            *out = bytemuck::pod_read_unaligned(vertex);
        }
        Ok(())
    }

    /// Copies the triangles, of which there is one for each of `out`.
    fn copy_triangles(&self, call: &Call<'_>, out: &mut [[u32; 3]]) -> Done {
        let (what, count) = (self.names.triangles, self.triangle_count());
        let indices = count.checked_mul(3);
        let indices = indices.ok_or(Fault::of(PFRONT_TOO_LONG, what).numbers(0, count))?;
        let first = self.buffers.triangles;
        let out = out.as_flattened_mut().iter_mut();
        if self.is_u16 {
            for (out, index) in out.zip(call.read(what, first.cast::<[u8; 2]>(), indices)?) {
                *out = u16::from_ne_bytes(*index).into();
            }
        } else {
            for (out, index) in out.zip(call.read(what, first.cast::<[u8; 4]>(), indices)?) {
                *out = u32::from_ne_bytes(*index);
            }
        }
        Ok(())
    }

    /// Copies of the positions and of the triangles.
    #[cfg(feature = "std")]
    pub(crate) fn copies(&self, call: &Call<'_>) -> Result<(Vec<P>, Vec<[u32; 3]>), Fault> {
        let mut positions = zeros(self.vertex_count())?;
        self.copy_positions(call, &mut positions)?;
        let mut triangles = zeros(self.triangle_count())?;
        self.copy_triangles(call, &mut triangles)?;
        Ok((positions, triangles))
    }
}

impl Buffers {
    /// How many words of 4 bytes a mesh needs beside the buffers, for positions and for indices.
    pub(crate) fn words(&self) -> Result<[usize; 2], Fault> {
        let words = |what, count: usize, copied: bool| {
            let words = if copied { count.checked_mul(3) } else { Some(0) };
            let fits = words.filter(|&words| words <= isize::MAX as usize / 16);
            fits.ok_or(Fault::of(PFRONT_TOO_LONG, what).numbers(0, count))
        };
        let is_packed = self.stride == size_of::<[f32; 3]>();
        let positions = words(self.names.positions, self.vertex_count(), !is_packed)?;
        Ok([positions, words(self.names.triangles, self.triangle_count(), self.is_u16)?])
    }

    /// The positions: borrowed if they are packed, else copied to `memory`, which has the length of [`Buffers::words`].
    pub(crate) fn positions<'c>(
        &self,
        call: &Call<'c>,
        memory: &'c mut [[f32; 3]],
    ) -> Result<&'c [[f32; 3]], Fault> {
        if self.stride == size_of::<[f32; 3]>() {
            let first = self.buffers.positions.cast();
            return call.read(self.names.positions, first, self.vertex_count());
        }
        self.copy_positions(call, memory)?;
        Ok(memory)
    }

    /// The mesh, checked, of which `memory` holds what the core cannot borrow: as many words as [`Buffers::words`].
    pub(crate) fn mesh<'c>(
        &self,
        call: &Call<'c>,
        memory: &'c mut [u32],
    ) -> Result<Mesh<'c>, Fault> {
        let [positions, triangles] = self.words()?;
        let short = Fault::new(PFRONT_DAMAGED);
        let (positions, rest) = memory.split_at_mut_checked(positions).ok_or(short)?;
        let (triangles, _) = rest.split_at_mut_checked(triangles).ok_or(short)?;
        let (positions, _) = bytemuck::must_cast_slice_mut::<u32, f32>(positions).as_chunks_mut();
        let (triangles, _) = triangles.as_chunks_mut();
        let Self { names, buffers, is_u16, .. } = self;
        let positions = self.positions(call, positions)?;
        let triangles = if *is_u16 {
            self.copy_triangles(call, triangles)?;
            triangles
        } else {
            call.read(names.triangles, buffers.triangles.cast(), buffers.triangle_count)?
        };
        Mesh::new(positions, triangles).map_err(Fault::mesh(names.positions, names.triangles))
    }
}

/// So many zeros.
#[cfg(feature = "std")]
fn zeros<T: Pod>(count: usize) -> Result<Vec<T>, Fault> {
    let mut zeros = Vec::new();
    resize(&mut zeros, count)?;
    Ok(zeros)
}

/// Makes it so many zeros.
#[cfg(feature = "std")]
pub(crate) fn resize<T: Pod>(out: &mut Vec<T>, count: usize) -> Done {
    out.clear();
    reserve(out, count)?;
    out.resize(count, T::zeroed());
    Ok(())
}

/// How many bytes of memory `pfront_mesh_from_buffers` needs; 0 if it can borrow both buffers. In O(1).
#[entry]
fn pfront_mesh_bytes(
    call: &mut Call<'_>,
    buffers: *const pfront_buffers_t,
    mesh_bytes: *mut usize,
) -> Done {
    let out = call.out(c"mesh_bytes", mesh_bytes)?;
    out.set(bytes(&call.get(c"buffers", buffers)?.checked(&NAMES)?)?);
    Ok(())
}

/// Bytes of the words at any address.
fn bytes(buffers: &Buffers) -> Result<usize, Fault> {
    let [positions, triangles] = buffers.words()?;
    let words = positions + triangles;
    Ok(if words == 0 { 0 } else { words * size_of::<u32>() + align_of::<u32>() - 1 })
}

/// Makes a mesh of a vertex buffer and an index buffer and checks it as `pfront_mesh_check` does. Packed positions and
/// indices of 32 bits are borrowed, and must stay where they are; anything else is copied into `memory`, of any
/// alignment, which takes their place. `pfront_mesh_bytes` tells how large that must be; it may be null if that is 0.
///
/// When a mesh deforms, make it again and hand its positions to `pfront_bvh_refit`. In O(vertices + triangles).
#[entry]
fn pfront_mesh_from_buffers(
    call: &mut Call<'_>,
    buffers: *const pfront_buffers_t,
    memory: *mut c_void,
    memory_bytes: usize,
    mesh: *mut pfront_mesh_t,
) -> Done {
    let out = call.out(c"mesh", mesh)?;
    let buffers = call.get(c"buffers", buffers)?.checked(&NAMES)?;
    let needed = bytes(&buffers)?;
    Fault::room(c"memory", memory_bytes, needed)?;
    let words = call.write(c"memory", memory.cast::<u8>(), needed)?;
    let (_, words, _) = bytemuck::pod_align_to_mut(words);
    let checked = buffers.mesh(call, words)?;
    // The caller's own pointers: into memory if there is a copy.
    let of = |borrowed: *const c_void, address: usize| {
        if borrowed.addr() == address { borrowed } else { memory.cast_const().with_addr(address) }
    };
    let (positions, triangles) = (checked.shadow(), checked.triangles());
    let pfront_buffers_t { positions: own_positions, triangles: own_triangles, .. } =
        buffers.buffers;
    out.set(pfront_mesh_t::made(
        of(own_positions, positions.as_ptr().addr()).cast(),
        positions.len(),
        of(own_triangles, triangles.as_ptr().addr()).cast(),
        triangles.len(),
    ));
    Ok(())
}
