//! The executor that answers: the options that all queries share.

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use pfront::Executor;
use pfront::gpu::Gpu;
use pfront::gpu::wgpu::{Adapter, AdapterInfo, Backends, DeviceType, Instance, InstanceDescriptor};
use pfront::threads::Pool;
use pfront_files::escape::escaped;
use rayon::ThreadPoolBuilder;
use std::num::NonZero;
use std::path::Path;
use std::sync::Arc;
use std::thread::available_parallelism;

/// Options that choose an executor.
#[derive(Debug, Args)]
pub struct ExecutorArgs {
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    threads: Option<NonZero<usize>>,
    /// Backend that answers
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
}

/// The backends that may answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// The threads of this machine
    Cpu,
    /// The best adapter, even if it computes on the CPU; see pfront devices
    Gpu,
    /// The threads, and a GPU if there is one
    Auto,
}

impl ExecutorArgs {
    /// Returns the executor.
    ///
    /// # Errors
    /// If there is no adapter, none that could do it, or no pool of as many threads.
    pub fn open(&self) -> Result<Executor> {
        let cpu = threads(number(self.threads))?;
        match self.backend.open()? {
            Some(gpu) if self.is_auto() => Ok(cpu.and_gpu(&gpu, gpu.settings())?),
            Some(gpu) => Ok(cpu.behind_gpu(&gpu, gpu.settings())),
            None => Ok(cpu),
        }
    }

    /// Whether there is a choice of backend, which is then worth telling.
    pub fn is_auto(&self) -> bool {
        self.backend == Backend::Auto
    }
}

impl Backend {
    /// Opens the GPU, if there is to be one. Standard error names a GPU of `Auto` that cannot be used.
    ///
    /// # Errors
    /// If a GPU was asked for, and there is none, or none that could do it.
    pub fn open(self) -> Result<Option<Gpu>> {
        let is_a_gpu = |adapter: &Adapter| adapter.get_info().device_type != DeviceType::Cpu;
        match self {
            Self::Gpu => Ok(Some(Gpu::new()?)),
            Self::Auto if adapters().iter().any(is_a_gpu) => Ok(Gpu::new()
                .inspect_err(|error| eprintln!("without a GPU: {}", escaped(&error.to_string())))
                .ok()),
            Self::Cpu | Self::Auto => Ok(None),
        }
    }
}

/// The adapters that WGPU_BACKEND admits, or else all.
pub fn adapters() -> Vec<Adapter> {
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle_from_env());
    pollster::block_on(instance.enumerate_adapters(Backends::all()))
}

/// Keeps libwayland from complaining on standard error, once for each time that Mesa's device-select layer looks for
/// adapters, of an XDG_RUNTIME_DIR that is unset because nobody is logged in: names a folder that there is not. To be called
/// first thing, since it does nothing once there is another thread.
pub fn quieten_drivers() {
    let is_valid =
        std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|path| Path::new(&path).is_absolute());
    let is_alone =
        || std::fs::read_dir("/proc/self/task").is_ok_and(|threads| threads.count() == 1);
    if cfg!(target_os = "linux") && !is_valid && is_alone() {
        #[expect(unsafe_code, reason = "the variable is read by drivers that take no other advice")]
        // SAFETY: the process has no other thread that could read the environment meanwhile.
        unsafe {
            std::env::set_var("XDG_RUNTIME_DIR", "/nonexistent");
        }
    }
}

/// The name of an adapter, which tells two drivers of the same device apart.
pub fn adapter_name(info: &AdapterInfo) -> String {
    format!("{} ({:?})", info.name, info.backend)
}

/// The most threads for each of the machine's own. A pool of more spends its time on waking threads that wait for
/// each other, and one of very many never gets to work.
const MOST_PER_THREAD: usize = 8;
/// The bound on machines with few threads of their own, so that many threads can be tried there.
const FEWEST: usize = 64;

/// Reads a number of threads, which must be within what the machine can use.
///
/// # Errors
/// If it is not a number, 0, or beyond the bound.
pub fn parse_threads(text: &str) -> Result<NonZero<usize>> {
    let own = available_parallelism().map_or(1, NonZero::get);
    let most = FEWEST.max(MOST_PER_THREAD * own);
    let threads = text.parse().ok().filter(|threads: &NonZero<usize>| threads.get() <= most);
    threads.with_context(|| {
        format!(
            "must be 1 to {most}: this machine runs {own} threads at once, and more would only wait for each other"
        )
    })
}

/// The number of threads asked for, or else all of this machine.
pub fn number(asked: Option<NonZero<usize>>) -> usize {
    let all = || available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    asked.unwrap_or_else(all).get()
}

/// Returns an executor of so many threads, with a pool of its own.
///
/// # Errors
/// If there is no pool of them.
pub fn threads(threads: usize) -> Result<Executor> {
    if threads == 1 {
        return Ok(Executor::sequential());
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.with_context(|| format!("no pool of {threads} threads"))?;
    Ok(Executor::from(Pool::from(Arc::new(pool))))
}
