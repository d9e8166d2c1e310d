//! The parts that all fuzz targets share, and a world in which any sequence of calls is checked.
//!
//! [`input`] turns bytes into meshes, poses and steps. A world makes the [`Calls`], on every backend at
//! once, and compares all answers with each other and with the exact oracle's loop over all pairs.

mod answers;
mod ask;
mod body;
mod calls;
pub mod input;
mod truth;
mod world;

pub use answers::{as_pairs, pages};
pub use body::Tree;
pub use calls::Calls;
pub use input::Builder;

/// Gives a blob the right checksum, as everyone else computes it.
pub fn seal(bytes: &mut [u8]) {
    let Some((head, rest)) = bytes.split_at_mut_checked(16) else { return };
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&head[..12]);
    hasher.update(rest);
    head[12..].copy_from_slice(&hasher.finalize().to_le_bytes());
}
