//! Answering a batch on the CPU: in slices on one thread, or on a pool.

use super::Job;
use super::found::Found;
use crate::executor::{Answer, SLICE, Verb, step};
use crate::memory::push;
use crate::{Error, TrianglePair};
use pfront_core::bvtt::{Cursor, Query, Work};
use std::ops::Range;

/// To begin a question costs as much as so many tests.
const BEGIN: u64 = 16;

/// Consecutive questions, answered in slices on the thread that calls.
pub(super) struct Steps {
    job: Job,
    left: Range<usize>,
    /// The progress of the first question that is left, if it has been begun.
    begun: Option<(Cursor, Answer<TrianglePair>)>,
    pub(super) found: Found,
}

impl Steps {
    /// All questions.
    pub(super) fn new(job: Job) -> Self {
        let all = 0..job.questions.len();
        Self::part(job, all)
    }

    /// Some of them.
    pub(super) fn part(job: Job, left: Range<usize>) -> Self {
        Self { job, left, begun: None, found: Found::default() }
    }

    /// Goes on for about [`SLICE`] tests. Returns whether nothing is left.
    pub(super) fn step(&mut self) -> Result<bool, Error> {
        let Self { job: Job { questions, verb }, left, begun, found } = self;
        let mut budget = SLICE;
        while budget > 0 && !Range::is_empty(left) {
            let tree = questions[left.start].tree()?;
            let (cursor, answer) = begun.get_or_insert_with(|| (tree.start(), Answer::counted(0)));
            let before = tests(cursor.work);
            if !step(((), &tree), cursor, budget, *verb, answer, &mut found.pairs)? {
                break;
            }
            budget = budget.saturating_sub(tests(cursor.work) - before + BEGIN);
            let listed = if *verb == Verb::All { answer.count as usize } else { 0 };
            let first = found.pairs.len() - listed;
            found.pairs[first..].sort_unstable();
            push(&mut found.answers, *answer)?;
            *begun = None;
            left.start += 1;
        }
        Ok(Range::is_empty(left))
    }
}

/// Tests of both kinds.
fn tests(work: Work) -> u64 {
    work.box_tests + work.triangle_tests
}

#[cfg(feature = "threads")]
pub(super) use pool::submit;

#[cfg(feature = "threads")]
mod pool {
    use super::super::outcome::Outcome;
    use super::*;
    use crate::Executor;
    use crate::memory::reserve;
    use crate::threads::Traversal;
    use std::sync::atomic::{AtomicUsize, Ordering::AcqRel, Ordering::Relaxed};
    use std::sync::{Arc, Mutex, PoisonError};

    /// The most questions that a thread takes at a time.
    const BLOCK: usize = 64;
    /// With fewer, it takes so few that each thread takes at least so often.
    const TURNS: usize = 16;

    /// Submits a batch to the pool of an executor.
    pub(in super::super) fn submit(
        executor: &Executor,
        traversal: &Traversal,
        job: Job,
    ) -> Arc<Outcome> {
        let (outcome, threads) = (Arc::<Outcome>::default(), traversal.threads());
        let count = job.questions.len();
        if count < threads {
            // A thread of the pool is not to be the last that holds a device.
            let mut own_executor = executor.without_gpu().with_cancel(outcome.flag());
            let own = outcome.clone();
            traversal.spawn(move || {
                own.guard(|| {
                    let found = together(&mut own_executor, &job)?;
                    // If it is cancelled, the outcome is known.
                    own.set(Ok(found));
                    Ok(())
                });
            });
            return outcome;
        }
        let blocks = Arc::new(Blocks {
            size: (count / (TURNS * threads)).clamp(1, BLOCK),
            job,
            outcome: outcome.clone(),
            taken: AtomicUsize::new(0),
            answered: Mutex::default(),
            at_work: AtomicUsize::new(threads),
        });
        for _ in 0..threads {
            let blocks = blocks.clone();
            traversal.spawn(move || {
                blocks.outcome.guard(|| blocks.work());
            });
        }
        outcome
    }

    /// Answers one question after the other, each by all threads.
    fn together(executor: &mut Executor, job: &Job) -> Result<Found, Error> {
        let (mut found, mut pairs) = (Found::default(), Vec::new());
        for question in job.questions.iter() {
            // The next question does not resemble the last.
            executor.forget();
            let tree = question.tree()?;
            let (_, answer) = executor.on_cpu((), &tree, job.verb, &mut pairs);
            push(&mut found.answers, answer?)?;
            reserve(&mut found.pairs, pairs.len())?;
            found.pairs.append(&mut pairs);
        }
        Ok(found)
    }

    /// Questions that threads take in blocks, in their order.
    struct Blocks {
        job: Job,
        outcome: Arc<Outcome>,
        size: usize,
        /// Questions that have been taken.
        taken: AtomicUsize,
        /// Each block that has been answered, with its first question.
        answered: Mutex<Vec<(usize, Found)>>,
        /// Threads that have not come to the end.
        at_work: AtomicUsize,
    }

    impl Blocks {
        /// Takes blocks until none is left. The last thread puts them in order.
        fn work(&self) -> Result<(), Error> {
            let count = self.job.questions.len();
            while let Some(first) =
                Some(self.taken.fetch_add(self.size, Relaxed)).filter(|&first| first < count)
            {
                let block = first..count.min(first + self.size);
                let mut steps = Steps::part(self.job.clone(), block);
                while !self.outcome.is_over() && !steps.step()? {}
                if self.outcome.is_over() {
                    return Ok(());
                }
                let mut answered = self.answered.lock().unwrap_or_else(PoisonError::into_inner);
                push(&mut answered, (first, steps.found))?;
            }
            if self.at_work.fetch_sub(1, AcqRel) == 1 {
                let mut answered = self.answered.lock().unwrap_or_else(PoisonError::into_inner);
                answered.sort_unstable_by_key(|&(first, _)| first);
                let mut all = Found::default();
                let pairs = answered.iter().map(|(_, found)| found.pairs.len()).sum();
                reserve(&mut all.answers, count)?;
                reserve(&mut all.pairs, pairs)?;
                for (_, mut found) in answered.drain(..) {
                    all.answers.append(&mut found.answers);
                    all.pairs.append(&mut found.pairs);
                }
                drop(answered);
                self.outcome.set(Ok(all));
            }
            Ok(())
        }
    }
}
