//! Every verb on the CPU, once for all queries: in steps on the calling thread, or on several threads.

use super::threads::ThreadsHistory;
use super::{Answer, Backend, Executor, Named, SLICE, Verb, check, sort};
use crate::Error;
use crate::memory::push;
use crate::{Distance, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Cursor, Gap, PairBvtt, Query};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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
    threads: Option<Box<ThreadsHistory<N>>>,
}

impl<N: Copy + Ord> CpuHistory<N> {
    /// A history without frames.
    pub(crate) fn new(executor: &Executor) -> Self {
        let cancel = executor.cancel.clone();
        let threads = |pool| Box::new(ThreadsHistory::new(pool, cancel.clone()));
        Self { threads: executor.pool.as_ref().map(threads), cancel }
    }

    /// The flag that ends its questions early.
    pub(crate) fn cancel(&self) -> Option<&Arc<AtomicBool>> {
        self.cancel.as_ref()
    }

    /// Counts and times of the last frame on threads.
    #[cfg(feature = "threads")]
    pub(crate) fn report(&self) -> Option<&crate::threads::Report> {
        Some(&self.threads.as_ref()?.traversal.report)
    }

    /// Whether the last frame ended within its first few hundred tests, which several threads do not time either.
    pub(super) fn was_at_once(&self) -> bool {
        self.threads.as_ref().is_some_and(|threads| threads.was_at_once())
    }

    /// Forgets what the last frame took, for a next one that does not resemble it.
    #[cfg(feature = "threads")]
    pub(crate) fn forget(&mut self) {
        self.threads.iter_mut().for_each(|threads| threads.traversal.forget());
    }

    /// The smallest distance of two meshes, and which part of the CPU found it.
    pub(crate) fn distance(
        &self,
        tree: &PairBvtt<'_>,
        at_most: Option<Distance>,
        seed: Option<TrianglePair>,
    ) -> (Backend, Result<Option<Gap>, Error>) {
        let cancel = self.cancel.as_deref();
        if let Some(threads) = &self.threads {
            let (backend, gap) = threads.distance(tree, at_most, seed, cancel);
            return (backend, check(cancel).map(|()| gap));
        }
        let mut search = tree.search(at_most, seed);
        while !search.is_done() {
            if let Err(error) = check(cancel) {
                return (Backend::Sequential, Err(error));
            }
            tree.seek(&mut search, SLICE);
        }
        (Backend::Sequential, Ok(search.gap()))
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
        if let Some(threads) = &mut self.threads {
            return threads.ask_one(name, tree, verb, list);
        }
        let answer = on_one_thread((name, tree), verb, self.cancel.as_deref(), list);
        (Backend::Sequential, answer.map(|answer| answer.with(verb, list)))
    }

    /// The same about many subjects, given in the order of their names, each of which has a tree that is not empty: in turn on
    /// the calling thread, together on several.
    pub(crate) fn ask_many<'q, F: Named<Name = N>, S: Copy + Sync>(
        &mut self,
        subjects: impl Iterator<Item = (N, S)>,
        tree: impl Fn(&S) -> AnyBvtt<'q> + Sync,
        verb: Verb,
        list: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        list.clear();
        if let Some(threads) = &mut self.threads {
            return threads.ask_many(subjects, tree, verb, list);
        }
        let mut whole = Answer::counted(0);
        for (name, subject) in subjects {
            match on_one_thread((name, &tree(&subject)), verb, self.cancel.as_deref(), list) {
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
