//! Who finds the pairs, and how exactly: the options that all queries share.

use crate::planning::{self, Gpus};
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use pfront::gpu::Gpu;
use pfront::planner::Machine;
use pfront::threads::Traversal;
use pfront::{Accuracy, Adjacency};
use pfront_study::engine::{Asked, On, OnGpu};
use rayon::ThreadPoolBuilder;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::available_parallelism;

#[derive(Debug, Args)]
pub(crate) struct How {
    /// What an answer promises
    #[arg(long, value_enum, default_value_t = Promise::Exact)]
    accuracy: Promise,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    threads: Option<NonZero<usize>>,
    /// What to run on
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    /// What auto is to know of this machine, as plan --calibrate writes it
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Promise {
    /// The true set
    Exact,
    /// No pair is missed; some may not meet
    Conservative,
    /// Plain f32: none
    Fast,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Backend {
    /// The threads of this machine
    Cpu,
    /// The best adapter, even if it computes on the CPU; see pfront devices
    Gpu,
    /// Whoever is the fastest, frame by frame; standard error says who it was, and why
    Auto,
}

impl How {
    /// All threads, exactly.
    pub(crate) const DEFAULT: Self =
        Self { accuracy: Promise::Exact, threads: None, backend: Backend::Cpu, machine: None };

    /// How many threads will work.
    pub(crate) fn threads(&self) -> usize {
        threads(self.threads)
    }

    /// What has to answer.
    ///
    /// # Errors
    /// If there is no adapter, none that could do it, or no pool of as many threads.
    pub(crate) fn asked(&self) -> Result<Asked> {
        ensure!(
            self.backend == Backend::Auto || self.machine.is_none(),
            "--machine is for --backend auto, which has a choice"
        );
        let on = match self.backend {
            Backend::Cpu => self.on_cpu()?,
            Backend::Gpu => self.on_gpu()?,
            Backend::Auto => self.on_fastest()?,
        };
        Ok(Asked { accuracy: self.accuracy.into(), adjacency: Adjacency::default(), on })
    }

    fn on_cpu(&self) -> Result<On> {
        on_threads(self.threads())
    }

    fn on_gpu(&self) -> Result<On> {
        ensure!(
            self.accuracy == Promise::Exact,
            "every answer of a GPU is exact: leave out --accuracy, or --backend"
        );
        Ok(On::Gpu(OnGpu::new(Gpu::new()?)))
    }

    /// What is known of this machine; else, if there is a GPU to open, what a second of measuring tells.
    fn on_fastest(&self) -> Result<On> {
        let (machine, gpu) = match &self.machine {
            Some(path) => {
                let machine = planning::read(path)?;
                let gpu = machine.device.is_some().then(|| Gpus::Auto.open()).transpose()?;
                (machine, gpu.flatten())
            }
            None => match Gpus::Auto.open()? {
                Some(gpu) => (planning::measure(Some(&gpu))?, Some(gpu)),
                None => (Machine::typical(), None),
            },
        };
        let planner = planning::planner(machine, self.threads, gpu.as_ref())?;
        Ok(On::Planner(Box::new(planner)))
    }
}

/// The most threads for each of the machine's own. A pool of more spends its time on waking threads that wait for
/// each other, and one of very many never gets to work.
const MOST_PER_THREAD: usize = 8;
/// A machine with few threads of its own takes this many, so that what many threads do can be tried on it.
const FEWEST: usize = 64;

/// Reads a number of threads, which must be within what the machine can use.
///
/// # Errors
/// If it is no number, 0, or beyond the bound.
pub(crate) fn parse_threads(text: &str) -> Result<NonZero<usize>> {
    let threads: NonZero<usize> = text.parse()?;
    let own = available_parallelism().map_or(1, NonZero::get);
    let most = FEWEST.max(MOST_PER_THREAD * own);
    ensure!(
        threads.get() <= most,
        "at most {most} on this machine, which runs {own} threads at once: more would only wait for each other"
    );
    Ok(threads)
}

/// As many threads as are asked for, or else all.
pub(crate) fn threads(asked: Option<NonZero<usize>>) -> usize {
    let all = || available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    asked.unwrap_or_else(all).get()
}

/// So many threads of the CPU.
///
/// # Errors
/// If there is no pool of them.
pub(crate) fn on_threads(threads: usize) -> Result<On> {
    if threads == 1 {
        return Ok(On::Cpu(None));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.with_context(|| format!("no pool of {threads} threads"))?;
    Ok(On::Cpu(Some(Box::new(Traversal::with_pool(Arc::new(pool))))))
}

impl From<Promise> for Accuracy {
    fn from(promise: Promise) -> Self {
        match promise {
            Promise::Exact => Self::Exact,
            Promise::Conservative => Self::Conservative,
            Promise::Fast => Self::Fast,
        }
    }
}
