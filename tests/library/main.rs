//! Tests of the library as its users see it, in one program: each program links the whole library, and has a copy of what is generic
//! in it. Beside it are tests that need a process of their own: an allocator, threads that are counted, ways to end.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod api;
mod background;
mod blob;
mod cancel;
mod contacts;
mod distance;
#[cfg(all(target_arch = "x86_64", feature = "threads"))]
mod environment;
mod executors;
mod fans;
mod impacts;
mod in_f64;
mod model;
mod one_ring;
#[cfg(feature = "threads")]
mod plan;
mod predicates;
mod predicates_f64;
mod queries;
mod questions;
mod relation;
mod scene;
mod scene_history;
mod scene_impacts;
mod scene_split;
mod segment;
mod side_by_side;
mod spheres;
mod still;
#[cfg(feature = "threads")]
mod threads;
#[cfg(feature = "gpu")]
mod wear;
mod within;
