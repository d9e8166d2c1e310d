//! Traversals of queries on p workers, with memory that is kept from frame to frame.

use crate::front::{FrontMemory, Start};
use crate::memory::{push, reserve};
use crate::output::{self, Item, OutputBuffer, Storage, Visitor};
use crate::workers::{Workers, for_each, in_scope};
use crate::{Hit, MemoryError, Report, Settings};
use pfront_core::bvtt::{Query, TrianglePair};
use pfront_core::environment::with_default;
use rayon::ThreadPool;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// The largest number of workers p.
pub const MAX_WORKERS: usize = 1 << 16;

/// Contacts that take about as long as to call another thread: some 0.3 us each.
const CONTACTS: usize = 64;

/// Pieces of a list of contacts for each thread, so that no thread waits long for the last.
const PIECES: usize = 8;

/// Answers queries frame after frame with p workers.
///
/// Use one for each series of frames that resemble each other: the costs of the last frame tell how to
/// divide the next. Nothing but speed depends on it, and a jump is noticed. Every verb asks
/// any number of queries at once, under one bound and one partition (eq. 5); a query is remembered by its number
/// in the slice, see [`Traversal::renumber`].
///
/// A frame that is expected to be small, and any search for one hit, begins on the calling thread. After as much work as
/// it takes to call others, the pending node pairs of its cursor start a front for them; nothing is done twice.
///
/// After a break or a panic in a visitor, or a [`MemoryError`], it can be used as before.
#[derive(Clone, Debug)]
pub struct Traversal {
    /// p, the number of parts that a front is divided into. A number below 1 or above [`MAX_WORKERS`] counts as that, since
    /// for every p the answer is the same and memory grows with p.
    pub workers: usize,
    /// How a frame is divided.
    pub settings: Settings,
    /// The instant at which frames end, complete or not: see [`Report::late`]. Under every schedule each thread looks at
    /// the clock before every 4096 tests, about 0.1 ms. Generating a front and sorting are not interrupted.
    pub deadline: Option<Instant>,
    /// A flag that ends the frame, complete or not, as soon as it is true: each thread looks at it where it looks at the
    /// clock. Nobody but the caller sets it or clears it.
    pub cancel: Option<Arc<AtomicBool>>,
    /// Counts and durations of the last frame.
    pub report: Report,
    pub(crate) pool: Option<Arc<ThreadPool>>,
    pub(crate) front: FrontMemory,
    /// The cost of the last complete frame.
    pub(crate) last_cost: Option<f64>,
    /// The seconds that it takes to call other threads, if that was measured.
    pub(crate) call: Option<f64>,
    /// The seconds that the last frame for which others were called took beyond its share of the work.
    pub(crate) overhead: f64,
    /// The seconds that a box test took the calling thread when it last was alone for as long as pays.
    pub(crate) pace: Option<f64>,
    pub(crate) starts: Vec<Start>,
    pub(crate) buffers: Workers,
    storage: Storage,
}

/// A worker for each thread in the rayon pool of the calling thread.
impl Default for Traversal {
    fn default() -> Self {
        Self::new(rayon::current_num_threads())
    }
}

impl Traversal {
    /// A traversal with p = `workers` parts, in the rayon pool of the calling thread.
    #[must_use]
    pub fn new(workers: usize) -> Self {
        Self {
            workers,
            settings: Settings::default(),
            deadline: None,
            cancel: None,
            report: Report::default(),
            pool: None,
            front: FrontMemory::default(),
            last_cost: None,
            call: None,
            overhead: 0.0,
            pace: None,
            starts: Vec::new(),
            buffers: Workers::default(),
            storage: Storage::default(),
        }
    }

