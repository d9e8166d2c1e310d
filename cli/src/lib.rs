//! The parts of the `pfront` command that other programs of this workspace share: mesh files, options that choose an
//! executor, and where results go.

pub mod escape;
#[cfg(feature = "gpu")]
pub mod executor;
pub mod memory;
pub mod mesh;
pub mod output;
