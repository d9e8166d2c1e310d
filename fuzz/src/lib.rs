//! What the fuzz targets have in common, and a world in which any sequence of calls is checked.
//!
//! [`input`] turns bytes into meshes, poses and calls. A world makes the calls, on every backend at
//! once, and compares all answers with each other and with the exact oracle's loop over all pairs.

mod answers;
mod ask;
mod body;
pub mod input;
mod truth;
mod world;

use world::World;

pub use answers::{as_pairs, pages};
pub use body::{Builder, Tree};
