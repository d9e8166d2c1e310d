//! Recorded truths on real meshes, on the CPU and on a GPU, at rest and in motion. Run with `--features recorded`; `data.rs` says where the
//! data is looked for.

#![cfg(feature = "recorded")]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod data;
mod motion;
mod on_cpu;
#[cfg(feature = "gpu")]
mod on_gpu;
