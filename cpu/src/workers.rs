//! Traversing a front that has been partitioned: each worker its own part, and, where that is allowed, what others have
//! left.
//!
//! Threads take the parts, one after the other if there are more parts than threads; the calling thread is one of them. A
//! thread that finds no part takes nodes that others have not begun. When there is none, it leaves its output to the busy
//! threads: the first to see it there splits its cursor and calls a thread of the pool for the half and that output.
//! Nobody waits for work, so that a visitor may use the pool too.
//!
//! In a search for one hit all nodes are one part, in the order in which one thread would search. The calling thread takes them
//! in that order, and others take and are given what it would come to last. So it comes to the first hit no later than it
//! would alone, whatever they do.
//!
//! This is work stealing begun by who gives (Acar, Charguéraud & Rainey, *Scheduling Parallel Programs by Work Stealing with
//! Private Deques*, 2013).

use crate::control::Control;
use crate::memory::{push, reserve};
use crate::output::Output;
use crate::pool::spawn;
use crate::{MemoryError, Pool, Queries, Share};
use pfront_core::bvtt::{Cursor, NodePair, Query, Work};
use pfront_core::environment::{Environment, with_default};
use pfront_core::front::FrontNode;
use rayon::Scope;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The parts of a partition, one for each worker, and what was counted of them.
#[derive(Debug, Default)]
pub(crate) struct Workers {
    parts: Vec<PartOfFront>,
    /// The work below each node.
    costs: Vec<Tally>,
}

/// Nothing in the buffers outlives a frame.
impl Clone for Workers {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug, Default)]
struct PartOfFront {
    /// Positions of its nodes in the front, dearest first.
    nodes: Vec<u32>,
    /// How many of them have been begun: from the front, and from the back.
    begun: [AtomicUsize; 2],
    /// How many may be begun by now, from either end.
    claimed: AtomicUsize,
    /// The work that its worker has done.
    done: Tally,
}

impl PartOfFront {
    /// The next node from one end that nobody has begun.
    fn next(&self, from_back: bool) -> Option<u32> {
        let all = self.nodes.len();
        // As many claims as there are nodes, so that no two threads take the same.
        if self.claimed.load(Relaxed) >= all || self.claimed.fetch_add(1, Relaxed) >= all {
            return None;
        }
        let number = self.begun[usize::from(from_back)].fetch_add(1, Relaxed);
        self.nodes.get(if from_back { all - 1 - number } else { number }).copied()
    }
}

/// Work to which several threads add.
#[derive(Debug, Default)]
struct Tally {
    box_tests: AtomicU64,
    triangle_tests: AtomicU64,
}

impl Tally {
    fn add(&self, work: Work) {
        self.box_tests.fetch_add(work.box_tests, Relaxed);
        self.triangle_tests.fetch_add(work.triangle_tests, Relaxed);
    }

    fn work(&self) -> Work {
        let [box_tests, triangle_tests] =
            [&self.box_tests, &self.triangle_tests].map(|tests| tests.load(Relaxed));
        Work { box_tests, triangle_tests }
    }
}

/// A frame whose front has been partitioned, as all threads see it.
pub(crate) struct DividedFrame<'f, Q: ?Sized> {
    pub(crate) queries: &'f Q,
    pub(crate) nodes: &'f [FrontNode],
    /// Tests between two looks at whether a thread has nothing to do; `None` under a static schedule.
    pub(crate) slice: Option<u64>,
    /// Whether this is a search for one hit.
    pub(crate) only_one_hit: bool,
    pub(crate) control: &'f Control,
}

