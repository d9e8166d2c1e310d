//! Tickets: answers that are read later.

mod outcome;
#[cfg(feature = "gpu")]
mod shown;
mod submit;

pub(crate) use outcome::Outcome;
#[cfg(feature = "gpu")]
pub(crate) use shown::Shown;

use crate::Error;
use crate::executor::{Backend, Plan, Reason, Seat};
use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
#[cfg(not(target_arch = "wasm32"))]
use std::time::{Duration, Instant};

/// The answers to a [`Batch`](crate::Batch), or to what [`Executor::submit`](crate::Executor::submit) was given, which are on their way. See
/// [the module `batch`](crate::batch) for who works on them, and when.
///
/// Answers are handed out once, by any of its methods or to a future. Dropping a ticket cancels it. It needs neither its batch nor its
/// executor any longer.
///
/// # Examples
/// ```
/// use pfront::{Batch, Executor, Model, Pose};
/// use std::sync::{Arc, Mutex, PoisonError};
/// # async fn frame() -> Result<(), pfront::Error> {
/// # let triangle = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let model = Arc::new(Model::new(triangle, vec![[0, 1, 2]])?);
/// let mut batch = Batch::new();
/// batch.pair(&model, &model, Pose::IDENTITY)?;
/// let ticket = batch.count(&Executor::threads(4))?;
/// assert_eq!(ticket.await?, [1]);
/// # Ok(()) }
/// # pollster::block_on(frame()).unwrap();
/// ```
#[must_use = "dropping a ticket cancels it"]
pub struct Ticket<T> {
    outcome: Arc<Outcome<T>>,
    /// The work, if nobody else does it. Only the ticket calls it, so that nobody waits for this lock.
    steps: Mutex<Option<Steps<T>>>,
    planned: Planned,
    /// The place in the queue of a GPU.
    pub(crate) seat: Option<Seat>,
}

/// Work in slices: each call does one, and returns the answer after the last.
pub(crate) type Steps<T> = Box<dyn FnMut() -> Result<Option<T>, Error> + Send>;

/// Who answers the questions of a ticket.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    pub(crate) questions: usize,
    pub(crate) backend: Backend,
    pub(crate) reason: Reason,
    /// The questions that one thread answers in place of a GPU, in order.
    pub(crate) on_cpu: Vec<usize>,
}

impl<T> Ticket<T> {
    pub(crate) fn new(outcome: Arc<Outcome<T>>, planned: Planned) -> Self {
        Self { outcome, steps: Mutex::default(), planned, seat: None }
    }

    /// A ticket whose work is done by whoever asks for the answer.
    pub(crate) fn in_steps(steps: Steps<T>, planned: Planned) -> Self {
        Self { outcome: Arc::default(), steps: Mutex::new(Some(steps)), planned, seat: None }
    }

    /// The backend that answers a question of a batch, and the reason; `None` if there is no such question. It is known from the
    /// submission on. Queries that [`Executor::submit`](crate::Executor::submit) was given tell of themselves.
    ///
    /// # Complexity
    /// O(log n) for n questions.
    ///
    /// # Examples
    /// ```
    /// use pfront::executor::Backend;
    /// use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::{Arc, Mutex, PoisonError};
    /// # let model = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
    /// let mut batch = Batch::new();
    /// batch.pair(&model, &model, Pose::IDENTITY)?;
    /// let ticket = batch.count(&Executor::sequential())?;
    /// assert_eq!(ticket.plan(0).map(|plan| plan.backend), Some(Backend::Sequential));
    /// assert_eq!(ticket.plan(1), None);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[must_use]
    pub fn plan(&self, question: usize) -> Option<Plan> {
        let Planned { questions, backend, reason, on_cpu } = &self.planned;
        (question < *questions).then(|| match on_cpu.binary_search(&question) {
            Ok(_) => Plan::new(Backend::Sequential, Reason::CpuOnly),
            Err(_) => Plan::new(*backend, *reason),
        })
    }

