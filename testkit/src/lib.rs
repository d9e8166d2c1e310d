//! The tools that tests and benches of every crate of pfront share: random numbers, shapes, moving scenes, hard triangle
//! pairs, the truth about them, and a test that is not exact.
//!
//! Nothing here depends on the library, and meshes are plain arrays: unit tests of `pfront-core` can use them too, and a
//! fault of the library cannot hide behind its twin.

pub mod families;
pub mod inexact;
mod mesh;
pub mod oracle;
pub mod rng;
pub mod scenes;
pub mod shapes;
pub mod solids;

pub use mesh::MeshData;
pub(crate) use scenes::grid_triangles;
use std::path::PathBuf;

/// A point in f32, finite.
pub type Point = [f32; 3];

/// A triangle by its corners.
pub type Triangle = [Point; 3];

/// A pose as its rows: `[r0, r1, r2, t]` for each coordinate, p' = ((r0·x + r1·y) + r2·z) + t. In scenes, world from
/// object.
pub type Rows = [[f32; 4]; 3];

/// The folder of recorded data: that which `PFRONT_DATA` names, else `../shared/data` beside the checkout.
pub fn data_folder() -> PathBuf {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    std::env::var_os("PFRONT_DATA").map_or_else(|| beside.into(), PathBuf::from)
}

/// FNV-1a in 64 bits: short, public, and the same everywhere.
pub fn checksum(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let step = |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, step)
}