impl Workers {
    /// Traverses the nodes of `frame`, with a thread for each of `outputs`. Returns the mean times over the threads until
    /// they began, and in which they were busy.
    ///
    /// # Errors
    /// [`MemoryError`] if there is no room for the parts, of which there are as many as `shares`.
    pub(crate) fn traverse<Q: Queries + ?Sized, O: Output>(
        &mut self,
        frame: &DividedFrame<'_, Q>,
        pool: &Pool,
        outputs: &mut [O],
        shares: &mut [Share],
    ) -> Result<[Duration; 2], MemoryError> {
        let called = Instant::now();
        self.assign(frame.nodes, shares.len())?;
        let threads = outputs.len().max(1) as u64;
        // Each output lies there once at a time.
        let mut free = Vec::new();
        reserve(&mut free, outputs.len())?;
        let run = FrameRun {
            workers: self,
            frame,
            called,
            begun: AtomicUsize::new(0),
            idle: AtomicUsize::new(0),
            free: Mutex::new(free),
            waking: AtomicU64::new(0),
            busy: AtomicU64::new(0),
        };
        pool.in_scope(|scope| {
            let slot = |(worker, output)| OutputSlot { output, worker };
            let (run, mut slots) = (&run, outputs.iter_mut().enumerate().map(slot));
            let own = slots.next();
            slots.for_each(|slot| spawn(scope, move |scope, own| run.take_parts(slot, own, scope)));
            let callers = Environment::current();
            with_default(|| own.into_iter().for_each(|slot| run.take_parts(slot, callers, scope)));
        });
        let times = [run.waking, run.busy].map(AtomicU64::into_inner);
        for (share, part) in shares.iter_mut().zip(&self.parts) {
            share.work = part.done.work();
        }
        Ok(times.map(|sum| Duration::from_nanos(sum / threads)))
    }

    /// Assigns the nodes of a front to so many parts, of which nothing is done.
    fn assign(&mut self, nodes: &[FrontNode], parts: usize) -> Result<(), MemoryError> {
        let more = parts.saturating_sub(self.parts.len());
        reserve(&mut self.parts, more)?;
        self.parts.resize_with(parts, PartOfFront::default);
        for part in &mut self.parts {
            let nodes = std::mem::take(&mut part.nodes);
            *part = PartOfFront { nodes, ..PartOfFront::default() };
            part.nodes.clear();
        }
        for (node, position) in nodes.iter().zip(0..) {
            push(&mut self.parts[node.part as usize].nodes, position)?;
        }
        self.costs.clear();
        reserve(&mut self.costs, nodes.len())?;
        self.costs.resize_with(nodes.len(), Tally::default);
        Ok(())
    }

    /// The true cost of each node. Looking at it at all costs a test.
    pub(crate) fn costs(&self) -> impl Iterator<Item = f32> {
        self.costs.iter().map(|tally| 1.0 + tally.work().cost() as f32)
    }
}

/// A traversal under way.
struct FrameRun<'r, Q: ?Sized, O> {
    workers: &'r Workers,
    frame: &'r DividedFrame<'r, Q>,
    called: Instant,
    /// How many parts have been begun.
    begun: AtomicUsize,
    /// The number of free outputs.
    idle: AtomicUsize,
    free: Mutex<Vec<OutputSlot<'r, O>>>,
    /// Sums over the threads, in nanoseconds.
    waking: AtomicU64,
    busy: AtomicU64,
}

/// The output of one thread at a time, and the worker whose work goes into it.
struct OutputSlot<'r, O> {
    output: &'r mut O,
    worker: usize,
}

