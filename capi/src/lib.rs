//! pfront for C: `include/pfront.h`, which a test makes from these sources, says what there is.
//!
//! Every function goes through [`memory`], the one place that follows a pointer of the caller's. The structures that C
//! holds between two calls are plain data: numbers, and pointers into arrays that belong to the caller. Rust's views of
//! them ([`pfront_core::Bvh`] and so on) are made anew in each call and end with it, so nothing is kept behind the caller's
//! back, and there is nothing to lock or to free; but for models, executors, queries about models and scenes, which own what
//! they need, and lists, which an [`allocator`] owns. Names are those of C.
//!
//! A function is added so:
//! 1. in the module of its kind, `#[entry] fn pfront_name(call: &mut Call<'_>, ...) -> Done`, with what the header is to say.
//!    `entry` gives it `error` and a status in C, catches panics, and sets the floating-point environment;
//! 2. its body claims what it writes first ([`memory::Call::out`], [`write`](memory::Call::write), `owned`), then reads
//!    ([`get`](memory::Call::get), [`read`](memory::Call::read), `shared`), calls Rust, and sets what goes out, last;
//! 3. `PFRONT_WRITE_HEADER=1 cargo test --test header` writes the header. A method goes to `include/pfront.hpp`, a line to
//!    README.md, and a test of it in C to `tests`, which `.ci/capi` runs under valgrind and sanitizers.

#![cfg_attr(not(feature = "std"), no_std)]
#![expect(non_camel_case_types, reason = "the names of types are those of C")]

mod allocator;
mod alone;
mod blob;
mod buffers;
mod build;
mod bvh;
mod cursor;
#[cfg(feature = "std")]
mod executor;
mod front;
#[cfg(feature = "std")]
mod impacts;
mod memory;
mod mesh;
mod meshes;
#[cfg(feature = "std")]
mod model;
mod one_ring;
mod pose;
mod query;
#[cfg(feature = "std")]
mod relation;
#[cfg(feature = "std")]
mod scene;
#[cfg(feature = "std")]
mod segment;
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
#[cfg(feature = "std")]
pub use impacts::*;
pub use mesh::*;
pub use meshes::*;
#[cfg(feature = "std")]
pub use model::*;
pub use one_ring::*;
pub use pose::*;
pub use query::*;
#[cfg(feature = "std")]
pub use relation::*;
#[cfg(feature = "std")]
pub use scene::*;
#[cfg(feature = "std")]
pub use segment::*;
pub use status::*;
#[cfg(feature = "std")]
pub use subject::*;
pub use verbs::*;
