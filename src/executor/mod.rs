//! Executors: who answers a query.
//!
//! An [`Executor`] owns resources: a pool of threads, a GPU with its lists. It is made once and shared by any number of
//! queries. A query owns what it remembers from frame to frame: a front, the costs of its nodes, which models the GPU
//! has. Whoever answers, the answer is the same, to the bit.
//!
//! # Which one
//! - [`Executor::sequential`]: the calling thread, and nothing else.
//! - [`Executor::threads`]: starts on the calling thread and calls others after as much work as calling them costs. The
//!   pending node pairs of its cursor then start their front (Zhang & Kim 2014, section 3), so that nothing is done twice:
//!   a frame of unknown cost takes at most twice as long as the better of one thread and several, and a frame like the
//!   last one does not have to find out.
//! - `Executor::gpu`: a GPU, which always answers.
//! - `Executor::and_gpu`: the CPU, and a GPU where that pays; [`Executor::auto`] is all that there is.
//!
//! ```
//! use pfront::{Executor, Model, PairQuery, Pose};
//! # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
//! let executor = Executor::threads(8);
//! let mut query = PairQuery::new().on(&executor);
//! assert_eq!(query.all(&a, &a, &Pose::IDENTITY)?.len(), 1);
//! println!("{}", query.plan().expect("there was a question")); // one thread: ...
//! # Ok::<(), pfront::Error>(())
//! ```
//!
//! # When a GPU pays
//! It has to have the models before it can answer, and nobody knows how many frames will follow. That is the ski rental
//! problem: the query stays on the CPU until the GPU would have saved the price of the upload, and then changes; it changes
//! back when the CPU would have saved what a mistake costs, one frame of the CPU.
//!
//! **Bound.** Let C_f and G_f be what frame f takes on the CPU and on the GPU, and U the upload. As long as predictions
//! hold, n frames that never change sides again take at most twice min(ΣC_f, U + ΣG_f), and one frame. *Proof.* Up to the change the
//! query pays ΣC_f over those frames, which is their ΣG_f plus at most U and one frame's saving. From then on it pays U
//! and ΣG_f: in all at most ΣG_f + 2U and one frame. If it never changes, it pays ΣC_f, of which Σ(C_f − G_f) is at most
//! U. ∎
//!
//! Predictions come from a line that is measured when the GPU is added, G = latency + slope · C, whose slope each change to
//! the GPU corrects for this query.

#[cfg(feature = "gpu")]
mod choice;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod measure;
#[cfg(feature = "gpu")]
mod mirror;
mod plan;
mod run;

#[cfg(feature = "gpu")]
pub(crate) use device::Device;
#[cfg(feature = "gpu")]
pub(crate) use mirror::Mirrors;
pub use plan::{Backend, Plan, Reason};
pub(crate) use run::{Given, Question, Run, Want};

#[cfg(feature = "gpu")]
use crate::gpu::{Gpu, Settings};
#[cfg(feature = "threads")]
use crate::threads::Traversal;
#[cfg(feature = "gpu")]
use std::sync::Arc;

/// Who answers queries: the calling thread, several, a GPU, or whoever is the fastest. See [the module](crate::executor).
///
/// Copies share the pool and the GPU. Queries on one GPU take turns: each waits for the one before.
#[derive(Clone, Debug, Default)]
pub struct Executor {
    /// The threads, of which each query gets a copy for what it remembers; the calling thread alone if there are none.
    #[cfg(feature = "threads")]
    traversal: Option<Box<Traversal>>,
    #[cfg(feature = "gpu")]
    device: Option<Arc<Device>>,
}

impl Executor {
    /// The calling thread.
    #[must_use]
    pub fn sequential() -> Self {
        Self::default()
    }

    /// Several threads: each frame that is worth it is divided into `workers` parts, which run in the rayon pool of whoever
    /// asks. A number beyond what [`Traversal::new`] takes is lowered to that. A pool and settings of your own:
    /// `Executor::from(traversal)`.
    ///
    /// # Examples
    /// ```
    /// use pfront::threads::{Schedule, Settings, Traversal};
    /// use pfront::{Executor, PairQuery};
    /// let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
    /// let executor = Executor::from(Traversal::new(8).with_settings(settings));
    /// let query = PairQuery::new().on(&executor);
    /// ```
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn threads(workers: usize) -> Self {
        Traversal::new(workers).into()
    }

