//! Several threads: an executor of them, and what a query remembers of its frames there.

use super::{Answer, BLOCK, Backend, Executor, Named, Verb, check};
use crate::Error;
use crate::memory::{extend, push, reserve};
pub(super) use crate::threads::Pool;
use crate::threads::rayon::{Yield, yield_now};
use crate::threads::{Hit, MemoryError, Queries, Report, Schedule, Traversal};
use crate::{Distance, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Gap, NodePair, PairBvtt};
use pfront_core::front::STARTING_NODES;
use std::mem::take;
use std::slice::from_ref;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

impl Executor {
    /// Several threads: each frame that is worth it is divided into `workers` parts, or into fewer where to call so many takes longer, which run in the rayon pool of whoever
    /// asks. A number beyond [`MAX_WORKERS`](crate::threads::MAX_WORKERS) is lowered to that. A rayon pool and settings
    /// of your own: `Executor::from(pool)`.
    ///
    /// # Examples
    /// ```
    /// use pfront::threads::{Pool, Schedule, Settings};
    /// use pfront::{Executor, PairQuery};
    /// let query = PairQuery::new().on(&Executor::threads(8));
    /// // With settings of your own:
    /// let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
    /// let query = PairQuery::new().on(&Pool::new(8).with_settings(settings).into());
    /// ```
    #[must_use]
    pub fn threads(workers: usize) -> Self {
        Pool::new(workers).into()
    }
}

impl From<Pool> for Executor {
    /// Several threads. The time that it takes to call all others, half of them, and so on is measured, some 7 ms each, except under [`Schedule::Static`], whose counts are
    /// to be the same on every machine.
    fn from(pool: Pool) -> Self {
        let is_static = pool.settings.schedule == Schedule::Static;
        let pool = Some(if is_static { pool } else { pool.measured() });
        Self { pool, ..Self::default() }
    }
}

impl From<MemoryError> for Error {
    fn from(error: MemoryError) -> Self {
        Self::Memory { needed: error.needed }
    }
}

/// A thread of a pool looks so often whether there is work that only it can do.
const IDLE: Duration = Duration::from_micros(100);

/// Does something that waits in the pool of this thread, if it is one of a pool; else returns how long it may wait, at most so
/// long.
pub(crate) fn wait_in_pool(most: Duration) -> Option<Duration> {
    match yield_now() {
        Some(Yield::Executed) => None,
        Some(Yield::Idle) => Some(most.min(IDLE)),
        None => Some(most),
    }
}

/// All threads of the rayon pool of the caller.
pub(super) fn all() -> Option<Pool> {
    Executor::from(Pool::default()).pool
}

/// The most subjects that are asked about at once. Each takes some 200 bytes with its node of the front, so that all of them take
/// 13 MiB at most, however many pairs a frame has.
const BATCH: usize = 1 << 16;

/// A query on the threads of a pool.
#[derive(Clone, Debug)]
pub(super) struct ThreadsHistory<N> {
    pub(super) traversal: Traversal,
    /// The names of the subjects of the last batch, by whose numbers the traversal remembers what each cost.
    asked: Vec<N>,
    /// The names of the subjects of this batch.
    asking: Vec<N>,
    numbered: Vec<Hit>,
}

/// The trees of subjects, each made by the thread that traverses it.
struct Trees<'t, S, T> {
    subjects: &'t [S],
    tree: &'t T,
}

impl<'q, S: Sync, T: Fn(&S) -> AnyBvtt<'q> + Sync> Queries for Trees<'_, S, T> {
    type Query<'t>
        = AnyBvtt<'q>
    where
        Self: 't;

    fn len(&self) -> usize {
        self.subjects.len()
    }

    fn query(&self, number: u32) -> AnyBvtt<'q> {
        (self.tree)(&self.subjects[number as usize])
    }

    /// None of them is empty, and most roots overlap.
    fn root(&self, _: u32) -> Option<NodePair> {
        Some(NodePair::default())
    }
}