    /// Whether reading would not wait: the answers are there, or an error is, which reading tells. Never waits.
    ///
    /// # Complexity
    /// O(1); on a sequential executor, one slice of about 4096 tests of a batch, or all of what
    /// [`Executor::submit`](crate::Executor::submit) was given.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let tile = Arc::new(Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&tile, &tile, Pose::IDENTITY)?;
    /// let mut ticket = batch.any(&Executor::sequential())?;
    /// while !ticket.is_ready() {} // a slice of the work each time
    /// assert!(ticket.read()?[0].is_some());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn is_ready(&mut self) -> bool {
        self.step();
        self.outcome.is_known()
    }

    /// The answers, if they are there. Never waits.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::AlreadyRead`]; [`Error::Panicked`]; [`Error::Memory`] if the answers do not fit into
    /// memory; `Error::Gpu` if a GPU fails that is to answer everything.
    ///
    /// # Complexity
    /// As [`Ticket::is_ready`], and O(n) for n questions when they are answered.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Error, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let tile = Arc::new(Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&tile, &tile, Pose::IDENTITY)?;
    /// let mut ticket = batch.count(&Executor::sequential())?;
    /// while !ticket.is_ready() {} // a slice of the work each time
    /// assert_eq!(ticket.try_read()?, Some(vec![1]));
    /// assert_eq!(ticket.try_read(), Err(Error::AlreadyRead));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn try_read(&mut self) -> Result<Option<T>, Error> {
        self.step();
        self.outcome.take().transpose()
    }

    /// The answers, if they are there in time. Waits for this ticket and for nothing else; a thread of a rayon pool works on
    /// what waits in its pool meanwhile, and may come back late. Not on wasm32, which has no clock.
    ///
    /// # Errors
    /// As [`Ticket::try_read`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::time::Duration;
    /// # use std::sync::Arc;
    /// # let tile = Arc::new(Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&tile, &tile, Pose::IDENTITY)?;
    /// let mut ticket = batch.count(&Executor::threads(2))?;
    /// let counts = loop {
    ///     match ticket.wait(Duration::from_millis(2))? {
    ///         Some(counts) => break counts,
    ///         None => println!("not yet"),
    ///     }
    /// };
    /// assert_eq!(counts, [1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait(&mut self, timeout: Duration) -> Result<Option<T>, Error> {
        // A time too long to be told is waited for without an end.
        let until = Instant::now().checked_add(timeout);
        self.step();
        while self.steps().is_some() && until.is_none_or(|until| Instant::now() < until) {
            self.step();
        }
        if self.steps().is_none() {
            self.outcome.wait(until);
        }
        self.outcome.take().transpose()
    }

    /// The answers, for which it waits.
    ///
    /// # Errors
    /// As [`Ticket::try_read`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let tile = Arc::new(Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&tile, &tile, Pose::IDENTITY)?;
    /// assert_eq!(batch.count(&Executor::threads(2))?.read()?, [1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn read(mut self) -> Result<T, Error> {
        while self.steps().is_some() {
            self.step();
        }
        self.outcome.wait(None);
        self.outcome.take().unwrap_or(Err(Error::Cancelled))
    }

    /// Gives up the answers: reading the ticket returns [`Error::Cancelled`] from now on. Each thread that works on a batch stops within
    /// 4096 tests, about 0.1 ms, and a GPU after what has been submitted, two runs at most; nothing more is. Does not wait for them.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Batch, Error, Executor, Model, Pose};
    /// # use std::sync::Arc;
    /// # let tile = Arc::new(Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?);
    /// # let mut batch = Batch::new();
    /// batch.pair(&tile, &tile, Pose::IDENTITY)?;
    /// let mut ticket = batch.count(&Executor::threads(2))?;
    /// ticket.cancel();
    /// assert_eq!(ticket.read(), Err(Error::Cancelled));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn cancel(&mut self) {
        *self.steps() = None;
        self.outcome.cancel();
    }

    fn steps(&mut self) -> &mut Option<Steps<T>> {
        self.steps.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does a slice, if nobody else works.
    fn step(&mut self) {
        let outcome = self.outcome.clone();
        let Some(steps) = self.steps() else { return };
        match outcome.guard(steps) {
            Some(None) => return,
            Some(Some(answer)) => outcome.set(Ok(answer)),
            // The outcome says why.
            None => {}
        }
        *self.steps() = None;
    }
}

