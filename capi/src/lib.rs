//! pfront for C: `include/pfront.h`, which a test makes from these sources, says what there is.
//!
//! Every function goes through [`memory`], the one place that follows a pointer of the caller's. The structures that C
//! holds between two calls are plain data: numbers, and pointers into arrays that belong to the caller. Rust's views of
//! them ([`pfront_core::Bvh`] and so on) are made anew in each call and end with it, so nothing is kept behind the caller's
//! back, and there is nothing to lock or to free; but for models, executors, queries about models and scenes, which own what they need, and lists, which an
//! [`allocator`] owns. Names are those of C.

#![cfg_attr(not(feature = "std"), no_std)]
#![expect(non_camel_case_types, reason = "the names of types are those of C")]

mod allocator;
mod alone;
mod blob;
mod buffers;
mod build;
mod bvh;
mod cursor;
#[cfg(all(test, target_arch = "x86_64", not(miri)))]
mod environment;
#[cfg(feature = "std")]
mod executor;
mod front;
mod memory;
mod mesh;
mod meshes;
#[cfg(feature = "std")]
mod model;
mod one_ring;
mod pose;
mod query;
#[cfg(feature = "std")]
mod scene;
mod status;
#[cfg(feature = "std")]
mod subject;
#[cfg(test)]
mod tests;
mod verbs;

pub use allocator::*;
pub use blob::*;
pub use buffers::*;
pub use build::*;
pub use bvh::*;
pub use cursor::*;
#[cfg(feature = "std")]
pub use executor::*;
pub use front::*;
pub use mesh::*;
pub use meshes::*;
#[cfg(feature = "std")]
pub use model::*;
pub use one_ring::*;
pub use pose::*;
pub use query::*;
#[cfg(feature = "std")]
pub use scene::*;
pub use status::*;
#[cfg(feature = "std")]
pub use subject::*;
pub use verbs::*;
