//! Batches: many questions in one submission, answered while the caller does something else.
//!
//! A [`Batch`] holds questions: two models and a pose, or one model and itself. [`Batch::any`], [`Batch::count`] and
//! [`Batch::all`] submit all of them to an [`Executor`] and return a [`Ticket`] at once; the ticket is read later, by
//! polling, with a timeout, or as a future. Lists and counts are those of [`crate::PairQuery`] and
//! [`crate::SelfQuery`], to the bit; `any` is some true pair.
//!
//! ```
//! use pfront::{Batch, Executor, Model, Pose};
//! use std::sync::Arc;
//! # let triangle = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
//! let model = Arc::new(Model::new(triangle, vec![[0, 1, 2]])?);
//! let mut batch = Batch::new();
//! for i in 0..10 {
//!     batch.pair(&model, &model, Pose::from_translation([0.5 * i as f32, 0.0, 0.0]))?;
//! }
//! let mut ticket = batch.any(&Executor::auto())?;
//! // ... the rest of the frame ...
//! let found = match ticket.try_read()? {
//!     Some(found) => found,
//!     None => ticket.read()?,
//! };
//! assert_eq!(found.iter().filter(|hit| hit.is_some()).count(), 5);
//! # Ok::<(), pfront::Error>(())
//! ```
//!
//! # Who works, and when
//! - **One thread** ([`Executor::sequential`]): nobody else can, so whoever polls does. Each [`Ticket::is_ready`],
//!   [`Ticket::try_read`] and poll of the future does about 4096 tests, some 0.1 ms; [`Ticket::wait`] and [`Ticket::read`]
//!   go on until they are done or out of time. A future wakes itself between slices.
//! - **Threads**: the pool of the executor. If there are at least as many questions as threads, each thread takes the next
//!   few, and a question is answered by one thread, however large; otherwise all threads divide one question after the
//!   other. Tickets are answered in about the order of submission.
//! - **A GPU**: the call uploads models that are not there and submits the first part, so that its place in the queue is before everything
//!   submitted later; what cannot be done of later parts, reading tells. Pairs of models in f32 are one submission up to 65,535, and fewer of meshes that have more than 2³¹
//!   triangles or nodes in all: the next are gathered and submitted while the device works on the last, by another thread, in lists and with
//!   copies of the meshes of their own. A model with itself is a submission of its
//!   own, and so is a pair of which a model or the pose is in f64: the device answers by shadows, and what it leaves open is decided
//!   on the CPU. A pair within a distance is a submission of its own, too. A model in f64 with itself is asked on the CPU, and so is
//!   a model with itself within a distance. [`Ticket::plan`] tells who answers.
//!
//!   One thread of the executor reads all tickets, in the order of submission, and decides what is left to the CPU. It polls, as wgpu
//!   calls back only if somebody does, so a ticket needs no poll of the caller's and a future no runtime. Two submissions are
//!   in flight at a time, each with lists of its own ([`Budget`](crate::gpu::Budget)); whatever is more waits for its turn, and is
//!   submitted as soon as one of them is read. Two tickets of one question each keep their lists until they are dropped, for
//!   [`Ticket::hits_buffer`]. So tickets take at most six times the budget, however many there are. The thread ends when
//!   the executor and all tickets have gone, and when the process exits, which waits for what is in flight for one second at most.
//! - **A CPU and a GPU** ([`Executor::and_gpu`], [`Executor::auto`]): the CPU. A question of a batch has no earlier
//!   frame from which its cost could be predicted, so that it never goes to the GPU; [`Executor::gpu`] takes it there.
//!
//! On wasm32, where no thread can wait for a GPU, whoever polls works instead.

mod cpu;
mod found;
#[cfg(feature = "gpu")]
mod gpu;
mod job;
#[cfg(feature = "threads")]
mod pool;

pub use found::PairLists;

use crate::environment::with_default;
use crate::executor::{Backend, Reason, Verb};
use crate::subject::Subject;
use crate::ticket::Planned;
use crate::{Adjacency, AnyPose, Distance, Error, Executor, Gap, Model, Ticket, TrianglePair};
use found::Found;
use job::{Job, Nearest};
use std::fmt;
use std::sync::Arc;

/// Questions for one submission. See [the module](crate::batch).
///
/// It can be submitted again, with another verb or to another executor, and added to while tickets are in flight. Keep it
/// from frame to frame, by [`Batch::clear`], for its memory.
///
/// # Examples
/// ```
/// use pfront::{Adjacency, Batch, Executor, Model, Pose};
/// use std::sync::Arc;
/// # let triangle = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let model = Arc::new(Model::new(triangle, vec![[0, 1, 2]])?);
/// let mut batch = Batch::new();
/// batch.pair(&model, &model, Pose::IDENTITY)?;
/// batch.itself(&model, Adjacency::default());
/// assert_eq!(batch.count(&Executor::threads(4))?.read()?, [1, 0]);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Default)]
pub struct Batch {
    within: Distance,
    job: Job,
}

