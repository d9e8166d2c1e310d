//! The search for one hit on several threads.
//!
//! The calling thread searches in the order in which it would alone. Others take what it would come to last, so that it comes
//! to the first hit no later than it would alone, whatever they do.

use crate::control::{Control, tests};
use crate::front::Start;
use crate::memory::reserve;
use crate::output::Output;
use crate::pool::spawn;
use crate::report::sum;
use crate::{MemoryError, Pool, Share};
use pfront_core::bvtt::{Cursor, Query};
use pfront_core::environment::{Environment, with_default};
use rayon::Scope;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Tests between two looks at whether a thread has nothing to do.
const STEP: u64 = 512;

/// The question, as all threads see it.
pub(crate) struct Search<'s, Q> {
    pub(crate) queries: &'s [Q],
    /// Node pairs that nobody has begun, in the order of the search.
    pub(crate) starts: &'s [Start],
    pub(crate) control: &'s Control,
}

impl<Q: Query + Sync> Search<'_, Q> {
    /// Searches with a thread for each of `outputs` and `shares`, of which the first are those of the calling thread.
    ///
    /// # Errors
    /// [`MemoryError`] if there is no room to note threads that have nothing to do.
    pub(crate) fn run<O: Output>(
        &self,
        pool: &Pool,
        outputs: &mut [O],
        shares: &mut [Share],
    ) -> Result<(), MemoryError> {
        // Each output lies there once at a time.
        let mut free = Vec::new();
        reserve(&mut free, outputs.len())?;
        let [taken, from_back, idle] = [0; 3].map(AtomicUsize::new);
        let run = SharedSearch { search: self, taken, from_back, idle, free: Mutex::new(free) };
        pool.in_scope(|scope| {
            let slot = |(output, share)| Slot { output, share };
            let (run, mut slots) = (&run, outputs.iter_mut().zip(shares).map(slot));
            let own = slots.next();
            slots.for_each(|slot| {
                spawn(scope, move |scope, thread| run.take_from_back(slot, thread, scope));
            });
            let callers = Environment::current();
            with_default(|| {
                own.into_iter().for_each(|slot| run.take_from_front(slot, callers, scope));
            });
        });
        Ok(())
    }
}

/// A search under way, as its threads share it.
struct SharedSearch<'r, Q, O> {
    search: &'r Search<'r, Q>,
    /// How many starts have been taken, and how many of them from the back.
    taken: AtomicUsize,
    from_back: AtomicUsize,
    /// The number of free slots.
    idle: AtomicUsize,
    free: Mutex<Vec<Slot<'r, O>>>,
}

/// The output of one thread at a time, and its share of the work.
struct Slot<'r, O> {
    output: &'r mut O,
    share: &'r mut Share,
}

impl<'r, Q: Query + Sync, O: Output> SharedSearch<'r, Q, O> {
    /// Searches from the first start on, on a thread whose own floating-point environment is this one.
    fn take_from_front<'s>(&'s self, mut slot: Slot<'r, O>, thread: Environment, scope: &Scope<'s>)
    where
        'r: 's,
    {
        slot.output.begin(thread);
        for start in self.search.starts {
            if !self.may_take() {
                break;
            }
            self.search_below(*start, &mut slot, scope);
        }
        self.put(slot);
    }

    /// Searches from the last start on.
    fn take_from_back<'s>(&'s self, mut slot: Slot<'r, O>, thread: Environment, scope: &Scope<'s>)
    where
        'r: 's,
    {
        slot.output.begin(thread);
        while self.may_take()
            && let Some(start) =
                self.search.starts.iter().rev().nth(self.from_back.fetch_add(1, Relaxed))
        {
            self.search_below(*start, &mut slot, scope);
        }
        self.put(slot);
    }

    /// Whether one more start may be taken: as many times as there are starts, so that no two threads take the same.
    fn may_take(&self) -> bool {
        let all = self.search.starts.len();
        !self.search.control.is_over()
            && self.taken.load(Relaxed) < all
            && self.taken.fetch_add(1, Relaxed) < all
    }

    /// Searches below a node pair, and gives away what would come last.
    fn search_below<'s>(&'s self, start: Start, slot: &mut Slot<'r, O>, scope: &Scope<'s>)
    where
        'r: 's,
    {
        let Search { queries, control, .. } = *self.search;
        let mut cursor = Cursor::at(start.pair);
        while !cursor.is_done() && !control.is_over() {
            let (query, next) = (&queries[start.query as usize], tests(cursor.work) + STEP);
            control.traverse(query, start.query, &mut cursor, slot.output, next, &|| false);
            if self.idle.load(Relaxed) > 0 {
                self.give(start.query, &mut cursor, scope);
            }
        }
        slot.share.work = sum(slot.share.work, cursor.work);
    }

    /// Gives the node pair that a cursor would come to last to another thread, with a slot that is free.
    fn give<'s>(&'s self, query: u32, cursor: &mut Cursor, scope: &Scope<'s>)
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
        match cursor.take_last() {
            Some(pair) => spawn(scope, move |scope, thread| {
                slot.output.begin(thread);
                self.search_below(Start { query, pair }, &mut slot, scope);
                self.put(slot);
            }),
            None => self.put(slot),
        }
    }

    fn put(&self, slot: Slot<'r, O>) {
        let mut free = self.free();
        free.push(slot);
        self.idle.store(free.len(), Relaxed);
    }

    fn free(&self) -> MutexGuard<'_, Vec<Slot<'r, O>>> {
        // Nothing is ever half done under this lock.
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
