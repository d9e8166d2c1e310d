//! The smallest distance of two meshes, on the threads of a pool.
//!
//! The calling thread begins alone: to come near the answer is sequential, and most searches end before it would pay to call others.
//! Once it has taken as long as that, it gives half of the node pairs that are left to another thread whenever one is free, and so
//! does every other. All share the least distance that any has reached.

use crate::Pool;
use crate::pool::spawn;
use pfront_core::Distance;
use pfront_core::bvtt::{Gap, PairBvtt, Search, TrianglePair};
use pfront_core::environment::with_default;
use rayon::Scope;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::thread::ThreadId;
use std::time::Instant;

/// Tests between two looks at what other threads have reached.
const SLICE: u64 = 512;

impl Pool {
    /// [`PairBvtt::distance`] on the threads of the pool, the same to the bit unless triangles intersect: which of these are named may
    /// then differ. Also returns whether another thread has worked too. If the flag is set, the gap is not the answer.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::PairBvtt, *};
    /// use pfront_cpu::Pool;
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.0, 0.0, 0.25]))?;
    /// let (gap, _) = Pool::new(8).distance(&query, None, None, None);
    /// assert_eq!(gap, query.distance(None, None));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn distance(
        &self,
        query: &PairBvtt<'_>,
        at_most: Option<Distance>,
        seed: Option<TrianglePair>,
        cancel: Option<&AtomicBool>,
    ) -> (Option<Gap>, bool) {
        let run = Run {
            query,
            cancel,
            begun: Instant::now(),
            alone: self.worth().unwrap_or_default(),
            threads: self.threads(),
            at_work: AtomicUsize::new(1),
            caller: std::thread::current().id(),
            is_shared: AtomicBool::new(false),
            reach: AtomicI32::new(f32::INFINITY.to_bits().cast_signed()),
            found: Mutex::new(None),
        };
        let search = with_default(|| query.search(at_most, seed));
        // A thread that waits for the others may do something else, in its own environment.
        self.in_scope(|scope| with_default(|| run.search(search, scope)));
        let found: Option<Search> = run.found.into_inner().unwrap_or_else(PoisonError::into_inner);
        (found.and_then(|found| found.gap()), run.is_shared.into_inner())
    }
}

/// The state that the threads of a search share.
struct Run<'r, 'a> {
    query: &'r PairBvtt<'a>,
    cancel: Option<&'r AtomicBool>,
    begun: Instant,
    /// The seconds that the calling thread works alone.
    alone: f64,
    threads: usize,
    /// Parts of the search that are not done.
    at_work: AtomicUsize,
    caller: ThreadId,
    /// Whether another thread than the caller has worked.
    is_shared: AtomicBool,
    /// The least reach, by its bits: below 0 they are less than all others as those of integers.
    reach: AtomicI32,
    /// The findings of the threads that are done.
    found: Mutex<Option<Search>>,
}

impl<'r> Run<'r, '_> {
    fn search<'s>(&'s self, mut search: Search, scope: &Scope<'s>)
    where
        'r: 's,
    {
        if std::thread::current().id() != self.caller {
            self.is_shared.store(true, Relaxed);
        }
        while !search.is_done() && !self.cancel.is_some_and(|flag| flag.load(Relaxed)) {
            self.query.seek(&mut search, SLICE);
            let own = search.reach().to_bits().cast_signed();
            let least = self.reach.fetch_min(own, Relaxed).min(own);
            search.tighten(f32::from_bits(least.cast_unsigned()));
            let more = |parts| (parts < self.threads).then_some(parts + 1);
            if self.begun.elapsed().as_secs_f64() >= self.alone
                && self.at_work.fetch_update(Relaxed, Relaxed, more).is_ok()
            {
                match search.take_half() {
                    Some(half) => spawn(scope, move |scope, _| self.search(half, scope)),
                    None => _ = self.at_work.fetch_sub(1, Relaxed),
                }
            }
        }
        self.at_work.fetch_sub(1, Relaxed);
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *found {
            Some(found) => found.add(&search),
            None => *found = Some(search),
        }
    }
}
