//! Executors: the threads or the GPU that answer queries.
//!
//! An [`Executor`] has resources: workers in a pool of threads, a GPU with its lists. It is made once and shared by any number of
//! queries, and remembers nothing of them. A query owns its history: the front and the costs of its nodes, the models that the
//! GPU has, the last answer.
//! All executors give the same lists and counts, to the bit. `any` names a true pair if there is one; which of them may differ
//! between executors, and from call to call on threads.
//!
//! - [`Executor::sequential`]: the calling thread.
//! - [`Executor::threads`]: starts on the calling thread and calls others after as much work as calling them costs. The
//!   pending node pairs of its cursor then start their front (Zhang & Kim 2014, section 3), so that nothing is done twice. A
//!   frame like the last one calls them at once.
//! - `Executor::gpu`: a GPU, whether that pays or not; `Executor::behind_gpu` has threads for what no GPU answers.
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
//! others costs, which is measured when the executor is made, its pending node pairs go to them; nothing is done twice. As many are called as would be
//! the fastest for as much again, or for a frame like the last: to call all of 64 can take longer than what they would save. A search for one hit goes on in its order on the calling thread, and
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

// How `SceneQuery::all` is answered on threads; other queries and executors branch off on the way.
// 1. `scene/mod.rs` has `scene/broad.rs` find the bodies whose boxes overlap, and makes a frame (`scene/frame.rs`) of the pairs that
//    have changed (`scene/pairs.rs`).
// 2. `History::ask` in `history.rs` chooses the executor, and calls the frame back with what the query remembers of it.
// 3. `CpuHistory::ask_many` in `cpu.rs` asks on the calling thread; with threads, `threads.rs` hands batches of pairs to a
//    `pfront_cpu::Traversal`, `cpu/src/traversal.rs`, by the names of which it remembers their costs.
// 4. `Traversal::run` in `cpu/src/frame.rs` begins alone and divides what is left: `cpu/src/front.rs` makes and partitions the
//    front, by `core/src/front`, whose costs it remembers, and `cpu/src/workers.rs` has each thread traverse its part.
// 5. The traversal that each thread runs is `core/src/bvtt/traversal.rs`; `cpu/src/output.rs` merges the lists.
// 6. `scene/cache.rs` completes the new hits with those of bodies that have not changed.
//
// On a GPU, steps 3 to 5 are others. Only `Device` of `executor/gpu/` is on this way: the rest is for pairs, batches and tickets.
// 3. `SceneFrame::on_gpu` in `scene/frame.rs` has `scene/device.rs` bring bodies that have changed into a `World` of pfront-gpu; pairs of
//    bodies that no GPU answers about are asked on the CPU, and the lists merged.
// 4. `World::all_each` in `gpu/src/world/mod.rs` submits the pairs of bodies in chunks, mostly one: `pairs.rs` makes a row of each, of
//    which `pose.wgsl` computes how the two are compared, by what `placing.rs` has computed of each body; `arena.rs` has the meshes.
// 5. `gpu/src/runner.rs` answers a chunk in one run, or in parts if its lists are full. `Engine::dispatch` in `gpu/src/engine.rs` has the
//    dispatches of a run, by the shaders in `shaders/wgsl/passes`.
// 6. The way back: `results.rs` copies and reads, `Runner::take` decides on the CPU what the device has not, and `world/answer.rs` makes
//    triangles of ids. Hits are sorted, since ids follow the order of the pairs of bodies.
mod answer;
mod cancel;
mod choice;
mod cpu;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(not(feature = "gpu"))]
#[path = "no_gpu.rs"]
mod gpu;
mod history;
pub(crate) mod impacts;
mod meeting;
mod models;
mod plan;
#[cfg(feature = "threads")]
mod threads;
#[cfg(not(feature = "threads"))]
#[path = "no_threads.rs"]
mod threads;

