//! A scene by a planner.

use super::SceneHit;
use super::bodies::Bodies;
use super::broad::Broad;
#[cfg(feature = "threads")]
use super::crew::Crew;
#[cfg(feature = "gpu")]
use super::device::Device;
use super::frame::{Found, Frame, Given};
use super::ways::{Outcome, on_one};
use crate::answer::{End, Leash, Want};
use crate::planner::{Decider, Known, Offer, Plan, Planner, Way};
use crate::{Accuracy, Error};
use std::time::{Duration, Instant};

#[derive(Clone, Debug)]
pub(super) struct Planned {
    decider: Decider,
    #[cfg(feature = "threads")]
    crew: Option<Crew>,
    #[cfg(feature = "gpu")]
    device: Option<Device>,
    /// The most hits of a frame.
    most: u64,
    /// Pairs of bodies in the last frame in which they were found, and what it took to find them.
    queries: usize,
    broad: Duration,
}

/// A broad phase of fewer bodies takes no longer than to look at the clock.
const CROWD: usize = 64;

impl Planned {
    pub(super) fn new(planner: Planner) -> Self {
        Self {
            #[cfg(feature = "threads")]
            crew: None,
            #[cfg(feature = "gpu")]
            device: Device::new(&planner),
            most: 0,
            queries: 0,
            broad: Duration::ZERO,
            decider: Decider::new(planner),
        }
    }

    pub(super) fn plan(&self) -> Option<Plan> {
        self.decider.plan()
    }

    pub(super) fn has_conceded(&self) -> bool {
        self.decider.has_conceded()
    }

    pub(super) fn planner(&self) -> &Planner {
        self.decider.planner()
    }

    pub(super) fn start(&mut self) {
        self.decider.start();
    }

    pub(super) fn keep(&mut self) {
        self.decider.keep();
    }

    /// Answers with no broad phase, which a GPU has of its own, if that is where the last frame was answered and
    /// this one should be; into `hits`, which are empty, if all are wanted.
    pub(super) fn ask_ahead(
        &mut self,
        accuracy: Accuracy,
        bodies: &Bodies,
        want: Want,
        hits: &mut Vec<SceneHit>,
    ) -> Option<Given> {
        self.decider.ask(want == Want::Any);
        if !self.decider.is_on_gpu() {
            return None;
        }
        self.decider.clock(0.0);
        let known = Known { until_first: want == Want::Any, ..Known::default() };
        let offer = self.offer(accuracy, bodies, known);
        if self.decider.look_ahead(&offer).way != Way::Gpu {
            return None;
        }
        self.decider.choose(&offer);
        let (given, leaf_pairs) = self.ask_gpu(bodies, want, hits).ok()?;
        self.decider.end(Way::Gpu, None, Some(leaf_pairs));
        self.most = self.most.max(given.count);
        Some(given)
    }

    /// Brings the broad phase up to date.
    pub(super) fn update(&mut self, broad: &mut Broad, bodies: &mut Bodies) -> Result<(), Error> {
        // With a limit of time nothing is asked ahead, so that a GPU would save nothing.
        if bodies.len() < CROWD || !self.has_gpu() || self.planner().limits().time.is_some() {
            self.broad = Duration::ZERO;
            return broad.update(bodies);
        }
        let (clock, is_usual) = (Instant::now(), broad.follows(bodies));
        broad.update(bodies)?;
        if is_usual {
            self.broad = clock.elapsed();
        }
        Ok(())
    }

    /// Answers; into `hits`, which are empty, if all are wanted.
    pub(super) fn ask(&mut self, frame: &Frame<'_>, want: Want, hits: &mut Vec<SceneHit>) -> Found {
        self.decider.ask(want == Want::Any);
        self.queries = frame.len();
        if self.queries == 0 {
            self.decider.was_nothing();
            return Found::New(Given::default());
        }
        let size = Some(self.queries as f64);
        let known = Known { until_first: want == Want::Any, guess: None, size };
        let begin = self.decider.begin(known);
        let (mut offer, mut choice) = (None, None);
        if begin.is_none() {
            self.decider.clock(0.0);
            let asked = offer.insert(self.offer(frame.accuracy, frame.bodies, known));
            choice = Some(self.decider.choose(asked));
        }
        let accuracy = self.decider.accuracy(frame.accuracy);
        let frame = &frame.with_accuracy(accuracy);
        let mut outcome = None;
        if let Some(cost) = begin.or(choice.and_then(|choice| choice.alone_to())) {
            let deadline = choice.and_then(|_| self.decider.deadline());
            let leash = Leash { cost, deadline };
            let alone = on_one(frame, want, hits, leash, |spent, rest| {
                if let Some(until) = self.decider.mark(spent) {
                    return Some(until);
                }
                let offer =
                    *offer.get_or_insert_with(|| self.offer(frame.accuracy, frame.bodies, known));
                let next = self.decider.look(&offer, choice.as_ref(), [spent, rest()]);
                choice = Some(next);
                next.alone_to()
            });
            match alone.end {
                End::Outgrown => hits.clear(),
                _ => outcome = Some(alone),
            }
        }
        let mut way = choice.map_or(Way::Alone, |choice| choice.way);
        let outcome = match outcome {
            Some(outcome) => {
                way = Way::Alone;
                outcome
            }
            None => self.others(frame, want, hits, &mut way),
        };
        match (outcome.end, outcome.cost) {
            (End::Complete, Some(cost)) if choice.is_none() => self.decider.was_brief(cost),
            (End::Complete, cost) => self.decider.end(way, cost, outcome.leaf_pairs),
            _ => self.decider.end_incomplete(way),
        }
        self.most = self.most.max(outcome.given.get().count);
        outcome.given
    }

