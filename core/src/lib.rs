#![no_std]
//! The allocation-free heart of `pfront`.
//!
//! # Floating-point environment
//! Exact answers need IEEE 754's default environment on every thread that calls: rounding to nearest, and
//! subnormal numbers kept (no FTZ or DAZ, so no `-ffast-math` start-up code of the host). Rust assumes
//! that environment everywhere. [`Mesh::new`] and [`Mesh::with_positions`] look at it and refuse to work in
//! another one; queries do not look again. The C API sets and restores it by itself.

#[cfg(feature = "std")]
extern crate std;

pub mod aabb;
pub mod bvh;
pub mod bvtt;
mod error;
pub mod exact;
pub mod front;
mod index;
pub mod mesh;
pub mod one_ring;
mod parallel;
pub mod pose;
mod simd;
pub mod triangle;
mod vertex_set;

pub use aabb::Aabb;
pub use bvh::blob::{self, Blob, BlobError};
pub use bvh::{Bvh, BvhError, Node};
pub use error::CapacityError;
pub use mesh::{Mesh, MeshError, Triangle};
pub use pose::Pose;