/// Results of a GPU, for a consumer on the same device.
#[cfg(feature = "gpu")]
impl<T> Ticket<T> {
    /// The hits of a single question, on the device of an `Executor::gpu`. `None` if another executor answers, or the batch
    /// does not have just one question; while the ticket waits for its turn, since two others are in flight; and if two
    /// other tickets show their buffers.
    ///
    /// `array<vec2<u32>>`: the triangles `(a, b)` of each hit, sorted for [`Batch::all`](crate::Batch::all) unless they
    /// are far more than in the last answers, or very uneven; [`Ticket::read`] sorts them then. Work that is submitted to the queue
    /// after the ticket finds them there, without waiting, until the ticket is dropped or read by [`Ticket::read`]; then the lists go to the next ticket. Only [`Ticket::count_buffer`] says how many there are, and
    /// whether these are all. Bind it to read (`STORAGE`, `COPY_SRC`).
    ///
    /// # Examples
    /// ```no_run
    /// use pfront::gpu::{Gpu, GpuQuery};
    /// use pfront::{Batch, Executor, Model, Pose};
    /// # use std::sync::{Arc, Mutex, PoisonError};
    /// # fn demo(model: Arc<Model>, indirect: pfront::gpu::wgpu::Buffer) -> Result<(), pfront::Error> {
    /// let gpu = Gpu::new()?;
    /// let mut batch = Batch::new();
    /// batch.pair(&model, &model, Pose::IDENTITY)?;
    /// let ticket = batch.all(&Executor::gpu(&gpu, gpu.settings()))?;
    /// if let (Some(hits), Some(count)) = (ticket.hits_buffer(), ticket.count_buffer()) {
    ///     let mut encoder = gpu.device().create_command_encoder(&Default::default());
    ///     // As many instances as hits, drawn from `hits`.
    ///     encoder.copy_buffer_to_buffer(count, GpuQuery::COUNT_OFFSET, &indirect, 4, 4);
    ///     gpu.queue().submit([encoder.finish()]);
    /// }
    /// # Ok(()) }
    /// ```
    #[must_use]
    pub fn hits_buffer(&self) -> Option<&crate::gpu::wgpu::Buffer> {
        self.outcome.shown.buffers().map(|[hits, _]| hits)
    }

    /// The counters of a single question, as [`Ticket::hits_buffer`].
    ///
    /// `array<u32>`: at [`GpuQuery::COUNT_OFFSET`](crate::gpu::GpuQuery::COUNT_OFFSET) the number of hits. The few
    /// triangle pairs that the device leaves to the CPU are not among them: how many these are is at
    /// [`REST_OFFSET`](crate::gpu::GpuQuery::REST_OFFSET). A number other than 0 at
    /// [`OVERFLOW_OFFSET`](crate::gpu::GpuQuery::OVERFLOW_OFFSET) says that the lists are too small: then only the host
    /// gets the answer, in parts, and what the buffers hold is not defined.
    #[must_use]
    pub fn count_buffer(&self) -> Option<&crate::gpu::wgpu::Buffer> {
        self.outcome.shown.buffers().map(|[_, count]| count)
    }
}

impl<T> Future for Ticket<T> {
    type Output = Result<T, Error>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        self.step();
        if self.steps().is_some() {
            // Nobody else would.
            context.waker().wake_by_ref();
        }
        self.outcome.poll(context.waker())
    }
}

impl<T> Drop for Ticket<T> {
    fn drop(&mut self) {
        self.outcome.cancel();
        if let Some(seat) = &self.seat {
            seat.leave();
        }
    }
}

impl<T> fmt::Debug for Ticket<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ticket").field("is_known", &self.outcome.is_known()).finish_non_exhaustive()
    }
}
