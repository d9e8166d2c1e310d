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
