//! Executors: the threads or the GPU that answer queries.
//!
//! An [`Executor`] owns resources: a pool of threads, a GPU with its lists. It is made once and shared by any number of
//! queries, and remembers nothing of them. A query owns its history: the front and the costs of its nodes, the models that the
//! GPU has, the last answer.
//! All executors give the same lists and counts, to the bit. `any` names a true pair if there is one; which of them may differ
//! between executors, and from call to call on threads.
//!
//! - [`Executor::sequential`]: the calling thread.
//! - [`Executor::threads`]: starts on the calling thread and calls others after as much work as calling them costs. The
//!   pending node pairs of its cursor then start their front (Zhang & Kim 2014, section 3), so that nothing is done twice. A
//!   frame like the last one calls them at once.
//! - `Executor::gpu`: a GPU, which always answers.
//! - `Executor::and_gpu`: the CPU, and a GPU where that pays.
//! - [`Executor::auto`]: all threads, and the GPU if there is one.
//!
//! ```
//! use pfront::{Executor, Model, PairQuery, Pose};
//! # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
//! let executor = Executor::threads(8);
//! let mut query = PairQuery::new().on(&executor);
//! assert_eq!(query.all(&a, &a, Pose::IDENTITY)?.len(), 1);
//! println!("{}", query.plan().expect("there was a question")); // one thread: ...
//! # Ok::<(), pfront::Error>(())
//! ```
//!
//! # When threads pay
//! A frame whose cost is unknown, and any search for one hit, begins on the calling thread. After as much work as calling
//! others costs, which is measured when the executor is made, its pending node pairs go to them; nothing is done twice. A search for one hit goes on in its order on the calling thread, and
//! others take what would come last, so that it takes no longer than alone.
//! `threads::Pool::measured` states the bound.
//!
//! # When a GPU pays
//! A GPU has to have the models before it can answer, and the number of frames to come is unknown: the ski rental problem. A
//! query stays on the CPU until the GPU would have saved the price of a change, which is the upload and one of its frames;
//! it goes back when the CPU would have saved one frame of the CPU. No single frame counts for more than half a price. The
//! prediction for the own side is the last frame; that for the GPU is a line through two questions that were measured,
//! shifted by the first frame there; that for the CPU is its last frame, which is checked after the GPU has taken 8
//! times as long, then 16 times, and so on. Each verb of a query chooses for itself, and other meshes begin anew.
//!
//! **Bound.** Let all frames take C on the CPU and G on the GPU, as predicted, and the upload U. Then n frames take at most
//! 2·min(nC, U + nG), and four frames, and one eighth of the time on the GPU for checks. *Proof.* If C ≤ G, the query
//! stays on the CPU. Else it changes when the savings of k frames, k(C − G) or at least 2 frames, reach U + G.
//! These frames took kC ≤ kG + U + G + C, or 2C; with the first frame, the upload and all others on the GPU that is at most
//! nG + 2U and four frames. It is at most 2nC and four frames as well, since U ≤ k(C − G) or U ≤ 2(C − G). Without a change,
//! nC is less than nG + U and three frames. Check i costs C after at least 2^i · 8C on the GPU. ∎
//!
//! Frames that are not alike have no such bound: the tests of `choice.rs` play frames that shrink, jump, bring new models or
//! are interrupted.

mod answer;
mod cancel;
#[cfg(feature = "gpu")]
mod choice;
mod cpu;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod gathered;
#[cfg(feature = "gpu")]
mod measure;
#[cfg(feature = "gpu")]
mod meshes;
#[cfg(feature = "gpu")]
mod mirror;
mod models;
mod plan;
#[cfg(feature = "gpu")]
mod reader;
mod run;

pub(crate) use answer::{Answer, Verb};
pub(crate) use cancel::{BLOCK, SLICE, check, sort, visit};
pub(crate) use cpu::{CpuHistory, Named, step};
#[cfg(feature = "gpu")]
pub(crate) use device::{Device, Slot, merge_open, read};
#[cfg(feature = "gpu")]
pub(crate) use gathered::Gathered;
#[cfg(feature = "gpu")]
pub(crate) use mirror::Mirrors;
pub(crate) use plan::CpuPart;
pub use plan::{Backend, Plan, Reason};
#[cfg(feature = "gpu")]
pub(crate) use reader::{Reader, Seat, Work};
pub(crate) use run::{Frame, Run};

