//! Who takes part: every fixed plan that the machine has, and who plans.

use super::RegretError;
use super::race::play;
use super::recipe::{Scale, samples};
use crate::engine::On;
#[cfg(feature = "gpu")]
use crate::engine::OnGpu;
#[cfg(feature = "gpu")]
use pfront::gpu::Gpu;
use pfront::planner::Planner;
use pfront::threads::Traversal;
use rayon::ThreadPoolBuilder;
use std::sync::Arc;

/// All who play a case.
pub struct Field {
    /// Plans that never change; the first is one thread.
    pub fixed: Vec<Lane>,
    /// Who chooses.
    pub planner: Planner,
}

/// A fixed plan.
pub struct Lane {
    /// What tables call it.
    pub name: String,
    /// Who answers.
    pub on: On,
}

impl Field {
    /// One thread; 2, 4, 8 … of them, and all `threads`; and who plans.
    ///
    /// # Errors
    /// If there is no pool of as many threads.
    pub fn new(threads: usize, planner: Planner) -> Result<Self, RegretError> {
        let mut fixed = vec![Lane { name: "sequential".to_owned(), on: On::Cpu(None) }];
        let powers = (1..).map(|i| 1 << i).take_while(|&p| p < threads);
        for p in powers.chain((threads > 1).then_some(threads)) {
            let pool = Arc::new(ThreadPoolBuilder::new().num_threads(p).build()?);
            let on = On::Cpu(Some(Box::new(Traversal::with_pool(pool))));
            fixed.push(Lane { name: format!("{p} threads"), on });
        }
        Ok(Self { fixed, planner })
    }

    /// Adds a GPU to the fixed plans.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn with_gpu(mut self, gpu: &Gpu) -> Self {
        self.fixed.push(Lane { name: "GPU".to_owned(), on: On::Gpu(OnGpu::new(gpu.clone())) });
        self
    }

    /// Whoever the planner picks.
    #[must_use]
    pub fn chosen(&self) -> On {
        On::Planner(Box::new(self.planner.clone()))
    }

    /// Lets everyone play something of each kind, so that threads are up and shaders compiled before anything is
    /// timed.
    ///
    /// # Errors
    /// As [`super::race`].
    pub fn warm_up(&self) -> Result<(), RegretError> {
        for recipe in samples() {
            let case = recipe.build(&Scale::QUICK)?;
            for on in self.fixed.iter().map(|lane| &lane.on).chain([&self.chosen()]) {
                match play(&case, on) {
                    Err(error) if error.is_want_of_means() => continue,
                    played => played?,
                };
            }
        }
        Ok(())
    }
}
