//! Answering a batch on the threads of a pool.

use super::cpu::Steps;
use super::found::Found;
use super::job::Job;
use crate::executor::{CpuHistory, check};
use crate::memory::{push, reserve};
use crate::threads::Pool;
use crate::ticket::Outcome;
use crate::{Error, Executor};
use pfront_core::bvtt::AnyBvtt;
use std::sync::atomic::{AtomicUsize, Ordering::AcqRel, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

/// The most questions that a thread takes at a time.
const BLOCK: usize = 64;
/// With fewer, it takes so few that each thread takes at least so often.
const TURNS: usize = 16;

/// Submits a batch to the pool of an executor.
pub(super) fn submit<T: Send + 'static>(
    executor: &Executor,
    pool: &Pool,
    job: Job,
    answer: fn(Found) -> T,
) -> Arc<Outcome<T>> {
    let (outcome, threads) = (Arc::<Outcome<T>>::default(), pool.threads());
    let count = job.questions.len();
    if count < threads {
        let mut cpu = CpuHistory::new(&executor.clone().with_cancel(outcome.flag().clone()));
        let own = outcome.clone();
        pool.spawn(move || {
            own.guard(|| {
                let found = together(&mut cpu, &job)?;
                // If it is cancelled, the outcome is known.
                own.set(Ok(answer(found)));
                Ok(())
            });
        });
        return outcome;
    }
    let blocks = Arc::new(Blocks {
        size: (count / (TURNS * threads)).clamp(1, BLOCK),
        job,
        answer,
        outcome: outcome.clone(),
        taken: AtomicUsize::new(0),
        answered: Mutex::default(),
        at_work: AtomicUsize::new(threads),
    });
    for _ in 0..threads {
        let blocks = blocks.clone();
        pool.spawn(move || {
            blocks.outcome.guard(|| blocks.work());
        });
    }
    outcome
}

/// Answers one question after the other, each by all threads.
fn together(cpu: &mut CpuHistory<()>, job: &Job) -> Result<Found, Error> {
    let (mut found, mut pairs) = (Found::default(), Vec::new());
    for question in job.questions.iter() {
        // The next question does not resemble the last.
        cpu.forget();
        let tree = question.tree()?;
        if let (Some(nearest), AnyBvtt::Pair(tree)) = (job.nearest, &tree) {
            let (_, gap) = cpu.distance(tree, nearest.at_most, None);
            push(&mut found.gaps, gap?)?;
            continue;
        }
        let (_, answer) = cpu.ask((), &tree, job.verb, &mut pairs);
        push(&mut found.answers, answer?)?;
        reserve(&mut found.pairs, pairs.len())?;
        found.pairs.append(&mut pairs);
    }
    Ok(found)
}

/// Questions that threads take in blocks, in their order.
struct Blocks<T> {
    job: Job,
    answer: fn(Found) -> T,
    outcome: Arc<Outcome<T>>,
    size: usize,
    /// Questions that have been taken.
    taken: AtomicUsize,
    /// Each block that has been answered, with its first question.
    answered: Mutex<Vec<(usize, Found)>>,
    /// Threads that have not come to the end.
    at_work: AtomicUsize,
}

impl<T> Blocks<T> {
    /// Takes blocks until none is left. The last thread puts them in order.
    fn work(&self) -> Result<(), Error> {
        let count = self.job.questions.len();
        while let Some(first) =
            Some(self.taken.fetch_add(self.size, Relaxed)).filter(|&first| first < count)
        {
            let block = first..count.min(first + self.size);
            let mut steps = Steps::part(self.job.clone(), block);
            // An outcome that is known stays.
            check(Some(self.outcome.flag()))?;
            while !steps.step()? {
                check(Some(self.outcome.flag()))?;
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
            reserve(&mut all.gaps, if self.job.nearest.is_some() { count } else { 0 })?;
            for (_, mut found) in answered.drain(..) {
                all.answers.append(&mut found.answers);
                all.pairs.append(&mut found.pairs);
                all.gaps.append(&mut found.gaps);
            }
            drop(answered);
            self.outcome.set(Ok((self.answer)(all)));
        }
        Ok(())
    }
}
