//! Planners, and what they know of this machine.

use crate::adapters;
use crate::how;
use crate::output::Draft;
use anyhow::{Context, Result};
use clap::ValueEnum;
use pfront::gpu::Gpu;
use pfront::planner::{Machine, Planner};
use pfront_study::engine::On;
use std::fs::File;
use std::io::{BufReader, Write};
use std::num::NonZero;
use std::path::Path;

/// Which GPU a planner may use beside the CPU.
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

/// What this machine can do: as a file says, or measured.
///
/// # Errors
/// As [`read`] and [`measure`].
pub(crate) fn machine(file: Option<&Path>, gpu: Option<&Gpu>) -> Result<Machine> {
    match file {
        Some(path) => read(path),
        None => measure(gpu),
    }
}

/// What [`write`] has kept.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn read(path: &Path) -> Result<Machine> {
    let name = || path.display().to_string();
    let from = BufReader::new(File::open(path).with_context(name)?);
    serde_json::from_reader(from)
        .with_context(|| format!("{}: not a machine as plan --calibrate writes it", name()))
}

/// In about a second.
///
/// # Errors
/// If the GPU fails.
pub(crate) fn measure(gpu: Option<&Gpu>) -> Result<Machine> {
    let machine = Machine::measure();
    Ok(match gpu {
        Some(gpu) => machine.measure_gpu(gpu)?,
        None => machine,
    })
}

/// Keeps what was measured.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write(machine: &Machine, path: &Path) -> Result<()> {
    let mut file = Draft::new(path)?;
    serde_json::to_writer_pretty(&mut file, machine)?;
    writeln!(file)?;
    file.finish()
}

/// A planner with as many threads as are asked for, or else those that the machine was measured with.
///
/// # Errors
/// If there is no pool of as many threads.
pub(crate) fn planner(
    machine: Machine,
    threads: Option<NonZero<usize>>,
    gpu: Option<&Gpu>,
) -> Result<Planner> {
    let planner = Planner::new(machine);
    let planner = match threads {
        None => planner,
        Some(threads) => match how::on_threads(threads.get())? {
            On::Cpu(Some(traversal)) => planner.with_traversal(*traversal),
            _ => planner.with_threads(1),
        },
    };
    Ok(match gpu {
        Some(gpu) => planner.with_gpu(gpu),
        None => planner,
    })
}
