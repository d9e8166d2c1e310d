//! The parts of the `pfront` command that other programs of this workspace share: JSON, options that choose an
//! executor, and where results go.

#[cfg(feature = "gpu")]
pub mod executor;
pub mod json;
pub mod memory;
pub mod output;