    /// A traversal with one worker for each thread of `pool`, in which it runs.
    #[must_use]
    pub fn with_pool(pool: Arc<ThreadPool>) -> Self {
        Self { pool: Some(pool.clone()), ..Self::new(pool.current_num_threads()) }
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
    /// last frame before there is one, and the counts of a [`Report`] are the same on every machine.
    ///
    /// # Examples
    /// ```
    /// let traversal = pfront_cpu::Traversal::new(4).measured();
    /// ```
    #[must_use]
    pub fn measured(self) -> Self {
        let mut times = [Duration::ZERO; 9];
        for time in &mut times {
            // Threads that have just worked are still awake.
            std::thread::sleep(Duration::from_millis(1));
            let clock = Instant::now();
            in_scope(self.pool.as_deref(), |scope| {
                (1..self.threads()).for_each(|_| scope.spawn(|_| ()));
            });
            *time = clock.elapsed();
        }
        times.sort_unstable();
        // A bound rather than a mean, but for the one time that something else may have come between.
        let call = with_default(|| times[times.len() - 2].as_secs_f64());
        Self { call: Some(call), ..self }
    }

    /// Forgets the costs of the last frame, for a next one that does not resemble it.
    pub fn forget(&mut self) {
        self.front.forget();
        self.last_cost = None;
    }

    /// Runs a function in the pool of this traversal.
    ///
    /// # Examples
    /// ```
    /// let traversal = pfront_cpu::Traversal::new(2);
    /// assert_eq!(traversal.install(|| rayon::join(|| 1, || 2)), (1, 2));
    /// ```
    pub fn install<R: Send>(&self, run: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(run),
            None => run(),
        }
    }

    /// Starts a function in the pool of this traversal, and does not wait for it. A panic there is one of the pool: see
    /// [`rayon::spawn`].
    ///
    /// # Examples
    /// ```
    /// let (tell, told) = std::sync::mpsc::channel();
    /// pfront_cpu::Traversal::new(2).spawn(move || tell.send(6 * 7).unwrap());
    /// assert_eq!(told.recv(), Ok(42));
    /// ```
    pub fn spawn(&self, run: impl FnOnce() + Send + 'static) {
        match &self.pool {
            Some(pool) => pool.spawn(run),
            None => rayon::spawn(run),
        }
    }

