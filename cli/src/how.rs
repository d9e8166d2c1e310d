//! Who finds the pairs, and how exactly: the options that all queries share.

use crate::gpus::Gpus;
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use pfront::gpu::Gpu;
use pfront::threads::Traversal;
use pfront::{Accuracy, Adjacency, Executor};
use pfront_study::engine::Asked;
use rayon::ThreadPoolBuilder;
use std::num::NonZero;
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
    /// The threads, and a GPU if there is one where it pays; standard error says who it was, and why
    Auto,
}

impl How {
    /// All threads, exactly.
    pub(crate) const DEFAULT: Self =
        Self { accuracy: Promise::Exact, threads: None, backend: Backend::Cpu };

    /// How many threads will work.
    pub(crate) fn threads(&self) -> usize {
        number(self.threads)
    }

    /// What has to answer.
    ///
    /// # Errors
    /// If there is no adapter, none that could do it, or no pool of as many threads.
    pub(crate) fn asked(&self) -> Result<Asked> {
        let executor = match self.backend {
            Backend::Cpu => threads(self.threads())?,
            Backend::Gpu => self.gpu()?,
            Backend::Auto => {
                let cpu = threads(self.threads())?;
                match Gpus::Auto.open()? {
                    Some(gpu) => cpu.and_gpu(&gpu, gpu.settings())?,
                    None => cpu,
                }
            }
        };
        let accuracy = self.accuracy.into();
        Ok(Asked { accuracy, adjacency: Adjacency::default(), ..executor.into() })
    }

    /// Whether who answers is worth telling: there was a choice.
    pub(crate) fn is_auto(&self) -> bool {
        self.backend == Backend::Auto
    }

    fn gpu(&self) -> Result<Executor> {
        ensure!(
            self.accuracy == Promise::Exact,
            "every answer of a GPU is exact: leave out --accuracy, or --backend"
        );
        let gpu = Gpu::new()?;
        Ok(Executor::gpu(&gpu, gpu.settings()))
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
pub(crate) fn number(asked: Option<NonZero<usize>>) -> usize {
    let all = || available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    asked.unwrap_or_else(all).get()
}

/// So many threads of the CPU.
///
/// # Errors
/// If there is no pool of them.
pub(crate) fn threads(threads: usize) -> Result<Executor> {
    if threads == 1 {
        return Ok(Executor::sequential());
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.with_context(|| format!("no pool of {threads} threads"))?;
    Ok(Executor::from(Traversal::with_pool(Arc::new(pool))))
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