impl<'r, Q: Queries + ?Sized, O: Output> FrameRun<'r, Q, O> {
    /// Takes parts of which none is begun, and after the last nodes of any part, on a thread whose own floating-point
    /// environment is this one.
    fn take_parts<'s>(
        &'s self,
        mut slot: OutputSlot<'r, O>,
        environment: Environment,
        scope: &Scope<'s>,
    ) where
        'r: 's,
    {
        slot.output.begin(environment);
        let (clock, parts) = (Instant::now(), &self.workers.parts);
        self.waking.fetch_add((clock - self.called).as_nanos() as u64, Relaxed);
        if self.frame.only_one_hit {
            let from_back = slot.worker > 0;
            self.take_nodes(&parts[0], from_back, &mut slot, scope);
            return self.leave(slot, clock);
        }
        while let number = self.begun.fetch_add(1, Relaxed)
            && let Some(part) = parts.get(number)
        {
            if !part.nodes.is_empty() {
                slot.worker = number;
                self.take_nodes(part, false, &mut slot, scope);
            }
        }
        if self.frame.slice.is_some() {
            let (before, from_own) = parts.split_at(slot.worker);
            for part in from_own.iter().chain(before) {
                self.take_nodes(part, false, &mut slot, scope);
            }
        }
        self.leave(slot, clock);
    }

    /// Traverses from the nodes of a part that nobody has begun.
    fn take_nodes<'s>(
        &'s self,
        part: &PartOfFront,
        from_back: bool,
        slot: &mut OutputSlot<'r, O>,
        scope: &Scope<'s>,
    ) where
        'r: 's,
    {
        while let Some(position) = part.next(from_back)
            && !self.frame.control.is_over()
        {
            self.traverse_from(position, None, slot, scope);
        }
    }

    /// Traverses from the node at a position, or what is left of a cursor below it, and gives parts of it away.
    fn traverse_from<'s>(
        &'s self,
        position: u32,
        cursor: Option<Cursor>,
        slot: &mut OutputSlot<'r, O>,
        scope: &Scope<'s>,
    ) where
        'r: 's,
    {
        let DividedFrame { queries, nodes, slice, control, .. } = *self.frame;
        let FrontNode { query: number, pair, .. } = nodes[position as usize];
        let query = queries.query(number);
        let begin = || match pair == NodePair::default() {
            true => query.start(),
            false => Cursor::at(pair),
        };
        let mut cursor = cursor.unwrap_or_else(begin);
        let is_wanted = || slice.is_some() && self.idle.load(Relaxed) > 0;
        while !cursor.is_done() && !control.is_over() {
            let most = slice.map_or(u64::MAX, |slice| cursor.work.tests().saturating_add(slice));
            control.traverse(&query, number, &mut cursor, slot.output, most, &is_wanted);
            if is_wanted() {
                self.give(position, &mut cursor, scope);
            }
        }
        self.workers.parts[slot.worker].done.add(cursor.work);
        self.workers.costs[position as usize].add(cursor.work);
    }

    /// Gives half of a cursor, or what a search comes to last, to another thread, with an output that is free.
    fn give<'s>(&'s self, position: u32, cursor: &mut Cursor, scope: &Scope<'s>)
    where
        'r: 's,
    {
        if cursor.pending().len() < 2 {
            return;
        }
        let mut free = self.free();
        let Some(mut slot) = free.pop() else { return };
        self.idle.store(free.len(), Relaxed);
        drop(free);
        let given = if self.frame.only_one_hit {
            cursor.take_last().map(Cursor::at)
        } else {
            cursor.take_half()
        };
        match given {
            Some(given) => spawn(scope, move |scope, environment| {
                let clock = Instant::now();
                slot.output.begin(environment);
                self.traverse_from(position, Some(given), &mut slot, scope);
                self.leave(slot, clock);
            }),
            None => self.put(slot),
        }
    }

    /// Ends the work of a thread that began at `clock`.
    fn leave(&self, slot: OutputSlot<'r, O>, clock: Instant) {
        slot.output.finish();
        self.busy.fetch_add(clock.elapsed().as_nanos() as u64, Relaxed);
        self.put(slot);
    }

    fn put(&self, slot: OutputSlot<'r, O>) {
        let mut free = self.free();
        free.push(slot);
        self.idle.store(free.len(), Relaxed);
    }

    fn free(&self) -> MutexGuard<'_, Vec<OutputSlot<'r, O>>> {
        // Nothing is ever half done under this lock.
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