#[cfg(feature = "gpu")]
use crate::environment::with_default;
#[cfg(feature = "gpu")]
use crate::gpu::{Gpu, GpuError, GpuSettings};
#[cfg(feature = "threads")]
use crate::threads::{Pool, Schedule};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The threads or the GPU that answer queries. See [the module](crate::executor).
///
/// Copies share the pool and the GPU.
#[derive(Clone, Default)]
pub struct Executor {
    /// The threads; the calling thread alone if there are none.
    #[cfg(feature = "threads")]
    pub(crate) pool: Option<Pool>,
    /// The thread that answers tickets of a GPU.
    #[cfg(feature = "gpu")]
    reader: Option<Arc<Reader>>,
    #[cfg(feature = "gpu")]
    device: Option<Arc<Device>>,
    /// Ends queries early as soon as it is true.
    cancel: Option<Arc<AtomicBool>>,
}

/// Without what threads and a GPU keep.
impl fmt::Debug for Executor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = f.debug_struct("Executor");
        #[cfg(feature = "threads")]
        text.field("workers", &self.pool.as_ref().map_or(1, |pool| pool.workers));
        #[cfg(feature = "gpu")]
        text.field("has_gpu", &self.device.is_some());
        text.finish_non_exhaustive()
    }
}

impl Executor {
    /// The calling thread.
    #[must_use]
    pub fn sequential() -> Self {
        Self::default()
    }

    /// Several threads: each frame that is worth it is divided into `workers` parts, which run in the rayon pool of whoever
    /// asks. A number beyond [`MAX_WORKERS`](crate::threads::MAX_WORKERS) is lowered to that. A rayon pool and settings
    /// of your own: `Executor::from(pool)`.
    ///
    /// # Examples
    /// ```
    /// use pfront::threads::{Pool, Schedule, Settings};
    /// use pfront::{Executor, PairQuery};
    /// let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
    /// let executor = Executor::from(Pool::new(8).with_settings(settings));
    /// let query = PairQuery::new().on(&executor);
    /// ```
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn threads(workers: usize) -> Self {
        Pool::new(workers).into()
    }

    /// All threads of the rayon pool of the caller, and the best GPU if there is one that does not compute on the CPU. A GPU
    /// that cannot be used is left out; `Executor::and_gpu` would tell why.
    ///
    /// Opening and measuring a GPU takes about two seconds: make one executor and keep it.
    #[must_use]
    pub fn auto() -> Self {
        #[cfg(feature = "threads")]
        let own = Self::from(Pool::default());
        #[cfg(not(feature = "threads"))]
        let own = Self::sequential();
        #[cfg(feature = "gpu")]
        if let Ok(gpu) = with_default(Gpu::new)
            && gpu.device().adapter_info().device_type != crate::gpu::wgpu::DeviceType::Cpu
            && let Ok(both) = own.clone().and_gpu(&gpu, gpu.settings())
        {
            return both;
        }
        own
    }

    /// A GPU, which answers all questions. Where it fails, the verb returns its error.
    ///
    /// A query keeps the models of its last question there, and shares them with others that ask about the same. Models that no
    /// query or ticket holds any more stay there within [`GpuSettings::mesh_bytes`], the least recently used going first; so
    /// the next question about them uploads nothing. All are given back when the executor goes. A mesh that
    /// deforms has a tree of its own there, which is built anew as soon as the box tests beyond those of a new tree have taken as long as
    /// a build does.
    ///
    /// Lists take [`GpuSettings::budget`] of device memory each: as many as questions are asked at once by threads that wait
    /// for them, one for each scene, and for tickets at most two for batches of pairs and four for others, however many
    /// are in flight (see [`crate::batch`]).
    ///
    /// # Examples
    /// ```no_run
    /// use pfront::gpu::Gpu;
    /// use pfront::{Executor, PairQuery};
    /// let gpu = Gpu::new()?;
    /// let query = PairQuery::new().on(&Executor::gpu(&gpu, gpu.settings()));
    /// # Ok::<(), pfront::gpu::GpuError>(())
    /// ```
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn gpu(gpu: &Gpu, settings: GpuSettings) -> Self {
        Self {
            #[cfg(feature = "threads")]
            pool: None,
            reader: Some(Arc::new(Reader::new(gpu))),
            device: Some(Arc::new(Device::new(gpu, settings, None))),
            cancel: None,
        }
    }