pub(crate) use answer::{Answer, Named, Verb};
pub(crate) use cancel::{BLOCK, SLICE, check, sort, visit};
pub(crate) use cpu::{CpuHistory, step};
pub(crate) use gpu::*;
pub(crate) use history::{CONTACTS, Frame, History};
pub(crate) use meeting::Meeting;
pub(crate) use plan::CpuPart;
pub use plan::{Backend, Plan, Reason};
pub(crate) use threads::wait_in_pool;

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use threads::Pool;

/// The threads or the GPU that answer queries. See [the module](crate::executor).
///
/// Copies share the number of workers, the settings and the GPU. The threads are those of the rayon pool of whoever asks, unless the executor
/// was made from a pool.
#[derive(Clone, Default)]
pub struct Executor {
    /// The threads; the calling thread alone if there are none.
    pub(crate) pool: Option<Pool>,
    /// The thread that answers tickets of a GPU.
    reader: Option<Arc<Reader>>,
    device: Option<Arc<Device>>,
    /// Ends queries early as soon as it is true.
    cancel: Option<Arc<AtomicBool>>,
}

/// Without what threads and a GPU keep.
impl fmt::Debug for Executor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Executor")
            .field("threads", &self.pool.as_ref().map_or(1, Pool::threads))
            .field("has_gpu", &self.device.is_some())
            .finish_non_exhaustive()
    }
}

impl Executor {
    /// The calling thread.
    #[must_use]
    pub fn sequential() -> Self {
        Self::default()
    }

    /// All threads of the rayon pool of the caller, and the best GPU if there is one that does not compute on the CPU. A GPU
    /// that cannot be used is left out; `Executor::and_gpu` would tell why.
    ///
    /// Opening and measuring a GPU takes about two seconds: make one executor and keep it. Without the feature `gpu` there are only
    /// threads, and without `threads` only the calling one.
    #[must_use]
    pub fn auto() -> Self {
        Self { pool: threads::all(), ..Self::default() }.and_best_gpu()
    }

    /// The same with a flag that ends its queries early: as soon as it is true they return [`Error::Cancelled`](crate::Error)
    /// within some 0.1 ms of traversal, on one thread and on several, and keep nothing of that frame. Nobody waits for what a GPU
    /// is at, and nothing more goes there. A build or a refit of a BVH is not interrupted. Nobody but the caller clears the flag. It
    /// ends nothing if it is cleared before a traversal has seen it; no query returns a part of an answer.
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

    /// The calling thread, which hears the same flag.
    pub(crate) fn alone(&self) -> Self {
        Self { cancel: self.cancel.clone(), ..Self::default() }
    }

    /// The flag of [`Executor::with_cancel`].
    pub(crate) fn cancel_flag(&self) -> Option<&AtomicBool> {
        self.cancel.as_deref()
    }

    /// The GPU, if it answers all questions.
    pub(crate) fn only_device(&self) -> Option<&Arc<Device>> {
        self.device.as_ref().filter(|device| device.choice_line().is_none())
    }

    /// The same with the thread for its tickets. There is none on wasm32, where no thread can wait for a GPU, and for that thread
    /// itself, which would wait for what comes after it.
    pub(crate) fn for_tickets(&self) -> Option<(&Arc<Device>, &Reader)> {
        let (device, reader) = (self.only_device()?, self.reader.as_deref()?);
        let can_wait = cfg!(not(target_arch = "wasm32")) && !reader.is_this_thread();
        can_wait.then_some((device, reader))
    }

    /// The reason for which a CPU answers what no GPU does.
    pub(crate) fn without_gpu(&self) -> Reason {
        if self.device.is_some() { Reason::CpuOnly } else { Reason::NoChoice }
    }

    /// Whether the GPU answers where that pays.
    pub(crate) fn has_choice(&self) -> bool {
        self.device.as_ref().is_some_and(|device| device.choice_line().is_some())
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
}
