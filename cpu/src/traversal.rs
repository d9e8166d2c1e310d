//! Traversals of queries by a pool, with memory that is kept from frame to frame.

use crate::front::{FrontMemory, Start};
use crate::merge::merge;
use crate::output::{Item, OutputBuffer, Storage, Visitor};
use crate::workers::Workers;
use crate::{Hit, MemoryError, Pool, Queries, Report};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Answers queries frame after frame by a [`Pool`], and remembers what that took.
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
    /// The pool that answers.
    pub pool: Pool,
    /// The instant at which frames end, complete or not: see [`Report::late`]. Under every schedule each thread looks at
    /// the clock before every 4096 tests, about 0.1 ms. Generating a front and sorting are not interrupted.
    pub deadline: Option<Instant>,
    /// A flag that ends the frame, complete or not, as soon as it is true: each thread looks at it where it looks at the
    /// clock. Nobody but the caller sets it or clears it.
    pub cancel: Option<Arc<AtomicBool>>,
    /// Counts and durations of the last frame.
    pub report: Report,
    pub(crate) front: FrontMemory,
    /// The cost of the last complete frame.
    pub(crate) last_cost: Option<f64>,
    /// The seconds that the last frame for which others were called took beyond its share of the work.
    pub(crate) overhead: f64,
    /// How many calls its threads were idle for the time of.
    pub(crate) calls: f64,
    /// The seconds that a box test took the calling thread when it last was alone for as long as pays.
    pub(crate) pace: Option<f64>,
    /// The threads of the last frame, but the calling one if that was alone.
    pub(crate) called: usize,
    pub(crate) starts: Vec<Start>,
    pub(crate) buffers: Workers,
    storage: Storage,
}

impl Traversal {
    /// A traversal by a pool, which remembers nothing yet.
    #[must_use]
    pub fn new(pool: &Pool) -> Self {
        Self {
            deadline: None,
            cancel: None,
            report: Report::default(),
            pool: pool.clone(),
            front: FrontMemory::default(),
            last_cost: None,
            overhead: 0.0,
            calls: 1.0,
            pace: None,
            called: 0,
            starts: Vec::new(),
            buffers: Workers::default(),
            storage: Storage::default(),
        }
    }

    /// Forgets the costs of the last frame, for a next one that does not resemble it.
    pub fn forget(&mut self) {
        self.front.forget();
        self.last_cost = None;
    }

    /// Renumbers the queries of the last frame, for a next frame that asks other ones: `number` returns the new number
    /// of a query, or `None` if it is gone. Its costs stay with it.
    ///
    /// # Examples
    /// ```
    /// # use pfront_cpu::{Pool, Traversal};
    /// let mut traversal = Traversal::new(&Pool::new(8));
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
    pub fn all<Q: Queries + ?Sized, T: Item>(
        &mut self,
        queries: &Q,
        out: &mut Vec<T>,
    ) -> Result<(), MemoryError> {
        let mut lists = std::mem::take(T::storage(&mut self.storage));
        lists.truncate(self.pool.p());
        lists.iter_mut().for_each(OutputBuffer::clear);
        let listed = self.run(queries, false, &mut lists, OutputBuffer::default).and_then(|_| {
            let clock = (!self.report.shares.is_empty()).then(Instant::now);
            // Others are empty.
            let threads = self.called.clamp(1, lists.len());
            merge(&mut lists[..threads], threads, &self.pool, out)?;
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
    pub fn count<Q: Queries + ?Sized>(&mut self, queries: &Q) -> Result<u64, MemoryError> {
        let mut counts = Vec::new();
        self.run(queries, false, &mut counts, || 0)?;
        Ok(counts.into_iter().sum())
    }

    /// Some intersecting pair, if there is one: the first that some worker finds, at which all stop. The pair may
    /// differ from call to call. Costs are neither used nor remembered.
    ///
    /// # Errors
    /// As [`Traversal::count`].
    pub fn any<Q: Queries + ?Sized>(&mut self, queries: &Q) -> Result<Option<Hit>, MemoryError> {
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
    pub fn visit<Q: Queries + ?Sized>(
        &mut self,
        queries: &Q,
        visit: impl Fn(Hit) -> ControlFlow<()> + Sync,
    ) -> Result<ControlFlow<()>, MemoryError> {
        let complete = self.run(queries, false, &mut Vec::new(), || Visitor::new(&visit))?;
        Ok(if complete { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
    }

    /// Gives back the memory that is kept for the next frames, and what is remembered for them.
    pub(crate) fn release(&mut self) {
        self.forget();
        self.front = FrontMemory::default();
        (self.starts, self.buffers) = (Vec::new(), Workers::default());
        self.storage = Storage::default();
    }
}
