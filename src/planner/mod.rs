//! Picking the cheapest way to answer, frame by frame: one thread, several, a GPU, or nothing
//! at all where nothing has changed.
//!
//! A [`Planner`] says what there is to choose from: a [`Machine`], perhaps a GPU, and [`Limits`]. A query that
//! is given one, as in [`crate::PairQuery::with_planner`], decides for itself from then on; the answers stay
//! what they were, to the bit. What it decided and why is in its [`Plan`].
//!
//! # How it decides
//! - What was asked last, of models that have not changed, in the same place, is not asked again.
//! - The unknown is begun on the calling thread, for part of the time that it takes to get others to work: most
//!   questions are over by then. Of the others, boxes that are still to be looked at tell how much is left, more or
//!   less, and it is decided whether to go on; again after three times that, and so on. This is also what keeps a
//!   small scene small: until some question is larger than that, no thread is started. Only of a mesh with itself
//!   something is known beforehand, from its size.
//! - From then on the cost of the next frame is known about: box tests and triangle tests, as the paper counts
//!   them (Zhang & Kim 2014, section 2.2). A [`Machine`] predicts how long they take each way. What ways took in
//!   earlier frames corrects that, and another one is taken once it would have saved what changing costs.
//! - How many threads: as many as make up for getting them to work. How fine a front and what it starts from is
//!   the business of [`pfront_cpu`](crate::threads), how deep a pass that of the GPU; both adapt.
//!
//! # Examples
//! ```
//! use pfront::{Model, PairQuery, Pose, planner::{Machine, Planner}};
//! # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
//! # let b = a.clone();
//! let planner = Planner::new(Machine::typical()); // or Machine::measure()
//! let mut query = PairQuery::new().with_planner(planner);
//! for frame in 0..4 {
//!     let a_from_b = Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]);
//!     query.all(&a, &b, &a_from_b)?;
//! }
//! # Ok::<(), pfront::Error>(())
//! ```

mod clock;
mod decider;
mod forecast;
mod history;
mod last;
mod limits;
mod machine;
mod measure;
mod plan;

pub use limits::{Concession, Limits};
pub use machine::{Device, Machine};
pub use plan::{Backend, Plan, Reason};

pub(crate) use decider::Decider;
pub(crate) use history::{Known, Offer, Way};

#[cfg(feature = "gpu")]
use crate::gpu::{self, Gpu};
#[cfg(feature = "threads")]
use crate::threads::{MAX_WORKERS, Traversal};
use crate::{Error, Model};
use std::sync::Arc;

/// Bytes that threads take for a node of a front, for the least front that is worth while, and for each pair
/// before all are gathered, with room to grow.
const NODE: usize = 80;
const FRONT: usize = 2 * 64 * NODE;
const LISTED: usize = 16;
/// A refit takes so many nanoseconds a triangle on one thread, ...
const REFIT: f64 = 30.0;
/// ... and is worth several from so many on.
const LARGE: usize = 3072;

/// To compile the passes for meshes that move, in nanoseconds: that is done once in a process.
#[cfg(feature = "gpu")]
const COMPILE: f64 = 4e8;

/// Large models take so many times as long to bring there, for each triangle, as those that a machine is measured
/// with: 51 to 64 ns instead of 28 to 38 for models of 0.5 to 2.7 million on an H200.
#[cfg(feature = "gpu")]
const LARGE_UPLOAD: f64 = 1.7;

/// What a GPU lacks before it can be asked.
#[cfg(feature = "gpu")]
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Owed {
    /// To be uploaded.
    pub(crate) triangles: usize,
    /// Held in the end.
    pub(crate) bytes: u64,
    /// Whether passes have to be compiled.
    pub(crate) compile: bool,
}

/// What a query may choose from. Cheap to clone; each query that gets one learns for itself.
#[derive(Clone, Debug)]
pub struct Planner(Arc<Choices>);

#[derive(Clone, Debug)]
struct Choices {
    machine: Machine,
    limits: Limits,
    #[cfg(feature = "threads")]
    traversal: Option<Traversal>,
    /// The GPU that the machine was measured with, and how it is best used.
    #[cfg(feature = "gpu")]
    gpu: Option<(Gpu, gpu::Settings)>,
}

