//! One query on its executor, from frame to frame.

use super::choice::{Choice, Failure};
use super::{
    Answer, Backend, CpuHistory, CpuPart, Device, Executor, Meeting, Named, Plan, Reason, Verb,
    check, visit,
};
use crate::Distance;
use crate::memory::{push, reserve};
use crate::{Error, Model, Scalar, TrianglePair};
use pfront_core::bvtt::{Gap, PairBvtt, Query};
use std::ops::ControlFlow;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// Contacts, or what takes about as long, that take the time of a call to another thread: some 0.3 us each.
pub(crate) const CONTACTS: usize = 64;

/// The subjects of a query in a frame, as each kind of executor answers about them: a [`History`] chooses the executor, and
/// calls the frame back with what that remembers, since pairs and scenes are brought to a GPU in different ways.
pub(crate) trait Frame {
    type Hit: Named;

    /// Answers on the CPU, and tells which part of it did.
    fn on_cpu(
        &mut self,
        cpu: &mut CpuHistory<Name<Self>>,
        verb: Verb,
    ) -> (Backend, Result<Answer<Self::Hit>, Error>);

    /// Whether only a CPU answers.
    fn is_for_cpu(&self) -> bool;

    /// The numbers of the meshes that it is about.
    fn meshes(&self) -> [u64; 2];

    /// Triangles that the GPU does not have.
    fn to_upload(&mut self) -> usize;

    /// Brings the GPU what it lacks, and asks it; about the rest, if it leaves any, the CPU.
    fn on_gpu(
        &mut self,
        device: &Device,
        cpu: &mut CpuHistory<Name<Self>>,
        verb: Verb,
    ) -> Result<Answer<Self::Hit>, Error>;
}

/// The names of the subjects of a frame.
pub(crate) type Name<F> = <<F as Frame>::Hit as Named>::Name;

/// The history of a query on its executor, with the names of its subjects.
#[derive(Clone, Debug)]
pub(crate) struct History<N> {
    executor: Executor,
    cpu: CpuHistory<N>,
    /// One for each verb.
    choices: [Choice; 3],
    /// The meshes that the choices are about.
    meshes: Option<[u64; 2]>,
    last_verb: Verb,
    /// The time that it took to move vertices for the next frame.
    moving: Duration,
    /// The last failure of the GPU, which is not asked for a while.
    failure: Failure,
    last: Option<Plan>,
}

impl<N: Copy + Ord> Default for History<N> {
    fn default() -> Self {
        Self::on(&Executor::default())
    }
}

impl<N: Copy + Ord> History<N> {
    pub(crate) fn on(executor: &Executor) -> Self {
        Self {
            executor: executor.clone(),
            cpu: CpuHistory::new(executor),
            choices: Default::default(),
            meshes: None,
            last_verb: Verb::default(),
            moving: Duration::ZERO,
            failure: Failure::default(),
            last: None,
        }
    }

