//! Every verb on the CPU, once for all queries: in steps on the calling thread, or on several threads.

use super::{Answer, Backend, Executor, SLICE, Verb, check, sort};
use crate::memory::push;
use crate::subject::AnyBvtt;
use crate::{Error, TrianglePair};
use pfront_core::bvtt::{Cursor, Query};
use std::ops::ControlFlow;
#[cfg(feature = "threads")]
use std::slice::from_ref;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// An intersecting triangle pair, as a query shows it.
pub(crate) trait Named: Copy + Ord + Send + Sync {
    /// What tells its subject from the others of a frame.
    type Name: Copy + Ord;

    fn new(name: Self::Name, pair: TrianglePair) -> Self;

    fn name(&self) -> Self::Name;

    fn pair(&self) -> TrianglePair;

    /// Adds all pairs of some trees to a list, sorted. That of a subject without a name is replaced.
    #[cfg(feature = "threads")]
    fn list(
        traversal: &mut crate::threads::Traversal,
        names: &[Self::Name],
        trees: &[AnyBvtt<'_>],
        numbered: &mut Vec<crate::threads::Hit>,
        list: &mut Vec<Self>,
    ) -> Result<(), Error>;
}

/// The pairs of a single subject.
impl Named for TrianglePair {
    type Name = ();

    fn new((): (), pair: TrianglePair) -> Self {
        pair
    }

    fn name(&self) {}

    fn pair(&self) -> TrianglePair {
        *self
    }

    #[cfg(feature = "threads")]
    fn list(
        traversal: &mut crate::threads::Traversal,
        _: &[()],
        trees: &[AnyBvtt<'_>],
        _: &mut Vec<crate::threads::Hit>,
        list: &mut Vec<Self>,
    ) -> Result<(), Error> {
        Ok(traversal.all(trees, list)?)
    }
}

/// Goes on with a question about one subject on the calling thread, for at most about so many tests. Under [`Verb::All`] the
/// pairs are added to a list, in the order in which they are found. Returns whether nothing is left.
///
/// # Errors
/// [`Error::Memory`] if the list cannot grow, which then is empty and holds no memory.
pub(crate) fn step<F: Named>(
    (name, tree): (F::Name, &impl Query),
    cursor: &mut Cursor,
    budget: u64,
    verb: Verb,
    answer: &mut Answer<F>,
    list: &mut Vec<F>,
) -> Result<bool, Error> {
    let mut failure = None;
    let end = tree.step(cursor, budget, |pair| match verb {
        Verb::All => {
            if let Err(error) = push(list, F::new(name, pair)) {
                failure = Some(error);
                return ControlFlow::Break(());
            }
            answer.count += 1;
            ControlFlow::Continue(())
        }
        Verb::Count => {
            answer.count += 1;
            ControlFlow::Continue(())
        }
        Verb::Any => {
            *answer = Answer::found(Some(F::new(name, pair)));
            ControlFlow::Break(())
        }
    });
    if let Some(error) = failure {
        *list = Vec::new();
        return Err(error);
    }
    Ok(end.is_break() || cursor.is_done())
}

/// Answers about one subject on the calling thread, until the flag is set.
fn on_one_thread<F: Named>(
    named: (F::Name, &impl Query),
    verb: Verb,
    cancel: Option<&AtomicBool>,
    list: &mut Vec<F>,
) -> Result<Answer<F>, Error> {
    let budget = if cancel.is_some() { SLICE } else { u64::MAX };
    let (first, mut answer, mut cursor) = (list.len(), Answer::counted(0), named.1.start());
    let mut is_over = cursor.is_done();
    while !is_over {
        check(cancel)?;
        is_over = step(named, &mut cursor, budget, verb, &mut answer, list)?;
    }
    sort(&mut list[first..], cancel)?;
    Ok(answer)
}

/// A query on the CPU of an executor, and what it remembers from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct CpuHistory<N> {
    cancel: Option<Arc<AtomicBool>>,
    /// One thread remembers nothing.
    #[cfg(feature = "threads")]
    threads: Option<Box<several::ThreadsHistory<N>>>,
    #[cfg(not(feature = "threads"))]
    names: std::marker::PhantomData<N>,
}

impl<N: Copy + Ord> CpuHistory<N> {
    /// A history without frames.
    pub(crate) fn new(executor: &Executor) -> Self {
        Self {
            cancel: executor.cancel.clone(),
            #[cfg(feature = "threads")]
            threads: executor
                .pool
                .as_ref()
                .map(|pool| Box::new(several::ThreadsHistory::new(pool, executor.cancel.clone()))),
            #[cfg(not(feature = "threads"))]
            names: std::marker::PhantomData,
        }
    }