    /// The same CPU and a GPU, which answers where that pays. Measures both, which takes about two seconds.
    ///
    /// After an error of the GPU, the CPU answers the next question of that query, and after each further error twice as many,
    /// at most 1,024; then the GPU is asked again. After the loss of the device it is not. [`Plan::failure`] tells why.
    ///
    /// # Errors
    /// As [`crate::PairQuery::all`] on a GPU, while it is measured.
    #[cfg(feature = "gpu")]
    pub fn and_gpu(self, gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
        let line = with_default(|| measure::measure(&self, gpu))?;
        Ok(self.with_line(gpu, settings, line))
    }

    /// The same with a flag that ends its queries early: as soon as it is true they return [`Error::Cancelled`](crate::Error)
    /// within some 0.1 ms of traversal, on one thread and on several, and keep nothing of that frame. What is not interrupted: a
    /// BVH that is built or refitted, and a GPU. Batches have tickets for that. Nobody but the caller clears the flag. One
    /// that is cleared before a traversal has seen it ends nothing; no query returns a part of an answer.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Error, Executor, Model, PairQuery, Pose};
    /// use std::sync::{Arc, atomic::{AtomicBool, Ordering}};
    /// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let flag = Arc::new(AtomicBool::new(true)); // as another thread would set it
    /// let mut query = PairQuery::new().on(&Executor::threads(2).with_cancel(flag.clone()));
    /// assert_eq!(query.all(&a, &a, Pose::IDENTITY), Err(Error::Cancelled));
    /// flag.store(false, Ordering::Relaxed);
    /// assert_eq!(query.count(&a, &a, Pose::IDENTITY)?, 1);
    /// # Ok::<(), Error>(())
    /// ```
    #[must_use]
    pub fn with_cancel(mut self, flag: Arc<AtomicBool>) -> Self {
        self.cancel = Some(flag);
        self
    }

    /// The flag of [`Executor::with_cancel`].
    pub(crate) fn cancel_flag(&self) -> Option<&AtomicBool> {
        self.cancel.as_deref()
    }

    /// The GPU, if it answers all questions, and the thread for its tickets.
    #[cfg(feature = "gpu")]
    pub(crate) fn only_device(&self) -> Option<(&Arc<Device>, &Reader)> {
        let device = self.device.as_ref().filter(|device| device.line.is_none())?;
        Some((device, self.reader.as_deref()?))
    }

    /// Whether the GPU answers where that pays.
    pub(crate) fn has_choice(&self) -> bool {
        #[cfg(feature = "gpu")]
        return self.device.as_ref().is_some_and(|device| device.line.is_some());
        #[cfg(not(feature = "gpu"))]
        false
    }

    #[cfg(feature = "gpu")]
    fn with_line(mut self, gpu: &Gpu, settings: GpuSettings, line: measure::Line) -> Self {
        self.device = Some(Arc::new(Device::new(gpu, settings, Some(line))));
        self
    }
}

#[cfg(feature = "threads")]
impl From<Pool> for Executor {
    /// Several threads. What it takes to call others is measured, except under [`Schedule::Static`], whose counts are to be the
    /// same on every machine.
    fn from(pool: Pool) -> Self {
        let is_static = pool.settings.schedule == Schedule::Static;
        Self {
            pool: Some(if is_static { pool } else { pool.measured() }),
            #[cfg(feature = "gpu")]
            reader: None,
            #[cfg(feature = "gpu")]
            device: None,
            cancel: None,
        }
    }
}

#[cfg(test)]
mod tests {
    #[cfg(feature = "gpu")]
    use super::Backend;
    use super::Executor;
    #[cfg(feature = "gpu")]
    use crate::Pose;
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

    /// A CPU and a GPU that promises to be faster. Lavapipe is slower than the CPU that it runs on, so that queries change
    /// to it and back.
    #[cfg(feature = "gpu")]
    fn promising() -> Executor {
        let gpu = crate::gpu::Gpu::new().unwrap();
        let line = super::measure::Line { latency: 0.0, slope: 0.0, setup: 0.0, upload: 0.0 };
        Executor::sequential().with_line(&gpu, gpu.settings(), line)
    }

