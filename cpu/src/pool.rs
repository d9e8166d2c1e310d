//! Workers and the threads that they run on: what frames share and none of them changes.

use crate::memory::reserve;
use crate::{MemoryError, Settings};
use pfront_core::environment::{Environment, with_default};
use rayon::{Scope, ThreadPool};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// The largest number of workers p.
pub const MAX_WORKERS: usize = 1 << 16;

/// Pieces of a list of contacts for each thread, so that no thread waits long for the last.
const PIECES: usize = 8;

/// The longest time for which threads are kept awake.
const AWAKE: Duration = Duration::from_millis(1);

/// p workers, which run in a rayon pool. Copies share the rayon pool; any number of [`Traversal`](crate::Traversal)s use one.
///
/// # Examples
/// ```
/// use pfront_cpu::{Pool, Schedule, Settings, Traversal};
/// let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
/// let pool = Pool::new(8).with_settings(settings);
/// let [mut of_one_scene, mut of_another] = [Traversal::new(&pool), Traversal::new(&pool)];
/// ```
#[derive(Clone, Debug)]
pub struct Pool {
    /// p, the number of parts that a front is divided into. A number below 1 or above [`MAX_WORKERS`] counts as that, since
    /// for every p the answer is the same and memory grows with p.
    pub workers: usize,
    /// How a frame is divided.
    pub settings: Settings,
    /// The rayon pool of the calling thread if there is none.
    threads: Option<Arc<ThreadPool>>,
    /// The seconds that it takes to call other threads, if that was measured.
    pub(crate) call: Option<f64>,
}

/// A worker for each thread in the rayon pool of the calling thread.
impl Default for Pool {
    fn default() -> Self {
        Self::new(rayon::current_num_threads())
    }
}

/// A worker for each thread of a rayon pool.
impl From<Arc<ThreadPool>> for Pool {
    fn from(threads: Arc<ThreadPool>) -> Self {
        let workers = threads.current_num_threads();
        Self { threads: Some(threads), ..Self::new(workers) }
    }
}

impl Pool {
    /// p = `workers`, in the rayon pool of whichever thread calls.
    #[must_use]
    pub fn new(workers: usize) -> Self {
        Self { workers, settings: Settings::default(), threads: None, call: None }
    }