    /// The number of threads that may work on a frame: one for each worker, if the pool has as many.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.p().min(self.pool_threads())
    }

    /// Renumbers the queries of the last frame, for a next frame that asks other ones: `number` returns the new number
    /// of a query, or `None` if it is gone. Its costs stay with it.
    ///
    /// # Examples
    /// ```
    /// # use pfront_cpu::Traversal;
    /// let mut traversal = Traversal::new(8);
    /// // ... a frame of four queries, of which the third is then taken out:
    /// traversal.renumber(|query| [Some(0), Some(1), None, Some(2)][query as usize]);
    /// ```
    pub fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        self.front.renumber(number);
    }

    /// Replaces the contents of `out` by all intersecting pairs, sorted: by query and pair if these are [`Hit`]s; plain
    /// triangle pairs, for a single query, do not tell the query.
    ///
    /// # Errors
    /// [`MemoryError`] if they, or the front that divides the frame, do not fit into memory; `out` is empty then.
    pub fn all<Q: Query + Sync, T: Item>(
        &mut self,
        queries: &[Q],
        out: &mut Vec<T>,
    ) -> Result<(), MemoryError> {
        let mut lists = std::mem::take(T::storage(&mut self.storage));
        lists.truncate(self.p());
        lists.iter_mut().for_each(OutputBuffer::clear);
        let listed = self.run(queries, false, &mut lists, OutputBuffer::default).and_then(|_| {
            let clock = (!self.report.shares.is_empty()).then(Instant::now);
            output::merge(&mut lists, self.threads(), self.pool.as_deref(), out)?;
            self.report.gather_time = clock.map_or(Duration::ZERO, |clock| clock.elapsed());
            Ok(())
        });
        match listed {
            Ok(()) => *T::storage(&mut self.storage) = lists,
            // The lists are given back, and this one.
            Err(_) => *out = Vec::new(),
        }
        listed
    }

    /// The number of intersecting pairs.
    ///
    /// # Errors
    /// [`MemoryError`] if there is no memory for the front that divides the frame.
    pub fn count<Q: Query + Sync>(&mut self, queries: &[Q]) -> Result<u64, MemoryError> {
        let mut counts = Vec::new();
        self.run(queries, false, &mut counts, || 0)?;
        Ok(counts.into_iter().sum())
    }

    /// Some intersecting pair, if there is one: the first that some worker finds, at which all stop. The pair may
    /// differ from call to call. Costs are neither used nor remembered.
    ///
    /// # Errors
    /// As [`Traversal::count`].
    pub fn any<Q: Query + Sync>(&mut self, queries: &[Q]) -> Result<Option<Hit>, MemoryError> {
        let mut found = Vec::new();
        self.run(queries, true, &mut found, || None)?;
        Ok(found.into_iter().flatten().min())
    }

    /// Calls `visit` from all workers for each intersecting pair, in no particular order, until one of the
    /// calls breaks; calls that others have begun by then still end. A `visit` that waits for tasks of the same pool may be
    /// called again on its thread before it returns, and so holds no lock meanwhile.
    ///
    /// # Errors
    /// As [`Traversal::count`]; some pairs may have been visited.
    pub fn visit<Q: Query + Sync>(
        &mut self,
        queries: &[Q],
        visit: impl Fn(Hit) -> ControlFlow<()> + Sync,
    ) -> Result<ControlFlow<()>, MemoryError> {
        let complete = self.run(queries, false, &mut Vec::new(), || Visitor::new(&visit))?;
        Ok(if complete { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
    }

    /// Adds to `out`, in order, where each of `pairs` meets as `contact` says ([`Query::contact`] or
    /// [`Query::contact_f64`]), in the pool of this traversal. A pair that meets nowhere is left out.
    ///
    /// # Errors
    /// [`MemoryError`] if they do not fit into memory; nothing is added then.
    pub fn contacts<C: Send>(
        &self,
        pairs: &[TrianglePair],
        contact: impl Fn(TrianglePair) -> Option<C> + Sync,
        out: &mut Vec<(TrianglePair, C)>,
    ) -> Result<(), MemoryError> {
        self.filter_map(pairs, |&pair| Some((pair, contact(pair)?)), out)
    }

    /// Adds to `out`, in order, what `map` makes of some items, in the pool of this traversal. It takes the time of a contact or
    /// more for each, and runs in the default floating-point environment.
    ///
    /// # Errors
    /// [`MemoryError`] if that does not fit into memory; nothing is added then.
    ///
    /// # Examples
    /// ```
    /// let (traversal, mut out) = (pfront_cpu::Traversal::new(2), Vec::new());
    /// traversal.filter_map(&[3, 5, 4], |&i| (i > 3).then_some(10 * i), &mut out)?;
    /// assert_eq!(out, [50, 40]);
    /// # Ok::<(), pfront_cpu::MemoryError>(())
    /// ```
    pub fn filter_map<T: Sync, R: Send>(
        &self,
        items: &[T],
        map: impl Fn(&T) -> Option<R> + Sync,
        out: &mut Vec<R>,
    ) -> Result<(), MemoryError> {
        let before = out.len();
        if items.len() < 2 * CONTACTS {
            let added = with_default(|| {
                items.iter().filter_map(map).try_for_each(|mapped| push(out, mapped))
            });
            if added.is_err() {
                out.truncate(before);
            }
            return added;
        }
        let size = items.len().div_ceil(PIECES * self.pool_threads()).max(CONTACTS);
        struct Piece<'t, T, R> {
            items: &'t [T],
            list: Vec<R>,
            added: Result<(), MemoryError>,
        }
        let mut pieces = Vec::new();
        reserve(&mut pieces, items.len().div_ceil(size))?;
        let piece = |items| Piece { items, list: Vec::new(), added: Ok(()) };
        pieces.extend(items.chunks(size).map(piece));
        let has_failed = AtomicBool::new(false);
        for_each(self.pool.as_deref(), &mut pieces, |Piece { items, list, added }| {
            let mapped = items.iter().take_while(|_| !has_failed.load(Relaxed)).filter_map(&map);
            *added = mapped.into_iter().try_for_each(|mapped| push(list, mapped));
            if added.is_err() {
                has_failed.store(true, Relaxed);
                *list = Vec::new();
            }
        });
        pieces.iter().try_for_each(|piece| piece.added)?;
        reserve(out, pieces.iter().map(|piece| piece.list.len()).sum())?;
        pieces.iter_mut().for_each(|piece| out.append(&mut piece.list));
        Ok(())
    }

    /// Gives back the memory that is kept for the next frames, and what is remembered for them.
    pub(crate) fn release(&mut self) {
        self.forget();
        self.front = FrontMemory::default();
        (self.starts, self.buffers) = (Vec::new(), Workers::default());
        self.storage = Storage::default();
    }

    /// The number of threads of the pool.
    fn pool_threads(&self) -> usize {
        let pool = self.pool.as_ref();
        pool.map_or_else(rayon::current_num_threads, |pool| pool.current_num_threads())
    }

    /// The number of workers.
    pub(crate) fn p(&self) -> usize {
        self.workers.clamp(1, MAX_WORKERS)
    }
}