impl Planner {
    /// One thread, or those of the machine in the rayon pool of whoever asks. Numbers of the machine that are none
    /// are those of a typical one; a GPU with such is not used.
    #[must_use]
    pub fn new(machine: Machine) -> Self {
        Self(Arc::new(Choices {
            machine: machine.sound(),
            limits: Limits::default(),
            #[cfg(feature = "threads")]
            traversal: None,
            #[cfg(feature = "gpu")]
            gpu: None,
        }))
    }

    /// The same with limits.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        self.with(|choices| choices.limits = limits)
    }

    /// The same on at most so many threads; 1 leaves only the calling one.
    #[must_use]
    pub fn with_threads(self, threads: u32) -> Self {
        self.with(|choices| {
            let machine = &mut choices.machine;
            (machine.speedup, machine.threads) = (machine.speedup_of(threads), threads.max(1));
        })
    }

    /// The same with a pool and settings of your own, and its threads.
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn with_traversal(self, traversal: Traversal) -> Self {
        let planner = self.with_threads(traversal.workers.clamp(1, MAX_WORKERS) as u32);
        planner.with(|choices| choices.traversal = Some(traversal))
    }

    /// The same with a GPU as well. One that the [`Machine`] was not measured with is not used: see
    /// [`Machine::measure_gpu`].
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn with_gpu(self, gpu: &Gpu) -> Self {
        self.with(|choices| {
            let measured = choices.machine.device.as_ref();
            let name = gpu.device().adapter_info().name;
            let is_it = measured.is_some_and(|device| device.name == name);
            choices.gpu = is_it.then(|| (gpu.clone(), gpu.settings()));
        })
    }

    /// What it goes by.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.0.machine
    }

    /// What a frame may take.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.0.limits
    }

    fn with(mut self, change: impl FnOnce(&mut Choices)) -> Self {
        change(Arc::make_mut(&mut self.0));
        self
    }

    /// How many threads may work on a question with so many pairs.
    pub(crate) fn threads(&self, pairs: u64) -> u32 {
        match self.0.limits.memory {
            Some(memory) if FRONT + pairs as usize * LISTED > memory => 1,
            _ => self.0.machine.threads,
        }
    }

    /// Threads for a query.
    #[cfg(feature = "threads")]
    pub(crate) fn traversal(&self, workers: u32) -> Traversal {
        let traversal = self.0.traversal.clone();
        let mut traversal = traversal.unwrap_or_else(|| Traversal::new(workers as usize));
        if let Some(memory) = self.0.limits.memory {
            let max_nodes = &mut traversal.settings.max_nodes;
            *max_nodes = (memory / 2 / NODE).min(*max_nodes);
        }
        traversal
    }

    /// The GPU, if it is the one that was measured, and how much of it may be used.
    #[cfg(feature = "gpu")]
    pub(crate) fn device(&self) -> Option<(Gpu, gpu::Settings)> {
        let (gpu, mut settings) = self.0.gpu.clone()?;
        if let Some(memory) = self.0.limits.memory {
            settings.budget.bytes = settings.budget.bytes.min(memory as u64 / 2);
        }
        let fits = settings.budget.bytes >= gpu::Budget::LEAST.bytes;
        fits.then_some((gpu, settings))
    }

    /// What it takes to bring there what the GPU lacks, in nanoseconds, if a query may hold that much.
    #[cfg(feature = "gpu")]
    pub(crate) fn upload(&self, owed: Owed) -> Option<f64> {
        let device = self.0.machine.device.as_ref()?;
        let fits = self.0.limits.memory.is_none_or(|memory| owed.bytes <= memory as u64);
        let setup = if owed.triangles > 0 { device.setup } else { 0.0 };
        let compile = if owed.compile { COMPILE } else { 0.0 };
        fits.then_some(LARGE_UPLOAD * owed.triangles as f64 * device.upload + setup + compile)
    }

    /// What a refit of so many triangles may take, before there was one, in nanoseconds.
    pub(crate) fn refit(&self, triangles: usize) -> f64 {
        let speedup = if triangles < LARGE { 1.0 } else { self.0.machine.speedup };
        REFIT * triangles as f64 / speedup
    }

    /// Moves the vertices of a model on as many threads as are worth while.
    pub(crate) fn set_positions(
        &self,
        model: &mut Model,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        #[cfg(feature = "threads")]
        if self.0.machine.threads > 1 && model.mesh().triangles().len() >= LARGE {
            return match &self.0.traversal {
                Some(traversal) => {
                    traversal.install(|| model.set_positions_with_threads(positions))
                }
                None => model.set_positions_with_threads(positions),
            };
        }
        model.set_positions(positions)
    }
}
