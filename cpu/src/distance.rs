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
use std::time::Instant;

/// Tests between two looks at what other threads have reached.
const SLICE: u64 = 512;

impl Pool {
    /// [`PairBvtt::distance`] on the threads of the pool, the same to the bit unless triangles intersect: which are told may then
    /// be others. Returns how many threads have worked too; what had been found when the flag was set is not the answer.
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
    /// let (gap, threads) = Pool::new(8).distance(&query, None, None, None);
    /// assert_eq!((gap, threads), (query.distance(None, None), 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn distance(
        &self,
        query: &PairBvtt<'_>,
        at_most: Option<Distance>,
        seed: Option<TrianglePair>,
        cancel: Option<&AtomicBool>,
    ) -> (Option<Gap>, usize) {
        let run = Run {
            query,
            cancel,
            begun: Instant::now(),
            alone: self.call.unwrap_or_default(),
            threads: self.threads(),
            at_work: AtomicUsize::new(1),
            most: AtomicUsize::new(1),
            reach: AtomicI32::new(f32::INFINITY.to_bits().cast_signed()),
            found: Mutex::new(None),
        };
        with_default(|| {
            let search = query.search(at_most, seed);
            self.in_scope(|scope| run.search(search, scope));
        });
        let found: Option<Search> = run.found.into_inner().unwrap_or_else(PoisonError::into_inner);
        (found.and_then(|found| found.gap()), run.most.into_inner())
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
    /// Threads that are searching now, and the most that ever were.
    at_work: AtomicUsize,
    most: AtomicUsize,
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
        while !search.is_done() && !self.cancel.is_some_and(|flag| flag.load(Relaxed)) {
            self.query.seek(&mut search, SLICE);
            let own = search.reach().to_bits().cast_signed();
            let least = self.reach.fetch_min(own, Relaxed).min(own);
            search.tighten(f32::from_bits(least.cast_unsigned()));
            if self.at_work.load(Relaxed) < self.threads
                && self.begun.elapsed().as_secs_f64() >= self.alone
                && let Some(half) = search.take_half()
            {
                let at_work = self.at_work.fetch_add(1, Relaxed) + 1;
                self.most.fetch_max(at_work, Relaxed);
                spawn(scope, move |scope, _| self.search(half, scope));
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
