//! Answering by a planner.

use super::alone::{End, Leash};
#[cfg(feature = "gpu")]
use super::device::Device;
use super::kept::Kept;
use super::question::{OfOne, Question};
use super::ways::{Given, Outcome, Want, on_one};
#[cfg(feature = "threads")]
use super::ways::{on_threads, ready};
use crate::planner::{Decider, Known, Offer, Plan, Planner, Way};
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use crate::{Accuracy, Adjacency, Error, Model};
use pfront_core::bvtt::{Query, TrianglePair};
use std::time::{Duration, Instant};

/// Who answers, and what is known to decide that.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    decider: Decider,
    kept: Kept,
    /// What was asked last.
    last: Want,
    /// What the last refit took.
    refit: Option<Duration>,
    #[cfg(feature = "threads")]
    traversal: Option<Traversal>,
    #[cfg(feature = "gpu")]
    device: Option<Device>,
}

/// To find a smaller answer takes no longer than to keep it.
const WORTH_KEEPING: f64 = 64.0;

impl Planned {
    pub(crate) fn new(planner: Planner) -> Self {
        Self {
            kept: Kept::default(),
            last: Want::All,
            refit: None,
            #[cfg(feature = "threads")]
            traversal: None,
            #[cfg(feature = "gpu")]
            device: Device::new(&planner),
            decider: Decider::new(planner),
        }
    }

    pub(crate) fn plan(&self) -> Option<Plan> {
        self.decider.plan()
    }

    /// The list is overwritten by others, who have answered what was prepared for.
    pub(crate) fn forget(&mut self) {
        self.kept.forget();
        self.decider.forget_ahead();
    }

    /// Moves the vertices of a model that will be asked about next, and refits it, unless the GPU will do that.
    pub(crate) fn set_positions(
        &mut self,
        model: &mut Model,
        positions: &[[f32; 3]],
        adjacency: Adjacency,
        accuracy: Accuracy,
    ) -> Result<(), Error> {
        let clock = Instant::now();
        let guess = || self.decider.planner().refit(model.mesh().triangles().len());
        let upkeep = self.refit.map_or_else(guess, |refit| refit.as_secs_f64() * 1e9);
        let question = OfOne { model, adjacency, accuracy };
        // It will be asked what was asked last.
        let offer = Offer { upkeep, moves: true, ..self.offer(&question, self.last) };
        let on_gpu = self.decider.look_ahead(&offer).way == Way::Gpu;
        let moved = match on_gpu {
            true => model.set_positions_unfitted(positions),
            false => self.decider.planner().set_positions(model, positions),
        };
        if moved.is_err() {
            self.decider.forget_ahead();
            return moved;
        }
        if !on_gpu {
            self.refit = Some(clock.elapsed());
        }
        self.decider.prepared(clock.elapsed());
        Ok(())
    }