    /// Counts and times of the last frame on threads.
    #[cfg(feature = "threads")]
    pub(crate) fn report(&self) -> Option<&crate::threads::Report> {
        self.cpu.report()
    }

    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.last.as_ref()
    }

    /// Takes note of a frame that was answered from the cache.
    pub(crate) fn keep(&mut self) {
        self.moving = Duration::ZERO;
        self.note(Backend::Cached, Reason::Unchanged);
    }

    /// Adds the contacts of hits to `out`, in order, and takes note of who has worked.
    ///
    /// # Errors
    /// The error of a meeting, [`Error::Cancelled`], [`Error::Memory`], or [`Error::Panicked`] for a thread of a pool. With
    /// several threads nothing is added then; the calling thread alone has added a part.
    pub(crate) fn contacts<'q, H: Named<Name = N>, C: Send>(
        &mut self,
        hits: &[H],
        meeting: impl Fn(N) -> Result<Meeting<'q>, Error> + Sync,
        contact: impl Fn(&Meeting<'q>, TrianglePair) -> Option<C> + Sync,
        out: &mut Vec<(H, C)>,
    ) -> Result<(), Error> {
        if hits.is_empty() {
            return Ok(());
        }
        let (part, flag) = (CpuPart::new(), self.executor.cancel_flag());
        let list = |hits: &[H], out: &mut Vec<(H, C)>| {
            part.works();
            reserve(out, hits.len())?;
            for of_one in hits.chunk_by(|x, y| x.name() == y.name()) {
                let meeting = meeting(of_one[0].name())?;
                for hit in of_one {
                    check(flag)?;
                    out.extend(contact(&meeting, hit.pair()).map(|contact| (*hit, contact)));
                }
            }
            Ok(())
        };
        let listed = self.by_pieces(hits, CONTACTS, list, out);
        self.note_also(part.backend());
        listed
    }

    /// Adds to `out`, in order, what `list` makes of pieces of some items, on the threads of the executor if there are at least
    /// twice as many as are worth a call.
    ///
    /// # Errors
    /// Every error of `list`. With several threads also [`Error::Memory`] and [`Error::Panicked`].
    pub(crate) fn by_pieces<T: Sync, R: Send>(
        &self,
        items: &[T],
        least: usize,
        list: impl Fn(&[T], &mut Vec<R>) -> Result<(), Error> + Sync,
        out: &mut Vec<R>,
    ) -> Result<(), Error> {
        if let Some(pool) = &self.executor.pool {
            return pool.by_pieces(items, least, list, out);
        }
        list(items, out)
    }

    /// Sorts a list by integers, on the threads of the executor if it is long.
    pub(crate) fn sort<T: Send, K: Ord>(
        &self,
        items: &mut [T],
        key: impl Fn(&T) -> K + Sync + Send,
    ) {
        match &self.executor.pool {
            Some(pool) => pool.sort(items, key),
            None => items.sort_unstable_by_key(key),
        }
    }

    /// The smallest distance of two meshes, which the CPU finds. Takes note of who has.
    pub(crate) fn distance(
        &mut self,
        tree: &PairBvtt<'_>,
        at_most: Option<Distance>,
        seed: Option<TrianglePair>,
    ) -> Result<Option<Gap>, Error> {
        let (backend, gap) = self.cpu.distance(tree, at_most, seed);
        self.note_cpu(backend);
        gap
    }

    /// The names of those `subjects` whose query finds something, in order.
    ///
    /// # Errors
    /// [`Error::Cancelled`] or [`Error::Memory`].
    pub(crate) fn intersecting<S: Copy + Sync, T: Send, Q: Query>(
        &self,
        subjects: &[S],
        query: impl Fn(S) -> Option<(T, Q)> + Sync,
    ) -> Result<Vec<T>, Error> {
        let flag = self.executor.cancel_flag();
        let list = |subjects: &[S], names: &mut Vec<T>| {
            for (name, query) in subjects.iter().filter_map(|&subject| query(subject)) {
                let mut meet = false;
                visit(&query, flag, |_| {
                    meet = true;
                    ControlFlow::Break(())
                })?;
                if meet {
                    push(names, name)?;
                }
            }
            Ok(())
        };
        let mut names = Vec::new();
        self.by_pieces(subjects, CONTACTS, list, &mut names)?;
        Ok(names)
    }

    /// Moves the vertices of a model that will be asked about next.
    pub(crate) fn set_positions<S: Scalar>(
        &mut self,
        model: &mut Model,
        positions: &[[S; 3]],
    ) -> Result<(), Error> {
        let is_at_once = model.mesh().triangles().len() < super::models::SMALL
            && self.choices[self.last_verb as usize].is_at_once;
        if self.executor.device.is_some() && !is_at_once {
            let clock = Instant::now();
            let moved = match self.is_on_gpu() {
                // The GPU refits by itself.
                true => model.set_positions_unfitted(positions),
                false => self.executor.refit(model, positions),
            };
            self.moving += clock.elapsed();
            return moved;
        }
        self.executor.refit(model, positions)
    }

    /// Answers in the floating-point environment of the calling thread, which is to be the default.
    pub(crate) fn ask<F: Frame<Hit: Named<Name = N>>>(
        &mut self,
        frame: &mut F,
        verb: Verb,
    ) -> Result<Answer<F::Hit>, Error> {
        if let Some(device) = self.executor.device.clone() {
            return self.ask_either(&device, frame, verb);
        }
        self.on_cpu(frame, verb, Reason::NoChoice)
    }

    fn on_cpu<F: Frame<Hit: Named<Name = N>>>(
        &mut self,
        frame: &mut F,
        verb: Verb,
        reason: Reason,
    ) -> Result<Answer<F::Hit>, Error> {
        let (backend, answer) = frame.on_cpu(&mut self.cpu, verb);
        self.note(backend, reason);
        answer
    }

    /// The answer of a GPU, which may have seen the flag too late.
    fn unless_cancelled<T>(&self, answer: T) -> Result<T, Error> {
        let is_set = self.executor.cancel_flag().is_some_and(|flag| flag.load(Relaxed));
        if is_set { Err(Error::Cancelled) } else { Ok(answer) }
    }

    /// Takes note that a part of the CPU has answered, whatever the executor has.
    pub(crate) fn note_cpu(&mut self, backend: Backend) {
        self.note(backend, self.executor.without_gpu());
    }

    /// Takes note that a part of the CPU has answered too, after what is noted.
    pub(crate) fn note_also(&mut self, backend: Backend) {
        match &mut self.last {
            Some(plan) if plan.backend != Backend::Cached => {
                plan.backend = plan.backend.and(backend);
            }
            _ => self.note_cpu(backend),
        }
    }

    /// Whether the calling thread alone answers.
    pub(crate) fn is_sequential(&self) -> bool {
        self.executor.pool.is_none() && self.executor.device.is_none()
    }

    /// The executor of the query.
    pub(crate) fn executor(&self) -> &Executor {
        &self.executor
    }

    fn note(&mut self, backend: Backend, reason: Reason) {
        let failure = self.failure.reason().map(str::to_owned);
        self.last = Some(Plan { backend, reason, predicted: None, failure });
    }
}

