//! A mesh and its BVH as bytes: baked once, and borrowed from flash or a file from then on.

use crate::build::pfront_adopt_scratch_bytes;
use crate::bvh::pfront_bvh_t;
use crate::memory::{Call, Done};
use crate::mesh::pfront_mesh_t;
use core::ffi::c_void;
use pfront_blob::Counts;
use pfront_blob::{Blob, BlobError};
use pfront_capi_entry::entry;

/// How many bytes `pfront_blob_write` writes of a BVH, its mesh included; or how many the blob of a borrowed one has.
#[entry]
fn pfront_blob_size(call: &mut Call<'_>, bvh: *const pfront_bvh_t, blob_bytes: *mut usize) -> Done {
    let (out, bvh) = (call.out(c"blob_bytes", blob_bytes)?, call.get(c"bvh", bvh)?);
    out.set(Counts::of(&bvh.view(call, c"bvh")?).bytes());
    Ok(())
}

/// Writes a BVH and its mesh as a blob: bytes that are the same on every machine, with a checksum, for a file or for
/// flash. `blob` may lie anywhere, and is written as far as `pfront_blob_size` tells. In O(bytes).
#[entry]
fn pfront_blob_write(
    call: &mut Call<'_>,
    bvh: *const pfront_bvh_t,
    blob: *mut c_void,
    blob_bytes: usize,
) -> Done {
    let bvh = call.get(c"bvh", bvh)?;
    let out = call.write(c"blob", blob.cast::<u8>(), blob_bytes)?;
    pfront_blob::write(&bvh.view(call, c"bvh")?, out)?;
    Ok(())
}

/// How much scratch `pfront_bvh_from_blob` needs for a blob to take one pass over its order: by its header, which is all
/// that is checked. In O(1).
#[entry]
fn pfront_blob_scratch_bytes(
    call: &mut Call<'_>,
    blob: *const c_void,
    blob_bytes: usize,
    scratch_bytes: *mut usize,
) -> Done {
    let out = call.out(c"scratch_bytes", scratch_bytes)?;
    let bytes = call.read(c"blob", blob.cast::<u8>(), blob_bytes)?;
    out.set(pfront_adopt_scratch_bytes(Blob::new(own(bytes))?.counts().triangles));
    Ok(())
}

/// The blob that `bytes` begin with, as far as its header says, or all of them.
fn own(bytes: &[u8]) -> &[u8] {
    let Err(BlobError::Length { needed, .. }) = Blob::new(bytes) else { return bytes };
    usize::try_from(needed).ok().and_then(|needed| bytes.get(..needed)).unwrap_or(bytes)
}

/// Makes a BVH of the blob that `blob_bytes` bytes begin with, where it lies, after checking all that a query relies on:
/// the checksum, and since that is no signature, every coordinate, index, box and child. The bytes behind the blob are left
/// alone.
///
/// `blob` must be at a multiple of 4 bytes, and had better be at one of 64; it is only read, now and by queries, and may
/// lie in read-only memory. `pfront_bvh_refit` refuses such a BVH. `scratch` is as for `pfront_bvh_adopt`, of
/// `pfront_blob_scratch_bytes` or down to 7 bytes, and free again afterwards. In O(bytes).
#[entry]
fn pfront_bvh_from_blob(
    call: &mut Call<'_>,
    blob: *const c_void,
    blob_bytes: usize,
    scratch: *mut c_void,
    scratch_bytes: usize,
    bvh: *mut pfront_bvh_t,
) -> Done {
    let out = call.out(c"bvh", bvh)?;
    let scratch = call.marks(scratch, scratch_bytes)?;
    let bytes = call.read(c"blob", blob.cast::<u8>(), blob_bytes)?;
    let checked = Blob::new(own(bytes))?.bvh(scratch)?;
    let mesh = checked.mesh();
    // The caller's own pointer, further on.
    let at = |address| blob.with_addr(address);
    let mesh = pfront_mesh_t::made(
        at(mesh.shadow().as_ptr().addr()).cast(),
        mesh.vertex_count(),
        at(mesh.triangles().as_ptr().addr()).cast(),
        mesh.triangles().len(),
    );
    let nodes = at(checked.nodes().as_ptr().addr()).cast();
    let order = at(checked.order().as_ptr().addr()).cast();
    out.set(pfront_bvh_t::borrowed(mesh, nodes, checked.nodes().len(), order));
    Ok(())
}