/// Every verb, about some trees by their names, on the threads at once. Pairs are added to the list, which is empty where its items
/// are pairs without names.
fn ask_batch<F: Named>(
    traversal: &mut Traversal,
    names: &[F::Name],
    trees: &(impl Queries + ?Sized),
    verb: Verb,
    numbered: &mut Vec<Hit>,
    list: &mut Vec<F>,
) -> Result<Answer<F>, Error> {
    Ok(match verb {
        Verb::All => {
            let before = list.len();
            match F::as_pairs(list) {
                Some(pairs) => traversal.all(trees, pairs)?,
                None => {
                    traversal.all(trees, numbered)?;
                    for block in numbered.chunks(BLOCK) {
                        check(traversal.cancel.as_deref())?;
                        let named = |hit: &Hit| F::new(names[hit.query as usize], hit.pair);
                        extend(list, block.iter().map(named))?;
                    }
                }
            }
            Answer::counted((list.len() - before) as u64)
        }
        Verb::Count => Answer::counted(traversal.count(trees)?),
        Verb::Any => {
            let hit = traversal.any(trees)?;
            Answer::found(hit.map(|hit| F::new(names[hit.query as usize], hit.pair)))
        }
    })
}

impl<N: Copy + Ord> ThreadsHistory<N> {
    pub(super) fn new(pool: &Pool, cancel: Option<Arc<AtomicBool>>) -> Self {
        let mut traversal = Traversal::new(pool);
        traversal.cancel = cancel;
        Self { traversal, asked: Vec::new(), asking: Vec::new(), numbered: Vec::new() }
    }

    /// Whether the last frame ended within its first few hundred tests, which the traversal does not time either.
    pub(super) fn was_at_once(&self) -> bool {
        let Report { shares, traversal_time, .. } = &self.traversal.report;
        shares.is_empty() && traversal_time.is_zero()
    }

    /// [`CpuHistory::distance`](super::CpuHistory::distance).
    pub(super) fn distance(
        &self,
        tree: &PairBvtt<'_>,
        at_most: Option<Distance>,
        seed: Option<TrianglePair>,
        cancel: Option<&AtomicBool>,
    ) -> (Backend, Option<Gap>) {
        let (gap, is_shared) = self.traversal.pool.distance(tree, at_most, seed, cancel);
        (if is_shared { Backend::Threads } else { Backend::Sequential }, gap)
    }

    /// [`CpuHistory::ask`](super::CpuHistory::ask).
    pub(super) fn ask_one<F: Named<Name = N>>(
        &mut self,
        name: N,
        tree: &AnyBvtt<'_>,
        verb: Verb,
        list: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        self.reported(|own| {
            let (names, trees) = (from_ref(&name), from_ref(tree));
            let answer = ask_batch(&mut own.traversal, names, trees, verb, &mut Vec::new(), list)?;
            Ok(answer.with(verb, list))
        })
    }