    #[cfg(feature = "gpu")]
    fn ball() -> Model {
        let ball = pfront_testkit::scenes::icosphere(500);
        Model::new(ball.positions, ball.triangles).unwrap()
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn pairs_are_the_same_while_the_query_changes_sides() {
        let (ball, mut query, mut truth) =
            (ball(), PairQuery::new().on(&promising()), PairQuery::new());
        let mut seen = Vec::new();
        for frame in 0..60 {
            let pose = Pose::from_translation([0.1 + 0.02 * frame as f32, 0.0, 0.0]);
            assert_eq!(
                query.all(&ball, &ball, pose).unwrap(),
                truth.all(&ball, &ball, pose).unwrap()
            );
            seen.push(query.plan().unwrap().backend);
        }
        assert!(
            [Backend::Sequential, Backend::Gpu].iter().all(|one| seen.contains(one)),
            "{seen:?}"
        );
    }

    /// A GPU does not pose coordinates of more than half the range of f32.
    #[cfg(feature = "gpu")]
    #[test]
    fn a_gpu_that_failed_is_asked_again() {
        use super::Reason;
        let ball = pfront_testkit::scenes::icosphere(80);
        let most = ball.positions.iter().flatten().fold(0.0_f32, |most, x| most.max(x.abs()));
        let scaled = ball.positions.iter().map(|p| p.map(|x| x / most * 2e38)).collect();
        let ball = Model::new(scaled, ball.triangles).unwrap();
        let mut query = PairQuery::new().on(&promising());
        let mut ask = |scale: f32| {
            query.forget();
            let rows = [0, 1, 2].map(|k| [0, 1, 2, 3].map(|i| if i == k { scale } else { 0.0 }));
            query.count(&ball, &ball, Pose::new(rows)).unwrap();
            let plan = query.plan().unwrap();
            (plan.backend, plan.reason, plan.failure.is_some())
        };
        // Some frames on the CPU come first.
        let failed = (Backend::Sequential, Reason::GpuFailed, true);
        assert!((0..40).any(|_| ask(0.1) == failed));
        assert_eq!(ask(1.0), failed);
        let (backend, _, has_failed) = ask(1.0);
        assert_eq!((backend, has_failed), (Backend::Gpu, false));
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn deforming_meshes_and_scenes_are_the_same_while_queries_change_sides() {
        let executor = promising();
        let (mut own, mut other, start) = (ball(), ball(), ball());
        let (mut query, mut truth) = (SelfQuery::new().on(&executor), SelfQuery::new());
        let scenes = || [SceneQuery::new().on(&executor), SceneQuery::new()];
        let mut scenes = scenes();
        let shared = std::sync::Arc::new(ball());
        let bodies = scenes.each_mut().map(|scene| {
            [0.0, 0.7, 1.4]
                .map(|x| scene.add(shared.clone(), Pose::from_translation([x, 0.0, 0.0])).unwrap())
        });
        let mut seen = Vec::new();
        for frame in 0..40 {
            let fold = 0.02 * frame as f32;
            let folded: Vec<_> = start
                .mesh()
                .shadow()
                .iter()
                .map(|&[x, y, z]| [x, y, z * (1.0 - 3.0 * fold * x)])
                .collect();
            query.set_positions(&mut own, &folded).unwrap();
            truth.set_positions(&mut other, &folded).unwrap();
            assert_eq!(query.all(&own).unwrap(), truth.all(&other).unwrap(), "{frame}");
            seen.push(query.plan().unwrap().backend);
            for (scene, bodies) in scenes.iter_mut().zip(&bodies) {
                scene.set_pose(bodies[1], Pose::from_translation([0.7, fold, 0.0])).unwrap();
                if frame % 7 == 3 {
                    scene.set_positions(bodies[2], &folded).unwrap();
                }
                if frame % 11 == 5 {
                    scene
                        .add(shared.clone(), Pose::from_translation([0.3, 0.1 * fold, 0.5]))
                        .unwrap();
                }
            }
            let [scene, truth] = &mut scenes;
            assert_eq!(scene.all().unwrap(), truth.all().unwrap(), "{frame}");
            seen.push(scene.plan().unwrap().backend);
        }
        for parity in 0..2 {
            let of = |backend| seen.iter().skip(parity).step_by(2).any(|&one| one == backend);
            assert!(of(Backend::Sequential) && of(Backend::Gpu), "{seen:?}");
        }
    }
}
