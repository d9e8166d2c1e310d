//! The players: every fixed plan that the machine has, and the executor that chooses.

use super::lacks_memory;
use super::race::play;
use super::recipe::{Scale, samples};
use anyhow::Result;
use pfront::Executor;
#[cfg(feature = "gpu")]
use pfront::gpu::Gpu;
use pfront::threads::Traversal;
use rayon::ThreadPoolBuilder;
use std::sync::Arc;

/// All who play a case.
pub struct Field {
    /// Plans that never change; the first is one thread.
    pub fixed: Vec<Lane>,
    /// The one that chooses.
    pub chooser: Executor,
}

/// A fixed plan.
pub struct Lane {
    /// What tables call it.
    pub name: String,
    /// Who answers.
    pub executor: Executor,
}

impl Field {
    /// One thread; 2, 4, 8 … of them, and all `threads`, of which the last also chooses.
    ///
    /// # Errors
    /// If there is no pool of as many threads.
    pub fn new(threads: usize) -> Result<Self> {
        let mut chooser = Executor::sequential();
        let mut fixed = vec![Lane { name: "sequential".to_owned(), executor: chooser.clone() }];
        let powers = (1..).map(|i| 1 << i).take_while(|&p| p < threads);
        for p in powers.chain((threads > 1).then_some(threads)) {
            let pool = Arc::new(ThreadPoolBuilder::new().num_threads(p).build()?);
            chooser = Executor::from(Traversal::with_pool(pool));
            fixed.push(Lane { name: format!("{p} threads"), executor: chooser.clone() });
        }
        Ok(Self { fixed, chooser })
    }

    /// Adds a GPU to the fixed plans, and to the choice.
    ///
    /// # Errors
    /// If the GPU fails while it is measured.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(mut self, gpu: &Gpu) -> Result<Self> {
        let executor = Executor::gpu(gpu, gpu.settings());
        self.fixed.push(Lane { name: "GPU".to_owned(), executor });
        self.chooser = self.chooser.and_gpu(gpu, gpu.settings())?;
        Ok(self)
    }

    /// Lets everyone play something of each kind, so that threads are up and shaders compiled before anything is
    /// timed.
    ///
    /// # Errors
    /// As [`super::race`].
    pub fn warm_up(&self) -> Result<()> {
        for recipe in samples() {
            let case = recipe.build(&Scale::QUICK)?;
            for executor in self.fixed.iter().map(|lane| &lane.executor).chain([&self.chooser]) {
                match play(&case, executor) {
                    Err(error) if lacks_memory(&error) => continue,
                    played => played?,
                };
            }
        }
        Ok(())
    }
}
