#![no_std]
#![doc = "The allocation-free heart of `pfront`."]

#[cfg(feature = "std")]
extern crate std;

pub mod aabb;
pub mod blob;
pub mod build;
pub mod bvh;
mod error;
pub mod fans;
pub mod front;
mod heap;
mod items;
mod lanes;
pub mod mesh;
pub mod partition;
mod place;
pub mod pose;
pub mod predicates;
pub mod query;
pub mod sphere;
pub mod triangle;
pub mod walk;

pub use aabb::Aabb;
pub use blob::{Blob, BlobError};
pub use bvh::{Bvh, BvhError, Node};
pub use error::CapacityError;
pub use mesh::{Mesh, MeshError, Triangle};
pub use pose::Pose;