    /// Counts and times of the last frame on threads.
    #[cfg(feature = "threads")]
    pub(crate) fn report(&self) -> Option<&crate::threads::Report> {
        Some(&self.threads.as_ref()?.traversal.report)
    }

    /// Forgets what the last frame took, for a next one that does not resemble it.
    #[cfg(feature = "threads")]
    pub(crate) fn forget(&mut self) {
        self.threads.iter_mut().for_each(|threads| threads.traversal.forget());
    }

    /// Answers about one subject, and tells which part of the CPU did. The list is replaced, under [`Verb::All`] by all
    /// pairs, sorted.
    pub(crate) fn ask<F: Named<Name = N>>(
        &mut self,
        name: N,
        tree: &AnyBvtt<'_>,
        verb: Verb,
        list: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        list.clear();
        #[cfg(feature = "threads")]
        if let Some(threads) = &mut self.threads {
            return threads.reported(|threads| {
                let (names, trees) = (from_ref(&name), from_ref(tree));
                let traversal = &mut threads.traversal;
                let answer = several::ask(traversal, names, trees, verb, &mut Vec::new(), list)?;
                Ok(answer.with(verb, list))
            });
        }
        let answer = on_one_thread((name, tree), verb, self.cancel.as_deref(), list);
        (Backend::Sequential, answer.map(|answer| answer.with(verb, list)))
    }

    /// The same about many subjects, in the order of their names.
    pub(crate) fn ask_in_turn<'q, F: Named<Name = N>>(
        &mut self,
        trees: impl Iterator<Item = (N, AnyBvtt<'q>)>,
        verb: Verb,
        list: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        list.clear();
        #[cfg(feature = "threads")]
        if let Some(threads) = &mut self.threads {
            return threads
                .reported(|threads| Ok(threads.ask(trees, verb, list)?.with(verb, list)));
        }
        let mut whole = Answer::counted(0);
        for (name, tree) in trees {
            match on_one_thread((name, &tree), verb, self.cancel.as_deref(), list) {
                Ok(answer) => whole = whole.and(answer),
                Err(error) => return (Backend::Sequential, Err(error)),
            }
            if whole.first.is_some() {
                break;
            }
        }
        (Backend::Sequential, Ok(whole.with(verb, list)))
    }
}

#[cfg(feature = "threads")]
mod several {
    use super::*;
    use crate::memory::reserve;
    use crate::threads::{Hit, Pool, Report, Traversal};
    use std::mem::take;

    /// The most trees that are asked at once. Each takes some 1,300 bytes with its node of the front, so that all of them take
    /// 85 MiB at most, however many pairs a frame has.
    const BATCH: usize = 1 << 16;

    /// A query on the threads of a pool.
    #[derive(Clone, Debug)]
    pub(super) struct ThreadsHistory<N> {
        pub(super) traversal: Traversal,
        /// The names of the trees of the last batch: what each cost is remembered by its number.
        asked: Vec<N>,
        /// The names of the trees of this batch.
        asking: Vec<N>,
        /// Empty, to use its memory again.
        trees: Vec<AnyBvtt<'static>>,
        numbered: Vec<Hit>,
    }

