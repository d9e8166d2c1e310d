//! A torus, of which the device builds the BVH, and one with a bulging tube, which `build.rs` has baked. Both lie
//! in flash and are borrowed from there.

use crate::shape::{TRIANGLES, VERTICES, grid, ring};
use pfront_blob::{Aligned, Blob, BlobError};
use pfront_core::{Bvh, Mesh, MeshError};

static POSITIONS: [[f32; 3]; VERTICES] = ring(0.0);
static GRID: [[u32; 3]; TRIANGLES] = grid();

const FILE: &[u8; include_bytes!(concat!(env!("OUT_DIR"), "/beads.pfb")).len()] =
    include_bytes!(concat!(env!("OUT_DIR"), "/beads.pfb"));
static BAKED: Aligned<[u8; FILE.len()]> = Aligned(*FILE);

/// The torus.
pub fn torus() -> Result<Mesh<'static>, MeshError> {
    Mesh::new(&POSITIONS, &GRID)
}

/// The one with a bulging tube.
pub fn beads() -> Result<Bvh<'static>, BlobError> {
    Blob::new(&BAKED.0)?.bvh(&mut [0; TRIANGLES.div_ceil(32)])
}
