//! What tests and benches of every crate of pfront share: random numbers, shapes, moving scenes, hard triangle pairs, and
//! the truth about them.
//!
//! Nothing here depends on the library, and meshes are plain arrays: unit tests of `pfront-core` can use them too, and a
//! fault of the library cannot hide behind its twin.

pub mod families;
pub mod oracle;
pub mod rng;
pub mod scenes;
pub mod shapes;

/// A point in f32, finite.
pub type Point = [f32; 3];

/// A triangle by its corners.
pub type Triangle = [Point; 3];

/// FNV-1a in 64 bits: short, public, and the same everywhere.
#[must_use]
pub fn checksum(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let step = |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, step)
}