    /// [`CpuHistory::ask_many`](super::CpuHistory::ask_many).
    pub(super) fn ask_many<'q, F: Named<Name = N>, S: Copy + Sync>(
        &mut self,
        subjects: impl Iterator<Item = (N, S)>,
        tree: impl Fn(&S) -> AnyBvtt<'q> + Sync,
        verb: Verb,
        list: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        self.reported(|own| Ok(own.ask_subjects(subjects, tree, verb, list)?.with(verb, list)))
    }

    /// Runs a question, and tells which part of the CPU answered.
    fn reported<A>(
        &mut self,
        ask: impl FnOnce(&mut Self) -> Result<A, Error>,
    ) -> (Backend, Result<A, Error>) {
        // A question that ends before it traverses anything leaves the report as it was.
        self.traversal.report.cancelled = false;
        self.traversal.report.shares.clear();
        let answer = ask(self);
        let Report { shares, cancelled, .. } = &self.traversal.report;
        let part = if shares.is_empty() { Backend::Sequential } else { Backend::Threads };
        let unless_cancelled = |answer| if *cancelled { Err(Error::Cancelled) } else { Ok(answer) };
        (part, answer.and_then(unless_cancelled))
    }

    fn ask_subjects<'q, F: Named<Name = N>, S: Copy + Sync>(
        &mut self,
        subjects: impl Iterator<Item = (N, S)>,
        tree: impl Fn(&S) -> AnyBvtt<'q> + Sync,
        verb: Verb,
        list: &mut Vec<F>,
    ) -> Result<Answer<F>, Error> {
        let (mut whole, mut numbered) = (Answer::counted(0), take(&mut self.numbered));
        // A front divides the roots of so few, so that each tree would be made several times.
        let mut few = Vec::new();
        let mut ask_some = |traversal: &mut Traversal, names: &[N], subjects: &[S]| {
            let answer = if subjects.len() < STARTING_NODES {
                few.clear();
                reserve(&mut few, subjects.len())?;
                few.extend(subjects.iter().map(&tree));
                ask_batch(traversal, names, &few, verb, &mut numbered, list)?
            } else {
                let trees = &Trees { subjects, tree: &tree };
                ask_batch(traversal, names, trees, verb, &mut numbered, list)?
            };
            whole = whole.and(answer);
            Ok(whole.first.is_some())
        };
        match verb {
            Verb::Any => self.each_until_found(subjects, &mut ask_some)?,
            Verb::All | Verb::Count => self.each_batch(subjects, &mut ask_some)?,
        }
        self.numbered = numbered;
        Ok(whole)
    }

    /// Asks about subjects, of which nothing is remembered, until one is found that has a pair.
    fn each_until_found<S>(
        &mut self,
        mut rest: impl Iterator<Item = (N, S)>,
        ask: &mut impl FnMut(&mut Traversal, &[N], &[S]) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let mut batch = Vec::new();
        // Batches grow, so that not much more is prepared than is asked.
        let (mut is_over, mut size) = (false, 1);
        while !is_over && !self.traversal.report.cancelled {
            self.asking.clear();
            for (name, subject) in rest.by_ref().take(size) {
                push(&mut self.asking, name)?;
                push(&mut batch, subject)?;
            }
            is_over = batch.is_empty() || ask(&mut self.traversal, &self.asking, &batch)?;
            batch.clear();
            size = (4 * size).min(BATCH);
        }
        Ok(())
    }

    /// Asks about subjects in batches of at most [`BATCH`], until the flag is set. The report of the traversal is
    /// then that of all batches together.
    fn each_batch<S>(
        &mut self,
        subjects: impl Iterator<Item = (N, S)>,
        ask: &mut impl FnMut(&mut Traversal, &[N], &[S]) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let mut batch = Vec::new();
        let mut rest = subjects.peekable();
        let mut before: Option<Report> = None;
        let mut is_divided = false;
        loop {
            self.asking.clear();
            for (name, subject) in rest.by_ref().take(BATCH) {
                push(&mut self.asking, name)?;
                push(&mut batch, subject)?;
            }
            let is_last = rest.peek().is_none();
            if before.is_none() && is_last {
                self.renumber()?;
            } else {
                // The costs of other subjects tell nothing of these.
                is_divided = true;
                self.traversal.forget();
                std::mem::swap(&mut self.asked, &mut self.asking);
            }
            ask(&mut self.traversal, &self.asked, &batch)?;
            batch.clear();
            if let Some(mut report) = before.take() {
                report.add(&self.traversal.report);
                self.traversal.report = report;
            }
            if is_last || self.traversal.report.cancelled {
                break;
            }
            before = Some(self.traversal.report.clone());
        }
        if is_divided {
            // The next frame resembles all batches together, of which nothing is remembered.
            self.traversal.forget();
        }
        Ok(())
    }

    /// Makes the names of this frame those of the last, and keeps what is remembered of trees that are in both.
    fn renumber(&mut self) -> Result<(), Error> {
        if self.asking == self.asked {
            return Ok(());
        }
        // Both ascend, so that one pass finds them all.
        let mut rest = (0..).zip(&self.asking).peekable();
        let number = |name: &N| {
            while rest.next_if(|(_, new)| *new < name).is_some() {}
            rest.next_if(|(_, new)| *new == name).map(|(number, _)| number)
        };
        let mut numbers = Vec::new();
        reserve(&mut numbers, self.asked.len())?;
        numbers.extend(self.asked.iter().map(number));
        self.traversal.renumber(|old| numbers[old as usize]);
        std::mem::swap(&mut self.asked, &mut self.asking);
        Ok(())
    }
}