    /// The same with other settings.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Self { settings, ..self }
    }

    /// The same, with what it takes to call other threads measured now, in some 10 ms, instead of assumed.
    ///
    /// A frame then begins on the calling thread for a time of W p / (p - 1), with W the time of a call and p workers, or for
    /// twice what the last frame took, if that is longer: so it takes at most 1 + (p - 1) / p times what one thread takes,
    /// whatever it finds, as long as a call takes W. Others are called from the start if the last frame was worth it with what
    /// calling them really took, front included. Without a measurement, 2,048 tests stand for both times, an estimate for the
    /// last frame before there is one, and the counts of a [`Report`](crate::Report) are the same on every machine.
    ///
    /// # Examples
    /// ```
    /// let pool = pfront_cpu::Pool::new(4).measured();
    /// ```
    #[must_use]
    pub fn measured(self) -> Self {
        let mut times = [Duration::ZERO; 9];
        for time in &mut times {
            // Threads that have just worked are still awake.
            std::thread::sleep(Duration::from_millis(1));
            let clock = Instant::now();
            self.in_scope(|scope| (1..self.threads()).for_each(|_| scope.spawn(|_| ())));
            *time = clock.elapsed();
        }
        times.sort_unstable();
        // A bound rather than a mean, but for the one time that something else may have come between.
        let call = with_default(|| times[times.len() - 2].as_secs_f64());
        Self { call: Some(call), ..self }
    }

    /// Runs a function in the rayon pool.
    ///
    /// # Examples
    /// ```
    /// let pool = pfront_cpu::Pool::new(2);
    /// assert_eq!(pool.install(|| rayon::join(|| 1, || 2)), (1, 2));
    /// ```
    pub fn install<R: Send>(&self, run: impl FnOnce() -> R + Send) -> R {
        match &self.threads {
            Some(threads) => threads.install(run),
            None => run(),
        }
    }

    /// Starts a function in the rayon pool, and does not wait for it. A panic there is one of the rayon pool: see
    /// [`rayon::spawn`].
    ///
    /// # Examples
    /// ```
    /// let (tell, told) = std::sync::mpsc::channel();
    /// pfront_cpu::Pool::new(2).spawn(move || tell.send(6 * 7).unwrap());
    /// assert_eq!(told.recv(), Ok(42));
    /// ```
    pub fn spawn(&self, run: impl FnOnce() + Send + 'static) {
        match &self.threads {
            Some(threads) => threads.spawn(run),
            None => rayon::spawn(run),
        }
    }

    /// The number of threads that may work on a frame: one for each worker, if the rayon pool has as many.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.p().min(self.all_threads())
    }

    /// Adds to `out`, in order, what `list` makes of pieces of some items, on any thread and in the default floating-point environment.
    /// A piece has `least` items or more, as many as are worth a call of another thread; fewer than two such pieces are one.
    ///
    /// # Errors
    /// The first that `list` returns, or [`MemoryError`] if not all fits into memory; nothing is added then.
    ///
    /// # Examples
    /// ```
    /// use pfront_cpu::{MemoryError, Pool};
    /// let (pool, mut out) = (Pool::new(2), Vec::new());
    /// let double = |piece: &[u32], out: &mut Vec<u32>| -> Result<(), MemoryError> {
    ///     out.extend(piece.iter().map(|i| 2 * i));
    ///     Ok(())
    /// };
    /// pool.by_pieces(&[3, 5, 4], 1, double, &mut out)?;
    /// assert_eq!(out, [6, 10, 8]);
    /// # Ok::<(), MemoryError>(())
    /// ```
    pub fn by_pieces<T: Sync, R: Send, E: From<MemoryError> + Send>(
        &self,
        items: &[T],
        least: usize,
        list: impl Fn(&[T], &mut Vec<R>) -> Result<(), E> + Sync,
        out: &mut Vec<R>,
    ) -> Result<(), E> {
        if items.len() < 2 * least.max(1) {
            let before = out.len();
            let listed = with_default(|| list(items, out));
            if listed.is_err() {
                out.truncate(before);
            }
            return listed;
        }
        let size = items.len().div_ceil(PIECES * self.all_threads()).max(least);
        let mut pieces = Vec::new();
        reserve(&mut pieces, items.len().div_ceil(size))?;
        pieces.extend(items.chunks(size).map(|items| (items, Vec::new(), Ok(()))));
        let has_failed = AtomicBool::new(false);
        self.for_each(&mut pieces, |(items, own, listed)| {
            if !has_failed.load(Relaxed) {
                *listed = list(items, own);
                has_failed.fetch_or(listed.is_err(), Relaxed);
            }
        });
        for (_, _, listed) in &mut pieces {
            std::mem::replace(listed, Ok(()))?;
        }
        let sizes = pieces.iter().map(|(_, own, _)| own.len());
        reserve(out, sizes.sum())?;
        pieces.iter_mut().for_each(|(_, own, _)| out.append(own));
        Ok(())
    }

    /// The number of threads of the rayon pool.
    fn all_threads(&self) -> usize {
        let threads = self.threads.as_ref();
        threads.map_or_else(rayon::current_num_threads, |threads| threads.current_num_threads())
    }

    /// The number of workers.
    pub(crate) fn p(&self) -> usize {
        self.workers.clamp(1, MAX_WORKERS)
    }

    /// Runs a function on the calling thread, with a scope to call others. The calling thread may do what others have left in the
    /// rayon pool while it waits for these, so that only what runs in the scope is in the default floating-point environment.
    pub(crate) fn in_scope<'s, R>(&self, run: impl FnOnce(&Scope<'s>) -> R) -> R {
        match &self.threads {
            Some(threads) => threads.in_place_scope(run),
            None => rayon::in_place_scope(run),
        }
    }

    /// Runs a function for each item, the first on the calling thread, in the default floating-point environment.
    pub(crate) fn for_each<T: Send>(
        &self,
        items: impl IntoIterator<Item = T>,
        run: impl Fn(T) + Sync,
    ) {
        let (mut items, run) = (items.into_iter(), &run);
        let own = items.next();
        self.in_scope(|scope| {
            items.for_each(|item| spawn(scope, move |_, _| run(item)));
            if let Some(item) = own {
                with_default(|| run(item));
            }
        });
    }

    /// Runs a function that first does what one thread does, and then sets the flag and calls others. So many threads, the
    /// calling one among them, are awake by then.
    pub(crate) fn awake<R>(&self, threads: usize, run: impl FnOnce(&AtomicBool) -> R) -> R {
        let is_ready = AtomicBool::new(false);
        self.in_scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|_| {
                    let clock = Instant::now();
                    while !is_ready.load(Relaxed) && clock.elapsed() < AWAKE {
                        std::thread::yield_now();
                    }
                });
            }
            run(&is_ready)
        })
    }
}

/// Spawns a job, which runs in the default floating-point environment; it is passed that of its thread, which is what the thread
/// that made the rayon pool had.
pub(crate) fn spawn<'s>(scope: &Scope<'s>, job: impl FnOnce(&Scope<'s>, Environment) + Send + 's) {
    scope.spawn(move |scope| {
        let environment = Environment::current();
        with_default(|| job(scope, environment));
    });
}
