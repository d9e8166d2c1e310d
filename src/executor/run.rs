//! One query on its executor, from frame to frame.

use super::{Backend, Executor, Plan, Reason};
#[cfg(feature = "gpu")]
use super::{Device, choice::Choice};
#[cfg(feature = "gpu")]
use crate::Accuracy;
#[cfg(feature = "threads")]
use crate::threads::{Report, Traversal};
use crate::{Contact, Error, Model, TrianglePair};
use pfront_core::bvtt::Query;
#[cfg(feature = "gpu")]
use std::time::Instant;

/// The verbs of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Want {
    All,
    Count,
    Any,
}

/// What an answer says, beside the list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given<T> {
    pub(crate) count: u64,
    pub(crate) first: Option<T>,
}

impl<T: Copy> Given<T> {
    /// The answer to `all`: a list in order.
    pub(crate) fn listed(list: &[T]) -> Self {
        Self { count: list.len() as u64, first: list.first().copied() }
    }

    pub(crate) fn counted(count: u64) -> Self {
        Self { count, first: None }
    }

    /// The answer to `any`: a pair found.
    pub(crate) fn found(first: Option<T>) -> Self {
        Self { count: u64::from(first.is_some()), first }
    }
}

/// A question, as each kind of executor answers it.
pub(crate) trait Question {
    type Answer;

    #[cfg(feature = "gpu")]
    fn accuracy(&self) -> Accuracy;

    fn on_one_thread(&mut self, want: Want) -> Result<Self::Answer, Error>;

    #[cfg(feature = "threads")]
    fn on_threads(&mut self, traversal: &mut Traversal, want: Want) -> Result<Self::Answer, Error>;

    /// Triangles that the GPU does not have.
    #[cfg(feature = "gpu")]
    fn to_upload(&self) -> usize;

    /// Brings the GPU what it lacks, and asks it.
    #[cfg(feature = "gpu")]
    fn on_gpu(&mut self, device: &Device, want: Want) -> Result<Self::Answer, Error>;
}

/// What a query remembers of its executor.
#[derive(Clone, Debug, Default)]
pub(crate) struct Run {
    #[cfg(any(feature = "threads", feature = "gpu"))]
    executor: Executor,
    #[cfg(feature = "gpu")]
    choice: Choice,
    /// Why the GPU is not asked any more.
    #[cfg(feature = "gpu")]
    failure: Option<String>,
    last: Option<Plan>,
}

impl Run {
    #[cfg(any(feature = "threads", feature = "gpu"))]
    pub(crate) fn on(executor: &Executor) -> Self {
        Self { executor: executor.clone(), ..Self::default() }
    }

    /// The calling thread is the only executor here.
    #[cfg(not(any(feature = "threads", feature = "gpu")))]
    pub(crate) fn on(_: &Executor) -> Self {
        Self::default()
    }

    /// What the last frame on threads did.
    #[cfg(feature = "threads")]
    pub(crate) fn report(&self) -> Option<&Report> {
        Some(&self.executor.traversal.as_ref()?.report)
    }

    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.last.as_ref()
    }

    /// Takes note of a frame that nobody had to answer.
    pub(crate) fn keep(&mut self) {
        self.note(Backend::Kept, Reason::Unchanged);
    }

    /// Adds to `out`, in order, where each of `pairs` meets, if it does.
    pub(crate) fn contacts(
        &self,
        query: &(impl Query + Sync),
        pairs: &[TrianglePair],
        out: &mut Vec<(TrianglePair, Contact)>,
    ) {
        #[cfg(feature = "threads")]
        if let Some(traversal) = &self.executor.traversal {
            return traversal.contacts(query, pairs, out);
        }
        out.extend(pairs.iter().filter_map(|&pair| Some((pair, query.contact(pair)?))));
    }

    /// Moves the vertices of a model that will be asked about next.
    pub(crate) fn set_positions(
        &mut self,
        model: &mut Model,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        #[cfg(feature = "gpu")]
        if self.executor.device.is_some() {
            let clock = Instant::now();
            let moved = match self.is_on_gpu() {
                // The GPU refits by itself.
                true => model.set_positions_unfitted(positions),
                false => self.refit(model, positions),
            };
            self.choice.moved(clock.elapsed());
            return moved;
        }
        self.refit(model, positions)
    }

    /// The same for a model whose box is needed at once.
    pub(crate) fn refit(&self, model: &mut Model, positions: &[[f32; 3]]) -> Result<(), Error> {
        #[cfg(feature = "threads")]
        if let Some(traversal) = &self.executor.traversal {
            return traversal.install(|| model.set_positions_with_threads(positions));
        }
        model.set_positions(positions)
    }

    pub(crate) fn ask<Q: Question>(
        &mut self,
        question: &mut Q,
        want: Want,
    ) -> Result<Q::Answer, Error> {
        #[cfg(feature = "gpu")]
        if let Some(device) = self.executor.device.clone() {
            return self.ask_either(&device, question, want);
        }
        self.on_cpu(question, want, Reason::OnlyOne)
    }

    fn on_cpu<Q: Question>(
        &mut self,
        question: &mut Q,
        want: Want,
        reason: Reason,
    ) -> Result<Q::Answer, Error> {
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.executor.traversal {
            let answer = question.on_threads(traversal, want);
            let called = !traversal.report.shares.is_empty();
            self.note(if called { Backend::Threads } else { Backend::Sequential }, reason);
            return answer;
        }
        let answer = question.on_one_thread(want);
        self.note(Backend::Sequential, reason);
        answer
    }

    fn note(&mut self, backend: Backend, reason: Reason) {
        #[cfg(feature = "gpu")]
        let predicted = match reason {
            Reason::Faster | Reason::NotWorthChanging => self.choice.predicted(),
            _ => None,
        };
        #[cfg(feature = "gpu")]
        let failure = self.failure.clone();
        #[cfg(not(feature = "gpu"))]
        let (predicted, failure) = (None, None);
        self.last = Some(Plan { backend, reason, predicted, failure });
    }
}

/// Choosing between the CPU and a GPU.
#[cfg(feature = "gpu")]
impl Run {
    fn is_on_gpu(&self) -> bool {
        let is_only = |device: &Device| device.line.is_none() || self.choice.is_on_gpu();
        self.failure.is_none() && self.executor.device.as_deref().is_some_and(is_only)
    }

    fn ask_either<Q: Question>(
        &mut self,
        device: &Device,
        question: &mut Q,
        want: Want,
    ) -> Result<Q::Answer, Error> {
        let Some(line) = &device.line else {
            let answer = question.on_gpu(device, want);
            self.note(Backend::Gpu, Reason::OnlyOne);
            return answer;
        };
        if self.failure.is_some() {
            return self.on_cpu(question, want, Reason::GpuFailed);
        }
        if question.accuracy() != Accuracy::Exact {
            return self.on_cpu(question, want, Reason::Inexact);
        }
        let reason = self.choice.choose(line, question.to_upload());
        let clock = Instant::now();
        if self.choice.is_on_gpu() {
            match question.on_gpu(device, want) {
                Ok(answer) => {
                    let time = clock.elapsed();
                    self.note(Backend::Gpu, reason);
                    self.choice.took(line, time);
                    return Ok(answer);
                }
                // It can do no more: from now on the CPU answers, and the plan says why.
                Err(Error::Gpu(error)) => self.failure = Some(error.to_string()),
                Err(error) => return Err(error),
            }
            return self.on_cpu(question, want, Reason::GpuFailed);
        }
        let answer = self.on_cpu(question, want, reason);
        self.choice.took(line, clock.elapsed());
        answer
    }
}