    /// Answers; into `pairs` if all are wanted, which otherwise stay what they are.
    pub(crate) fn ask<Q: Question>(
        &mut self,
        question: &Q,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Given {
        if let Some(given) = self.kept.find(|| question.subject(), want) {
            self.decider.keep();
            return given;
        }
        if want == Want::All {
            self.kept.forget();
        }
        self.last = want;
        self.decider.start_asking(want == Want::Any);
        let is_large = self.decider.is_large();
        let size = if is_large { question.size() } else { None };
        let begin = self.decider.begin(Known { size, ..Self::known(question, want) });
        let (mut offer, mut choice) = (None, None);
        if begin.is_none() {
            self.decider.clock(0.0);
            let asked = offer.insert(self.offer(question, want));
            choice = Some(self.decider.choose(asked));
        }
        let accuracy = self.decider.accuracy(question.accuracy());
        let mut outcome = Outcome { end: End::Outgrown, ..Outcome::default() };
        if let Some(cost) = begin.or(choice.and_then(|choice| choice.alone_to())) {
            let deadline = choice.and_then(|_| self.decider.deadline());
            let leash = Leash { cost, deadline };
            let query = self.query(question, accuracy);
            outcome = on_one(query, want, pairs, leash, |spent, rest| {
                if let Some(until) = self.decider.mark(spent) {
                    return Some(until);
                }
                let offer = *offer.get_or_insert_with(|| self.offer(question, want));
                let next = self.decider.look(&offer, choice.as_ref(), [spent, rest()]);
                choice = Some(next);
                next.alone_to()
            });
        }
        let mut way = choice.map_or(Way::Alone, |choice| choice.way);
        match outcome.end {
            End::Outgrown => outcome = self.others(question, want, pairs, &mut way, accuracy),
            _ => way = Way::Alone,
        }
        if outcome.end != End::Complete {
            self.decider.end_incomplete(way);
            return outcome.given;
        }
        match outcome.cost.filter(|_| choice.is_none()) {
            Some(cost) => self.decider.was_brief(cost),
            None => self.decider.end(way, outcome.cost, outcome.leaf_pairs),
        }
        let is_nothing = outcome.cost.is_some_and(|cost| cost < WORTH_KEEPING);
        if accuracy == question.accuracy() && !is_nothing {
            self.kept.keep(question.subject(), want, outcome.given);
        }
        outcome.given
    }

    /// Answers on threads or a GPU; says by which way it was done in the end.
    fn others<Q: Question>(
        &mut self,
        question: &Q,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
        way: &mut Way,
        accuracy: Accuracy,
    ) -> Outcome {
        #[cfg(feature = "gpu")]
        if let (Way::Gpu, Some(device)) = (*way, &mut self.device) {
            match device.ask(question.on_gpu(), want, pairs) {
                Ok((given, leaf_pairs)) => {
                    return Outcome { given, leaf_pairs: Some(leaf_pairs), ..Outcome::default() };
                }
                Err(error) => {
                    self.device = None;
                    *way = self.decider.gpu_failed(&error);
                }
            }
        }
        let query = self.query(question, accuracy);
        match *way {
            #[cfg(feature = "threads")]
            Way::Threads(workers) => {
                let traversal = ready(&mut self.traversal, &self.decider, workers);
                on_threads(traversal, &query, want, pairs)
            }
            _ => {
                let leash = Leash { cost: f64::INFINITY, deadline: self.decider.deadline() };
                on_one(query, want, pairs, leash, |_, _| None)
            }
        }
    }

    /// What the CPU walks. To make what it lacks is no part of what the answer takes.
    fn query<'q, Q: Question>(
        &mut self,
        question: &'q Q,
        accuracy: Accuracy,
    ) -> impl Query + Sync + use<'q, Q> {
        let is_unmade = question.unmade() > 0.0;
        let query = question.query(accuracy);
        if is_unmade {
            self.decider.made();
        }
        query
    }

    /// The knowledge of a question without looking for its size.
    fn known(question: &impl Question, want: Want) -> Known {
        Known { until_first: want == Want::Any, guess: question.guess(), size: None }
    }

    /// The ways that there are for a question.
    fn offer(&self, question: &impl Question, want: Want) -> Offer {
        let (gpu, gpu_upkeep) = self.gpu(question);
        Offer {
            threads: self.decider.planner().threads(self.kept.most()),
            gpu,
            gpu_upkeep,
            known: Known { size: question.size(), ..Self::known(question, want) },
            moves: false,
            queries: 1,
            upkeep: 0.0,
            unmade: question.unmade(),
        }
    }

    /// What has to be brought to the GPU first, and what it has to do in each frame.
    #[cfg(feature = "gpu")]
    fn gpu(&self, question: &impl Question) -> (Option<f64>, f64) {
        let planner = self.decider.planner();
        match self.device.as_ref().filter(|_| question.accuracy() == Accuracy::Exact) {
            Some(device) => {
                let upload = planner.upload(device.owed(question.on_gpu()));
                (upload, device.upkeep(question.on_gpu(), planner))
            }
            None => (None, 0.0),
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn gpu(&self, _: &impl Question) -> (Option<f64>, f64) {
        (None, 0.0)
    }
}