    /// Every verb, about some trees by their names. Pairs are added to the list.
    pub(super) fn ask<F: Named>(
        traversal: &mut Traversal,
        names: &[F::Name],
        trees: &[AnyBvtt<'_>],
        verb: Verb,
        numbered: &mut Vec<Hit>,
        list: &mut Vec<F>,
    ) -> Result<Answer<F>, Error> {
        Ok(match verb {
            Verb::All => {
                let before = list.len();
                F::list(traversal, names, trees, numbered, list)?;
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
            let (asked, asking, trees) = (Vec::new(), Vec::new(), Vec::new());
            Self { traversal, asked, asking, trees, numbered: Vec::new() }
        }

        /// Runs a question, and tells which part of the CPU answered.
        pub(super) fn reported<A>(
            &mut self,
            ask: impl FnOnce(&mut Self) -> Result<A, Error>,
        ) -> (Backend, Result<A, Error>) {
            // A question that ends before it traverses anything leaves the report as it was.
            self.traversal.report.cancelled = false;
            self.traversal.report.shares.clear();
            let answer = ask(self);
            let Report { shares, cancelled, .. } = &self.traversal.report;
            let part = if shares.is_empty() { Backend::Sequential } else { Backend::Threads };
            let unless_cancelled =
                |answer| if *cancelled { Err(Error::Cancelled) } else { Ok(answer) };
            (part, answer.and_then(unless_cancelled))
        }

        pub(super) fn ask<'q, F: Named<Name = N>>(
            &mut self,
            trees: impl Iterator<Item = (N, AnyBvtt<'q>)>,
            verb: Verb,
            list: &mut Vec<F>,
        ) -> Result<Answer<F>, Error> {
            let (mut whole, mut numbered) = (Answer::counted(0), take(&mut self.numbered));
            let mut ask_some = |traversal: &mut Traversal, names: &[N], trees: &[AnyBvtt<'_>]| {
                whole = whole.and(ask(traversal, names, trees, verb, &mut numbered, list)?);
                Ok(whole.first.is_some())
            };
            match verb {
                Verb::Any => self.each_until_found(trees, &mut ask_some)?,
                Verb::All | Verb::Count => self.each_batch(trees, &mut ask_some)?,
            }
            self.numbered = numbered;
            Ok(whole)
        }

        /// Asks about trees, of which nothing is remembered, until one is found that has a pair.
        fn each_until_found<'q>(
            &mut self,
            mut rest: impl Iterator<Item = (N, AnyBvtt<'q>)>,
            ask: &mut impl FnMut(&mut Traversal, &[N], &[AnyBvtt<'_>]) -> Result<bool, Error>,
        ) -> Result<(), Error> {
            let mut batch: Vec<AnyBvtt<'_>> = take(&mut self.trees);
            // Batches grow, so that not much more is prepared than is asked.
            let (mut is_over, mut size) = (false, 1);
            while !is_over && !self.traversal.report.cancelled {
                self.asking.clear();
                for (name, tree) in rest.by_ref().take(size) {
                    push(&mut self.asking, name)?;
                    push(&mut batch, tree)?;
                }
                is_over = batch.is_empty() || ask(&mut self.traversal, &self.asking, &batch)?;
                batch.clear();
                size = (4 * size).min(BATCH);
            }
            self.trees = emptied(batch);
            Ok(())
        }

        /// Asks about trees in batches of at most [`BATCH`], until time runs out or the flag is set. The report of the traversal is
        /// then that of all batches together.
        fn each_batch<'q>(
            &mut self,
            trees: impl Iterator<Item = (N, AnyBvtt<'q>)>,
            ask: &mut impl FnMut(&mut Traversal, &[N], &[AnyBvtt<'_>]) -> Result<bool, Error>,
        ) -> Result<(), Error> {
            let mut batch: Vec<AnyBvtt<'_>> = take(&mut self.trees);
            let mut rest = trees.peekable();
            let mut before: Option<Report> = None;
            loop {
                self.asking.clear();
                for (name, tree) in rest.by_ref().take(BATCH) {
                    push(&mut self.asking, name)?;
                    push(&mut batch, tree)?;
                }
                let is_last = rest.peek().is_none();
                if before.is_none() && is_last {
                    self.renumber()?;
                } else {
                    // The costs of other trees tell nothing of these.
                    self.traversal.forget();
                    std::mem::swap(&mut self.asked, &mut self.asking);
                }
                ask(&mut self.traversal, &self.asked, &batch)?;
                batch.clear();
                if let Some(mut report) = before.take() {
                    report.add(&self.traversal.report);
                    self.traversal.report = report;
                }
                if is_last || self.traversal.report.late || self.traversal.report.cancelled {
                    break;
                }
                before = Some(self.traversal.report.clone());
            }
            self.trees = emptied(batch);
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

    /// An empty vector of one lifetime becomes one of another, in place.
    fn emptied(trees: Vec<AnyBvtt<'_>>) -> Vec<AnyBvtt<'static>> {
        trees.into_iter().map_while(|_| None).collect()
    }
}