    /// All threads of the rayon pool of the caller, and the best GPU if there is one that does not compute on the CPU. A GPU
    /// that cannot be used is left out.
    ///
    /// Opening and measuring a GPU takes about two seconds: make one executor and keep it.
    #[must_use]
    pub fn auto() -> Self {
        #[cfg(feature = "threads")]
        let own = Self::from(Traversal::default());
        #[cfg(not(feature = "threads"))]
        let own = Self::sequential();
        #[cfg(feature = "gpu")]
        if let Ok(gpu) = Gpu::new()
            && gpu.device().adapter_info().device_type != crate::gpu::wgpu::DeviceType::Cpu
            && let Ok(both) = own.clone().and_gpu(&gpu)
        {
            return both;
        }
        own
    }

    /// A GPU, which answers whatever is asked, exactly whatever the [`Accuracy`](crate::Accuracy) of the query.
    ///
    /// Its lists take [`Settings::budget`] of device memory once for pairs of models, once for models with themselves, and
    /// once for each scene, from the first such question on.
    ///
    /// # Examples
    /// ```no_run
    /// use pfront::gpu::Gpu;
    /// use pfront::{Executor, PairQuery};
    /// let gpu = Gpu::new()?;
    /// let query = PairQuery::new().on(&Executor::gpu(&gpu, gpu.settings()));
    /// # Ok::<(), pfront::gpu::Error>(())
    /// ```
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn gpu(gpu: &Gpu, settings: Settings) -> Self {
        let device = Some(Arc::new(Device::new(gpu, settings, None)));
        Self { device, ..Self::default() }
    }

    /// The same CPU and a GPU, which answers from where it pays on. Measures both, which takes about two seconds.
    ///
    /// # Errors
    /// What the GPU reports while it is measured.
    #[cfg(feature = "gpu")]
    pub fn and_gpu(self, gpu: &Gpu) -> Result<Self, crate::gpu::Error> {
        let line = measure::measure(&self, gpu)?;
        Ok(self.beside(gpu, line))
    }

    /// The same with a GPU that has been measured.
    #[cfg(feature = "gpu")]
    fn beside(self, gpu: &Gpu, line: measure::Line) -> Self {
        let device = Some(Arc::new(Device::new(gpu, gpu.settings(), Some(line))));
        Self { device, ..self }
    }
}

#[cfg(feature = "threads")]
impl From<Traversal> for Executor {
    /// Several threads, with the pool and the settings of `traversal`. What it remembers is forgotten, and so is its deadline:
    /// an answer that ended there would be kept as if it were complete.
    fn from(mut traversal: Traversal) -> Self {
        traversal.forget();
        traversal.deadline = None;
        Self { traversal: Some(Box::new(traversal)), ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::Executor;
    use crate::{Model, PairQuery, SceneQuery, SelfQuery};

    #[test]
    fn executors_and_queries_go_from_thread_to_thread() {
        fn sent<T: Send>() {}
        fn shared<T: Send + Sync>() {}
        shared::<Executor>();
        shared::<Model>();
        sent::<PairQuery>();
        sent::<SelfQuery>();
        sent::<SceneQuery>();
    }

    /// Lavapipe is slower than the CPU that it runs on, so a line that promises everything stands in for measuring.
    #[cfg(feature = "gpu")]
    #[test]
    fn a_gpu_that_promises_to_be_faster_is_asked() {
        use super::measure::Line;
        use super::{Backend, Reason};
        use crate::Pose;
        use crate::gpu::Gpu;
        let gpu = Gpu::new().unwrap();
        let line = Line { latency: 0.0, slope: 0.0, setup: 0.0, upload: 0.0 };
        let executor = Executor::sequential().beside(&gpu, line);
        let ball = pfront_scenes::icosphere(500);
        let ball = Model::new(ball.positions, ball.triangles).unwrap();
        let (mut query, mut truth) = (PairQuery::new().on(&executor), PairQuery::new());
        for (frame, backend) in [Backend::Sequential, Backend::Gpu, Backend::Gpu].iter().enumerate()
        {
            let pose = Pose::from_translation([0.1 + 0.1 * frame as f32, 0.0, 0.0]);
            let pairs = query.all(&ball, &ball, &pose).unwrap();
            assert_eq!(pairs, truth.all(&ball, &ball, &pose).unwrap());
            let plan = query.plan().unwrap();
            assert_eq!(plan.backend, *backend, "{frame}: {plan}");
            assert_eq!(plan.predicted.is_some(), frame > 0);
        }
        assert_eq!(query.plan().unwrap().reason, Reason::Faster);
    }
}