impl Batch {
    /// A batch without questions.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a question about two models, the second in the pose `a_from_b`. Answers have the order of questions.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose is not finite or takes `b` out of range; nothing is added then.
    ///
    /// # Complexity
    /// O(1), and a refit of models whose positions were set by [`Model::set_positions_unfitted`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Error, Model, Pose};
    /// # use std::sync::Arc;
    /// let model = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
    /// let mut batch = Batch::new();
    /// batch.pair(&model, &model, Pose::IDENTITY)?;
    /// let refused = batch.pair(&model, &model, Pose::from_translation([f32::NAN, 0.0, 0.0]));
    /// assert!(matches!(refused, Err(Error::Pose(_))));
    /// assert_eq!(batch.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn pair(
        &mut self,
        a: &Arc<Model>,
        b: &Arc<Model>,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<(), Error> {
        let a_from_b = a_from_b.into();
        with_default(|| a_from_b.check(b.bvh()))?;
        let models = [a, b].map(Arc::clone);
        self.add(Subject::Pair { models, a_from_b, within: self.within });
        Ok(())
    }

    /// Adds a question about a model and itself.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Adjacency, Batch, Model};
    /// # use std::sync::Arc;
    /// let cloth = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
    /// let mut batch = Batch::new();
    /// batch.itself(&cloth, Adjacency::default());
    /// assert_eq!(batch.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn itself(&mut self, model: &Arc<Model>, adjacency: Adjacency) {
        let models = [model.clone()];
        self.add(Subject::Itself { models, adjacency, within: self.within });
    }

    /// Questions that are added from now on ask for pairs at most `distance` apart, as [`PairQuery::within`](crate::PairQuery::within) says.
    ///
    /// # Errors
    /// [`Error::Distance`] if the distance is NaN, infinite or negative.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let triangle = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    /// # let part = Arc::new(Model::new(triangle, vec![[0, 1, 2]])?);
    /// let (mut batch, above) = (Batch::new(), Pose::from_translation([0.0, 0.0, 0.5]));
    /// batch.pair(&part, &part, above)?;
    /// batch.within(0.5)?;
    /// batch.pair(&part, &part, above)?;
    /// assert_eq!(batch.count(&Executor::sequential())?.read()?, [0, 1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn within(&mut self, distance: f32) -> Result<(), Error> {
        self.within = Distance::new(distance)?;
        Ok(())
    }

    /// The number of questions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.job.questions.len()
    }

    /// Whether there are no questions.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.job.questions.is_empty()
    }

    /// Removes all questions. Tickets in flight keep theirs.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let model = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
    /// let (executor, mut batch) = (Executor::threads(4), Batch::new());
    /// for frame in 0..3 {
    ///     batch.clear();
    ///     batch.pair(&model, &model, Pose::from_translation([frame as f32, 0.0, 0.0]))?;
    ///     let ticket = batch.any(&executor)?;
    ///     // ...
    ///     assert_eq!(ticket.read()?[0].is_some(), frame == 0);
    /// }
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn clear(&mut self) {
        match Arc::get_mut(&mut self.job.questions) {
            Some(questions) => questions.clear(),
            None => self.job.questions = Arc::default(),
        }
    }

    /// Submits all questions, each for some pair that meets, if any does.
    ///
    /// # Errors
    /// `Error::Gpu` if a GPU fails that is to answer everything. On a CPU there is none.
    ///
    /// # Complexity
    /// O(1) on a CPU; on a GPU, the upload of models that are not there.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose, TrianglePair};
    /// # use std::sync::Arc;
    /// # let model = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&model, &model, Pose::IDENTITY)?;
    /// let ticket = batch.any(&Executor::sequential())?;
    /// assert_eq!(ticket.read()?, [Some(TrianglePair { a: 0, b: 0 })]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn any(&mut self, executor: &Executor) -> Result<Ticket<Vec<Option<TrianglePair>>>, Error> {
        self.submit(executor, Verb::Any, Found::into_first)
    }

    /// Submits all questions, each for the number of pairs that meet.
    ///
    /// # Errors
    /// As [`Batch::any`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let tile = Arc::new(Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&tile, &tile, Pose::IDENTITY)?;
    /// assert_eq!(batch.count(&Executor::sequential())?.read()?, [1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn count(&mut self, executor: &Executor) -> Result<Ticket<Vec<u64>>, Error> {
        self.submit(executor, Verb::Count, Found::into_counts)
    }

    /// Submits all questions, each for all pairs that meet, sorted.
    ///
    /// # Errors
    /// As [`Batch::any`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose, TrianglePair};
    /// # use std::sync::Arc;
    /// # let model = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&model, &model, Pose::IDENTITY)?;
    /// let lists = batch.all(&Executor::sequential())?.read()?;
    /// assert_eq!(lists[0], [TrianglePair { a: 0, b: 0 }]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn all(&mut self, executor: &Executor) -> Result<Ticket<PairLists>, Error> {
        self.submit(executor, Verb::All, PairLists::from)
    }

    /// Submits all questions, each for the smallest distance of its models, as [`PairQuery::distance`](crate::PairQuery::distance)
    /// tells it: what a planner asks of many poses. A thread tries the pair first that was nearest in its question before. CPUs answer,
    /// whatever the executor.
    ///
    /// # Errors
    /// [`Error::NotAPair`] if a question is about a model and itself.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let triangle = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    /// # let part = Arc::new(Model::new(triangle, vec![[0, 1, 2]])?);
    /// let mut batch = Batch::new();
    /// for z in [0.0, 0.5, 2.0] {
    ///     batch.pair(&part, &part, Pose::from_translation([0.0, 0.0, z]))?;
    /// }
    /// let gaps = batch.distance(&Executor::sequential())?.read()?;
    /// assert!(gaps[0].is_some_and(|gap| gap.interval == [0.0; 2]));
    /// assert!(gaps[1].is_some_and(|gap| gap.interval[0] <= 0.5 && 0.5 <= gap.interval[1]));
    /// let near = batch.distance_below(&Executor::sequential(), 0.5)?.read()?;
    /// assert_eq!(near.iter().flatten().count(), 2);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn distance(&mut self, executor: &Executor) -> Result<Ticket<Vec<Option<Gap>>>, Error> {
        self.submit_nearest(executor, None)
    }

    /// [`Batch::distance`] of those questions in which it is at most `limit`, exactly; the others are answered sooner.
    ///
    /// # Errors
    /// As [`Batch::distance`]; [`Error::Distance`] if the limit is NaN, infinite or negative.
    pub fn distance_below(
        &mut self,
        executor: &Executor,
        limit: f32,
    ) -> Result<Ticket<Vec<Option<Gap>>>, Error> {
        self.submit_nearest(executor, Some(Distance::new(limit)?))
    }

    fn submit_nearest(
        &mut self,
        executor: &Executor,
        at_most: Option<Distance>,
    ) -> Result<Ticket<Vec<Option<Gap>>>, Error> {
        let is_itself = |subject: &Subject<_>| matches!(subject, Subject::Itself { .. });
        if let Some(question) = self.job.questions.iter().position(is_itself) {
            return Err(Error::NotAPair { question });
        }
        let job = Job { nearest: Some(Nearest { at_most }), ..self.job.clone() };
        Ok(on_cpu(executor, job, executor.without_gpu(), Found::into_gaps))
    }

    fn add(&mut self, question: Subject<Arc<Model>>) {
        Arc::make_mut(&mut self.job.questions).push(question);
    }

    fn submit<T: Send + 'static>(
        &mut self,
        executor: &Executor,
        verb: Verb,
        answer: fn(Found) -> T,
    ) -> Result<Ticket<T>, Error> {
        let job = Job { verb, ..self.job.clone() };
        let reason = if executor.has_choice() { Reason::Unknown } else { Reason::NoChoice };
        #[cfg(feature = "gpu")]
        if let Some((device, reader)) = executor.for_tickets() {
            let mut planned = planned(&job, Backend::Gpu, reason);
            let numbered = job.questions.iter().enumerate();
            let on_cpu = numbered.filter(|(_, question)| question.is_for_cpu());
            planned.on_cpu.extend(on_cpu.map(|(number, _)| number));
            let (outcome, seat) = with_default(|| gpu::submit(device, reader, job, answer))?;
            let mut ticket = Ticket::new(outcome, planned);
            ticket.seat = seat;
            return Ok(ticket);
        }
        Ok(on_cpu(executor, job, reason, answer))
    }
}

fn planned(job: &Job, backend: Backend, reason: Reason) -> Planned {
    Planned { questions: job.questions.len(), backend, reason, on_cpu: Vec::new() }
}

/// Submits to the CPU of an executor.
#[cfg_attr(not(feature = "threads"), expect(unused_variables, reason = "there is one thread"))]
fn on_cpu<T: Send + 'static>(
    executor: &Executor,
    job: Job,
    reason: Reason,
    answer: fn(Found) -> T,
) -> Ticket<T> {
    #[cfg(feature = "threads")]
    if let Some(pool) = &executor.pool {
        let planned = planned(&job, Backend::Threads, reason);
        return Ticket::new(pool::submit(executor, pool, job, answer), planned);
    }
    let planned = planned(&job, Backend::Sequential, reason);
    let mut steps = cpu::Steps::new(job);
    let step = move || Ok(steps.step()?.then(|| answer(std::mem::take(&mut steps.found))));
    Ticket::in_steps(Box::new(step), planned)
}

/// Without the meshes.
impl fmt::Debug for Batch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Batch").field("len", &self.len()).finish_non_exhaustive()
    }
}
