//! Workers and the threads that they run on: what frames share and none of them changes.

use crate::memory::reserve;
use crate::sort::SORTED_ALONE;
use crate::{MemoryError, Settings};
use pfront_core::environment::{Environment, with_default};
use rayon::slice::ParallelSliceMut;
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
    /// p, the number of parts that a front is divided into, unless fewer threads are called than there are. A number below 1 or above [`MAX_WORKERS`] counts as that, since
    /// for every p the answer is the same and memory grows with p.
    pub workers: usize,
    /// How a frame is divided.
    pub settings: Settings,
    /// The rayon pool of the calling thread if there is none.
    threads: Option<Arc<ThreadPool>>,
    /// The prices of calls of other threads, if these were measured.
    pub(crate) calls: Option<Arc<[Call]>>,
}

/// The price of a call of threads of a rayon pool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Call {
    /// How many there are with the calling thread.
    pub(crate) threads: usize,
    /// The time until all have come and gone.
    pub(crate) seconds: f64,
}

impl Call {
    /// The seconds from which on its threads are faster than one, if the call takes no less than `least`: W q / (q - 1) for q threads, if it takes W.
    pub(crate) fn worth(&self, least: f64) -> f64 {
        let threads = self.threads as f64;
        self.seconds.max(least) * threads / (threads - 1.0)
    }

    /// The seconds that they take for what takes the calling thread so many, if each of several `calls` takes as long.
    fn time_of(&self, alone: f64, calls: f64) -> f64 {
        alone / self.threads as f64 + calls * self.seconds
    }
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
        Self { workers, settings: Settings::default(), threads: None, calls: None }
    }

    /// The same with other settings.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Self { settings, ..self }
    }

    /// The same, with what it takes to call other threads measured now instead of assumed: all of them, half of them, and so on, some 7 ms
    /// each.
    ///
    /// A frame then begins on the calling thread for the least time of W q / (q - 1), with W the time of a call of q threads, or for
    /// twice what the last frame took, if that is longer. Then as many are called as would be the fastest if as much is left as was
    /// done: so it takes at most 2 - 1 / q times what one thread takes with q threads, whatever it finds, as long as calls take
    /// these times. Others are called from the start if the last frame was worth it with what calling them really took, front included: as many as
    /// would have been the fastest, with as many calls as threads were idle for the time of. Where not all are called, the front has a
    /// part for each that is. Without a measurement, 2,048 tests stand for both times, an estimate for the last frame before there is one, and the counts of a
    /// [`Report`](crate::Report) are the same on every machine.
    ///
    /// To call 64 threads can take six times as long as to call eight, and longer than the rest of the frame (benches/record/many-cores.md).
    ///
    /// # Examples
    /// ```
    /// let pool = pfront_cpu::Pool::new(4).measured();
    /// ```
    #[must_use]
    pub fn measured(self) -> Self {
        let halves = std::iter::successors(Some(self.threads()), |threads| Some(threads / 2));
        let calls = halves.take_while(|&threads| threads > 1).map(|threads| self.call(threads));
        Self { calls: Some(calls.collect()), ..self }
    }

    /// The price of so many threads, measured.
    fn call(&self, threads: usize) -> Call {
        let mut times = [Duration::ZERO; 6];
        for time in &mut times {
            // Threads that have just worked are still awake.
            std::thread::sleep(Duration::from_millis(1));
            let clock = Instant::now();
            self.in_scope(|scope| (1..threads).for_each(|_| scope.spawn(|_| ())));
            *time = clock.elapsed();
        }
        times.sort_unstable();
        // A bound rather than a mean, but for the one time that something else may have come between.
        let seconds = with_default(|| times[times.len() - 2].as_secs_f64());
        Call { threads, seconds }
    }

    /// The seconds from which on some number of threads is faster than one; if nothing was measured, there are none.
    pub(crate) fn worth(&self) -> Option<f64> {
        let worths = self.calls.as_deref()?.iter().map(|call| call.worth(0.0));
        // Where there is nobody to call, never.
        Some(worths.fold(f64::INFINITY, f64::min))
    }

    /// The call of as many threads as are the fastest for what takes the calling thread so many seconds.
    pub(crate) fn fastest(&self, alone: f64, calls: f64) -> Option<Call> {
        let all = self.calls.as_deref()?.iter().copied();
        all.min_by(|x, y| x.time_of(alone, calls).total_cmp(&y.time_of(alone, calls)))
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

    /// Sorts a list, equal items in any order, on all threads of the rayon pool if it is long enough for that. Keys are compared in the floating-point
    /// environment of whichever thread does, so that they had better be integers.
    ///
    /// # Examples
    /// ```
    /// let mut items: Vec<u32> = (0..10_000).rev().collect();
    /// pfront_cpu::Pool::new(2).sort(&mut items, |item| *item);
    /// assert!(items.is_sorted());
    /// ```
    pub fn sort<T: Send, K: Ord>(&self, items: &mut [T], key: impl Fn(&T) -> K + Sync + Send) {
        if items.len() < SORTED_ALONE {
            return items.sort_unstable_by_key(key);
        }
        self.install(|| items.par_sort_unstable_by_key(key));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn pool(calls: &[(usize, f64)]) -> Pool {
        let calls = calls.iter().map(|&(threads, seconds)| Call { threads, seconds });
        Pool { calls: Some(calls.collect()), ..Pool::new(64) }
    }

    /// Calls as they were measured on 64 processors.
    #[test]
    fn as_many_are_called_as_are_the_fastest() {
        let pool = pool(&[(64, 470e-6), (32, 258e-6), (16, 110e-6), (8, 78e-6), (4, 55e-6)]);
        let threads = |ms: f64, calls| pool.fastest(1e-3 * ms, calls).map(|call| call.threads);
        let alone = [0.1, 0.6, 2.0, 8.0, 50.0].map(|ms| threads(ms, 1.0));
        assert_eq!(alone, [4, 16, 16, 32, 64].map(Some));
        assert_eq!(threads(8.0, 4.0), Some(16));
        assert!((pool.worth().unwrap() - 55e-6 * 4.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn nobody_is_called_where_there_is_nobody() {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let pool = Pool { workers: 4, ..Pool::from(Arc::new(alone)) }.measured();
        assert_eq!((pool.worth(), pool.fastest(1.0, 1.0).is_none()), (Some(f64::INFINITY), true));
        assert!(Pool::new(4).worth().is_none() && Pool::new(4).fastest(1.0, 1.0).is_none());
    }
}
