//! Answering by a planner.

#[cfg(all(feature = "threads", feature = "gpu"))]
use super::alone::cost;
use super::alone::{End, Leash};
#[cfg(feature = "gpu")]
use super::device::Device;
use super::kept::Kept;
use super::question::{OfOne, Question};
use super::ways::{Given, Outcome, Want, on_one};
#[cfg(feature = "threads")]
use super::ways::{on_threads, ready};
use crate::planner::{Decider, Offer, Plan, Planner, Way};
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use crate::{Accuracy, Adjacency, Error, Model};
use pfront_core::query::TrianglePair;
use std::time::{Duration, Instant};

/// Who answers, and what is known to decide that.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    decider: Decider,
    kept: Kept,
    /// What the last refit took.
    refit: Option<Duration>,
    #[cfg(feature = "threads")]
    traversal: Option<Traversal>,
    #[cfg(feature = "gpu")]
    device: Option<Device>,
}

/// A refit before there was one: of so many nanoseconds a triangle.
const REFIT: f64 = 20.0;

impl Planned {
    pub(crate) fn new(planner: Planner) -> Self {
        Self {
            kept: Kept::default(),
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
        let guess = model.mesh().triangles().len() as f64 * REFIT;
        let upkeep = self.refit.map_or(guess, |refit| refit.as_secs_f64() * 1e9);
        let question = OfOne { model, adjacency, accuracy };
        let offer = Offer { upkeep, moves: true, ..self.offer(&question) };
        if self.decider.look_ahead(&offer).way == Way::Gpu {
            model.set_positions_unfitted(positions)?;
        } else {
            self.decider.planner().set_positions(model, positions)?;
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
        let subject = question.subject();
        if let Some(given) = self.kept.find(&subject, want) {
            self.decider.keep();
            return given;
        }
        if want == Want::All {
            self.kept.forget();
        }
        if let Some(cost) = self.decider.brief(want == Want::Any) {
            let leash = Leash { cost, deadline: None };
            let brief = on_one(question.query(question.accuracy()), want, pairs, leash);
            if brief.end == End::Complete {
                self.decider.was_brief(brief.cost.unwrap_or_default());
                self.kept.keep(subject, want, brief.given);
                return brief.given;
            }
        }
        self.decider.start();
        let mut offer = self.offer(question);
        offer.both &= want == Want::All;
        let mut choice = self.decider.choose(&offer, want == Want::Any);
        let accuracy = self.decider.accuracy(question.accuracy());
        let deadline = self.decider.deadline();
        let mut outcome = Outcome { end: End::Outgrown, ..Outcome::default() };
        if choice.way == Way::Alone || choice.alone_first.is_some() {
            let leash = Leash { cost: choice.alone_first.unwrap_or(f64::INFINITY), deadline };
            outcome = on_one(question.query(accuracy), want, pairs, leash);
            match outcome.end {
                End::Outgrown => {
                    let cost = outcome.cost.unwrap_or_default();
                    choice = self.decider.outgrown(&offer, &choice, cost);
                }
                _ => choice.way = Way::Alone,
            }
        }
        if outcome.end == End::Outgrown {
            outcome = self.others(question, want, pairs, &mut choice.way, accuracy);
        }
        if outcome.end == End::Complete {
            self.decider.end(choice.way, outcome.cost, outcome.leaf_pairs);
            if accuracy == question.accuracy() {
                self.kept.keep(subject, want, outcome.given);
            }
        } else {
            self.decider.end_incomplete(choice.way);
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
        let query = question.query(accuracy);
        match *way {
            #[cfg(feature = "threads")]
            Way::Threads(workers) | Way::Both(workers, _) => {
                let traversal = ready(&mut self.traversal, &self.decider, workers);
                #[cfg(feature = "gpu")]
                if let (Way::Both(_, share), Some(device)) = (*way, &mut self.device) {
                    match device.ask_beside(question.on_gpu(), &query, share, traversal, pairs) {
                        Ok(given) => {
                            let report = traversal.report();
                            // What the device did is not counted.
                            let own = (1.0 - report.device_share()).max(0.05);
                            let cost = Some(cost(report.work()) / own);
                            return Outcome { given, cost, ..Outcome::default() };
                        }
                        Err(error) => {
                            self.device = None;
                            *way = self.decider.gpu_failed(&error);
                        }
                    }
                }
                on_threads(traversal, &query, want, pairs)
            }
            _ => {
                let leash = Leash { cost: f64::INFINITY, deadline: self.decider.deadline() };
                on_one(query, want, pairs, leash)
            }
        }
    }

    /// Which ways there are for a question.
    fn offer(&self, question: &impl Question) -> Offer {
        let planner = self.decider.planner();
        let gpu = self.gpu(question);
        Offer {
            threads: planner.threads(self.kept.most()),
            gpu,
            gpu_upkeep: 0.0,
            both: gpu.is_some() && cfg!(feature = "threads"),
            guess: question.guess(),
            moves: false,
            queries: 1,
            upkeep: 0.0,
        }
    }

    /// What has to be brought to the GPU first.
    #[cfg(feature = "gpu")]
    fn gpu(&self, question: &impl Question) -> Option<f64> {
        let device = self.device.as_ref().filter(|_| question.accuracy() == Accuracy::Exact)?;
        self.decider.planner().upload(device.owed(question.on_gpu()))
    }

    #[cfg(not(feature = "gpu"))]
    fn gpu(&self, _: &impl Question) -> Option<f64> {
        None
    }
}