/// Choosing between the CPU and a GPU.
impl<N: Copy + Ord> History<N> {
    /// Whether the GPU will answer the next frame, as far as that is known.
    fn is_on_gpu(&self) -> bool {
        let is_only = |device: &Device| device.choice_line().is_none();
        let is_chosen = || self.choices[self.last_verb as usize].is_on_gpu();
        let device = self.executor.device.as_deref();
        !self.failure.is_pausing() && device.is_some_and(|device| is_only(device) || is_chosen())
    }

    fn ask_either<F: Frame<Hit: Named<Name = N>>>(
        &mut self,
        device: &Device,
        frame: &mut F,
        verb: Verb,
    ) -> Result<Answer<F::Hit>, Error> {
        let moving = std::mem::take(&mut self.moving);
        if frame.is_for_cpu() {
            return self.on_cpu(frame, verb, Reason::CpuOnly);
        }
        let Some(line) = device.choice_line() else {
            let answer = frame.on_gpu(device, &mut self.cpu, verb);
            self.note(Backend::Gpu, Reason::NoChoice);
            return self.unless_cancelled(answer?);
        };
        if self.failure.is_pausing() {
            self.failure.passed();
            return self.on_cpu(frame, verb, Reason::GpuFailed);
        }
        // Choices for other models tell nothing of these.
        let meshes = frame.meshes();
        if self.meshes.replace(meshes) != Some(meshes) {
            self.choices = Default::default();
        }
        self.last_verb = verb;
        // A look at the clock costs as much as such a frame, and no GPU answers sooner.
        if self.choices[verb as usize].is_at_once && moving.is_zero() {
            let answer = self.on_cpu(frame, verb, Reason::Faster);
            self.choices[verb as usize].is_at_once = self.cpu.was_at_once();
            return answer;
        }
        let (to_upload, clock) = (frame.to_upload(), Instant::now());
        let choice = &mut self.choices[verb as usize];
        let (by_gpu, reason) = choice.choose(line, line.upload(to_upload));
        let predicted = choice.predicted(line);
        let answer = match by_gpu {
            true => frame
                .on_gpu(device, &mut self.cpu, verb)
                .and_then(|answer| self.unless_cancelled(answer)),
            false => self.on_cpu(frame, verb, reason),
        };
        match answer {
            Err(error) if by_gpu => match device.is_lost_by(&error) {
                // For a while the CPU answers, and the plan says why.
                Some(is_lost) => {
                    self.failure.failed(error.to_string(), is_lost);
                    self.on_cpu(frame, verb, Reason::GpuFailed)
                }
                None => {
                    self.note(Backend::Gpu, reason);
                    Err(error)
                }
            },
            Err(error) => Err(error),
            Ok(answer) => {
                let time = clock.elapsed() + moving;
                self.choices[verb as usize].took(line, by_gpu, to_upload > 0, time);
                self.choices[verb as usize].is_at_once = !by_gpu && self.cpu.was_at_once();
                if by_gpu {
                    self.failure.answered();
                    self.note(Backend::Gpu, reason);
                }
                self.last.iter_mut().for_each(|plan| plan.predicted = predicted);
                Ok(answer)
            }
        }
    }
}
