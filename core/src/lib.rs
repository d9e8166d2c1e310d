#![no_std]
#![doc = "The allocation-free heart of `pfront`."]

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
pub mod pose;
mod simd;
pub mod sphere;
mod transform;
pub mod triangle;
mod vertex_set;

pub use aabb::Aabb;
pub use bvh::blob::{self, Blob, BlobError};
pub use bvh::{Bvh, BvhError, Node};
pub use error::CapacityError;
pub use mesh::{Mesh, MeshError, Triangle};
pub use pose::Pose;
