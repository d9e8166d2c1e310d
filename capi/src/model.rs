//! Models: a mesh and its BVH in memory of the library's own, for the bodies of scenes.

#![expect(
    unsafe_code,
    reason = "C finds functions by name, and keeps to the contract of the header"
)]
#![expect(
    clippy::missing_safety_doc,
    reason = "the header has the contract, once for all functions"
)]

use crate::buffers::{NAMES, pfront_buffers_t};
use crate::memory::{Call, Caller, Handle};
use crate::status::pfront_error_t;
use crate::status::pfront_status_t;
use core::ffi::c_void;
use pfront::Model;
use std::sync::Arc;

/// A mesh and its BVH, for the bodies of scenes. Any number of threads and scenes may use one at once.
pub struct pfront_model_t(());

impl Handle for pfront_model_t {
    type Value = Arc<Model>;
    const SEAL: u32 = u32::from_be_bytes(*b"modl");
}

/// Makes a model of a vertex buffer and an index buffer, which are copied, and builds its BVH by the surface area
/// heuristic.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_model_create(
    buffers: *const pfront_buffers_t,
    model: *mut *mut pfront_model_t,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let out = call.out(c"model", model)?;
        let (positions, triangles) =
            call.get(c"buffers", buffers)?.checked(&NAMES)?.copies(call)?;
        out.set(Call::boxed(Arc::new(Model::new(positions, triangles)?))?);
        Ok(())
    })
}

/// `pfront_model_create` of positions in double in place of float: `stride` is at least 24, and 0 stands for 24. Coordinates
/// are at most 2^125. Questions about the model are decided in f64, exactly for the positions given, whatever the other body
/// and the poses. Takes 24 bytes a vertex more, unless floats hold every coordinate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_model_create_f64(
    buffers: *const pfront_buffers_t,
    model: *mut *mut pfront_model_t,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let out = call.out(c"model", model)?;
        let (positions, triangles) =
            call.get(c"buffers", buffers)?.checked(&NAMES)?.copies(call)?;
        out.set(Call::boxed(Arc::new(Model::from_f64(positions, triangles)?))?);
        Ok(())
    })
}

/// Makes a model of a blob, whose mesh and BVH are checked and copied, so that nothing is built. The bytes may lie
/// anywhere, and are of no use afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_model_from_blob(
    blob: *const c_void,
    blob_bytes: usize,
    model: *mut *mut pfront_model_t,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let out = call.out(c"model", model)?;
        let bytes = call.read(c"blob", blob.cast::<u8>(), blob_bytes)?;
        out.set(Call::boxed(Arc::new(Model::from_blob(bytes)?))?);
        Ok(())
    })
}

/// Frees a model; null is fine. Bodies that were made of it stay as they are. PFRONT_BUSY if another thread is inside a call
/// with it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_model_free(
    model: *mut pfront_model_t,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| call.free(c"model", model))
}
