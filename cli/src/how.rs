//! Who finds the pairs, and how exactly: the options that all queries share.

use crate::engine::Asked;
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use pfront::Accuracy;
use pfront::threads::Traversal;
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
    #[arg(long, value_name = "N")]
    threads: Option<NonZero<usize>>,
    /// What to run on
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
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
    Cpu,
    Gpu,
}

impl How {
    /// All threads, exactly.
    pub(crate) const DEFAULT: Self =
        Self { accuracy: Promise::Exact, threads: None, backend: Backend::Cpu };

    /// How many threads will work.
    pub(crate) fn threads(&self) -> usize {
        let all = || available_parallelism().unwrap_or(NonZero::<usize>::MIN);
        self.threads.unwrap_or_else(all).get()
    }

    /// # Errors
    /// If there is no such backend, or no pool of as many threads.
    pub(crate) fn asked(&self) -> Result<Asked> {
        if self.backend == Backend::Gpu {
            bail!("this pfront has no GPU backend yet: leave out --backend gpu");
        }
        let traversal = match self.threads() {
            1 => None,
            threads => {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build();
                let pool = pool.with_context(|| format!("no pool of {threads} threads"))?;
                Some(Traversal::with_pool(Arc::new(pool)))
            }
        };
        Ok(Asked { accuracy: self.accuracy.into(), traversal })
    }
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
