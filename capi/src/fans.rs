//! Vertices about which a mesh is no trouble.

#![expect(
    unsafe_code,
    reason = "C finds functions by name, and keeps to the contract of the header"
)]
#![expect(
    clippy::missing_safety_doc,
    reason = "the header has the contract, once for all functions"
)]

use crate::memory::Caller;
use crate::mesh::pfront_mesh_t;
use crate::status::Fault;
use crate::status::pfront_error_t;
use crate::status::pfront_status_t;
use core::ffi::c_void;
use pfront_core::mesh::MAX_TRIANGLES;
use pfront_core::one_ring::{self, Fan, link_scratch_bound};

/// What is known of the triangles about one vertex. With it, self queries need not look at most neighbours.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_fan_t {
    /// Private.
    pub bits: u32,
}

const _: () = assert!(size_of::<pfront_fan_t>() == size_of::<Fan>());
const _: () = assert!(align_of::<pfront_fan_t>() == align_of::<Fan>());

/// How much scratch `pfront_fans_link` needs; SIZE_MAX if that cannot be.
#[unsafe(no_mangle)]
pub extern "C" fn pfront_fans_scratch_bytes(vertex_count: usize, triangle_count: usize) -> usize {
    const MOST: usize = usize::MAX / 32;
    if vertex_count > MOST || triangle_count > MAX_TRIANGLES.min(MOST) {
        return usize::MAX;
    }
    link_scratch_bound(vertex_count, triangle_count) * size_of::<u32>() + align_of::<u32>() - 1
}

/// Finds out which triangles lie next to each other about each vertex: once for a mesh, whatever its positions will be.
/// `fans` has one element a vertex and need not be initialised. In O(vertices + triangles).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_fans_link(
    mesh: *const pfront_mesh_t,
    fans: *mut pfront_fan_t,
    fan_count: usize,
    scratch: *mut c_void,
    scratch_bytes: usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let mesh = call.get(c"mesh", mesh)?;
        let needed = pfront_fans_scratch_bytes(mesh.vertex_count, mesh.triangle_count);
        Fault::room(c"scratch", scratch_bytes, needed)?;
        let fans = call.write(c"fans", fans.cast::<Fan>(), fan_count)?;
        let scratch = call.write(c"scratch", scratch.cast::<u8>(), scratch_bytes)?;
        let (_, scratch, _) = bytemuck::pod_align_to_mut::<u8, u32>(scratch);
        Ok(one_ring::link(mesh.view(call, c"mesh")?, scratch, fans)?)
    })
}

/// Brings fans up to date with the positions of their mesh, after each refit: `bvh.mesh` has the new positions. In
/// O(vertices + triangles). A query with fans that are not up to date may miss pairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_fans_certify(
    mesh: *const pfront_mesh_t,
    fans: *mut pfront_fan_t,
    fan_count: usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let mesh = call.get(c"mesh", mesh)?;
        let fans = call.write(c"fans", fans.cast::<Fan>(), fan_count)?;
        Ok(one_ring::certify(mesh.view(call, c"mesh")?, fans)?)
    })
}