    /// Answers on threads or a GPU; says by which way it was done in the end.
    fn others(
        &mut self,
        frame: &Frame<'_>,
        want: Want,
        hits: &mut Vec<SceneHit>,
        way: &mut Way,
    ) -> Outcome {
        if *way == Way::Gpu {
            match self.ask_gpu(frame.bodies, want, hits) {
                Ok((given, leaf_pairs)) => {
                    let given = Found::All(given);
                    let end = End::Complete;
                    return Outcome { given, cost: None, leaf_pairs: Some(leaf_pairs), end };
                }
                Err(instead) => *way = instead,
            }
        }
        match *way {
            #[cfg(feature = "threads")]
            Way::Threads(workers) => self.on_threads(frame, want, hits, workers),
            _ => {
                let leash = Leash { cost: f64::INFINITY, deadline: self.decider.deadline() };
                on_one(frame, want, hits, leash, |_, _| None)
            }
        }
    }

    #[cfg(feature = "threads")]
    fn on_threads(
        &mut self,
        frame: &Frame<'_>,
        want: Want,
        hits: &mut Vec<SceneHit>,
        workers: u32,
    ) -> Outcome {
        let planner = self.decider.planner();
        let crew = self.crew.get_or_insert_with(|| Crew::new(planner.traversal(workers)));
        self.decider.prepare(&mut crew.traversal, workers);
        let given = crew.ask(frame, want, hits);
        let report = crew.report();
        let end = if report.late { End::Late } else { End::Complete };
        Outcome {
            given: Found::New(given),
            cost: Some(report.work().cost()),
            leaf_pairs: None,
            end,
        }
    }

    /// Asks the GPU; says who else is to be asked if that fails.
    #[cfg(feature = "gpu")]
    fn ask_gpu(
        &mut self,
        bodies: &Bodies,
        want: Want,
        hits: &mut Vec<SceneHit>,
    ) -> Result<(Given, u32), Way> {
        let device = self.device.as_mut().ok_or(Way::Alone)?;
        device.ask(bodies, want, hits).map_err(|error| {
            self.device = None;
            hits.clear();
            self.decider.gpu_failed(&error)
        })
    }

    #[cfg(not(feature = "gpu"))]
    fn ask_gpu(&mut self, _: &Bodies, _: Want, _: &mut Vec<SceneHit>) -> Result<(Given, u32), Way> {
        Err(Way::Alone)
    }

    #[cfg(feature = "gpu")]
    fn has_gpu(&self) -> bool {
        self.device.is_some()
    }

    #[cfg(not(feature = "gpu"))]
    fn has_gpu(&self) -> bool {
        false
    }

    /// The ways that there are.
    fn offer(&self, accuracy: Accuracy, bodies: &Bodies, known: Known) -> Offer {
        let (gpu, gpu_upkeep) = self.gpu(accuracy, bodies);
        Offer {
            threads: self.decider.planner().threads(self.most),
            gpu,
            gpu_upkeep,
            known,
            moves: false,
            queries: self.queries,
            upkeep: self.broad.as_secs_f64() * 1e9,
            unmade: 0.0,
        }
    }

    /// What has to be brought to the GPU first, and what it has to do in each frame.
    #[cfg(feature = "gpu")]
    fn gpu(&self, accuracy: Accuracy, bodies: &Bodies) -> (Option<f64>, f64) {
        let planner = self.decider.planner();
        match &self.device {
            Some(device) if accuracy == Accuracy::Exact => {
                let upload = planner.upload(device.owed(bodies));
                (upload, device.upkeep(bodies, planner))
            }
            _ => (None, 0.0),
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn gpu(&self, _: Accuracy, _: &Bodies) -> (Option<f64>, f64) {
        (None, 0.0)
    }
}
