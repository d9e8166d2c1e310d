//! Which GPU there is beside the CPU.

use crate::adapters;
use anyhow::Result;
use clap::ValueEnum;
use pfront::gpu::Gpu;

/// Which GPU may be used beside the CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Gpus {
    /// Only the threads of this machine
    Cpu,
    /// Also the best adapter, even if it computes on the CPU; see pfront devices
    Gpu,
    /// Also a GPU, if there is one
    Auto,
}

impl Gpus {
    /// The GPU, if there shall be one. Says on standard error if there is one that cannot be had.
    ///
    /// # Errors
    /// If one was asked for, and there is none, or none that could do it.
    pub(crate) fn open(self) -> Result<Option<Gpu>> {
        match self {
            Self::Cpu => Ok(None),
            Self::Gpu => Ok(Some(Gpu::new()?)),
            Self::Auto if adapters::any_is_a_gpu() => {
                let opened = Gpu::new();
                Ok(opened.inspect_err(|error| eprintln!("without a GPU: {error}")).ok())
            }
            Self::Auto => Ok(None),
        }
    }
}
