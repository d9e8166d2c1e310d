//! One-rings: the triangles around each vertex, and certificates that they do not intersect each other.

use crate::memory::{Call, Done};
use crate::mesh::pfront_mesh_t;
use crate::status::Fault;
use core::ffi::c_void;
use pfront_capi_entry::entry;
use pfront_core::MAX_TRIANGLES;
use pfront_core::one_ring::{OneRings, history_bound, link_scratch_bound};

/// Numbers of vertices or triangles for which no size overflows.
const MOST: usize = usize::MAX / 32;

/// How many words the history of one-rings has; SIZE_MAX if that cannot be.
#[entry]
fn pfront_history_bound(vertex_count: usize, triangle_count: usize) -> usize {
    if vertex_count > MOST || triangle_count > MAX_TRIANGLES.min(MOST) {
        return usize::MAX;
    }
    history_bound(vertex_count)
}

/// How much scratch `pfront_one_rings_link` needs; SIZE_MAX if that cannot be.
#[entry]
fn pfront_link_scratch_bytes(vertex_count: usize, triangle_count: usize) -> usize {
    if vertex_count > MOST || triangle_count > MAX_TRIANGLES.min(MOST) {
        return usize::MAX;
    }
    link_scratch_bound(vertex_count, triangle_count) * size_of::<u32>() + align_of::<u32>() - 1
}

/// Finds out how the triangles around each vertex are connected: once for a mesh, whatever its positions will be.
/// `history` need not be initialised. `pfront_query_self` uses it for meshes with the same triangles. In
/// O(vertices + triangles).
#[entry]
fn pfront_one_rings_link(
    call: &mut Call<'_>,
    mesh: *const pfront_mesh_t,
    history: *mut u32,
    history_count: usize,
    scratch: *mut c_void,
    scratch_bytes: usize,
) -> Done {
    let mesh = call.get(c"mesh", mesh)?;
    let needed = pfront_link_scratch_bytes(mesh.vertex_count, mesh.triangle_count);
    Fault::room(c"scratch", scratch_bytes, needed)?;
    let history = call.write(c"history", history, history_count)?;
    let scratch = call.write(c"scratch", scratch.cast::<u8>(), scratch_bytes)?;
    let (_, scratch, _) = bytemuck::pod_align_to_mut::<u8, u32>(scratch);
    let mesh = mesh.view(call, c"mesh")?;
    OneRings::new(mesh.vertex_count(), mesh.triangles(), history, scratch)?;
    Ok(())
}
