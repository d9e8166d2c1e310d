//! One query's planner at work: a clock, what is known, and the plan of the last frame.

use super::history::{Choice, Frame, History, Offer, Way};
use super::plan::{Backend, Plan, Reason};
use super::{Concession, Planner};
use crate::Accuracy;
use std::time::{Duration, Instant};

#[derive(Clone, Debug)]
pub(crate) struct Decider {
    planner: Planner,
    /// Of whole answers, and of those that stop at the first pair.
    histories: [History; 2],
    /// The history of the last question.
    asked: usize,
    plan: Plan,
    begun: Option<Instant>,
    /// Whether there was a frame.
    is_planned: bool,
    /// What has been decided before the question was asked.
    ahead: Option<Choice>,
    /// What was done before the question, for its sake.
    prepared: Duration,
    /// What was done in vain.
    lost: Duration,
}

impl Decider {
    pub(crate) fn new(planner: Planner) -> Self {
        Self {
            planner,
            histories: Default::default(),
            asked: 0,
            plan: Plan::default(),
            begun: None,
            is_planned: false,
            ahead: None,
            prepared: Duration::ZERO,
            lost: Duration::ZERO,
        }
    }

    pub(crate) fn planner(&self) -> &Planner {
        &self.planner
    }

    /// Of the last frame, once there was one.
    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.is_planned.then_some(&self.plan)
    }

    /// Decides who will answer the next question, before it is asked: whoever moves a model can then prepare it
    /// for that, and says with [`Decider::prepared`] how long it took.
    pub(crate) fn look_ahead(&mut self, offer: &Offer) -> Choice {
        let choice = self.histories[0].choose(&self.planner.machine, offer);
        self.ahead = Some(choice);
        choice
    }

    pub(crate) fn prepared(&mut self, took: Duration) {
        self.prepared += took;
    }

    /// A frame is not worth a thought, nor a look at the clock.
    pub(crate) fn small(&mut self) {
        let failure = self.plan.failure.take();
        self.plan = Plan { reason: Reason::Small, failure, ..Plan::default() };
        (self.ahead, self.prepared) = (None, Duration::ZERO);
        self.is_planned = true;
    }

    /// Begins a frame.
    pub(crate) fn start(&mut self) {
        self.begun = Some(Instant::now());
        self.is_planned = true;
        self.lost = Duration::ZERO;
    }

    /// What was done up to now in this frame is the same each way.
    pub(crate) fn set_aside(&mut self) {
        self.lost = self.elapsed();
    }

    /// There is nothing to do.
    pub(crate) fn keep(&mut self) {
        let failure = self.plan.failure.take();
        let (backend, reason) = (Backend::Kept, Reason::Unchanged);
        self.plan = Plan { backend, reason, failure, ..Plan::default() };
        (self.ahead, self.prepared) = (None, Duration::ZERO);
        self.plan.actual = self.elapsed();
    }

    /// Decides who answers.
    pub(crate) fn choose(&mut self, offer: &Offer, until_first: bool) -> Choice {
        self.asked = usize::from(until_first);
        let choice = match self.ahead.take().filter(|_| !until_first) {
            Some(choice) => choice,
            None => {
                let history = &mut self.histories[self.asked];
                history.choose(&self.planner.machine, offer)
            }
        };
        self.plan.concession = None;
        self.note(&choice);
        self.plan.deciding = self.elapsed() - self.lost;
        choice
    }

    /// Decides once more: what was begun alone is not over after so many tests.
    pub(crate) fn outgrown(&mut self, offer: &Offer, choice: &Choice, cost: f64) -> Choice {
        self.lost = self.elapsed();
        let next = self.histories[self.asked].outgrown(&self.planner.machine, offer, choice, cost);
        self.note(&next);
        if choice.way == Way::Alone {
            self.plan.reason = Reason::Outgrown;
        }
        next
    }

    /// Goes on without a GPU.
    #[cfg(feature = "gpu")]
    pub(crate) fn gpu_failed(&mut self, offer: &Offer, error: &crate::gpu::Error) -> Choice {
        self.lost = self.elapsed();
        let next = self.histories[self.asked].choose(&self.planner.machine, offer);
        self.note(&next);
        self.plan.reason = Reason::GpuFailed;
        self.plan.failure = Some(format!("the GPU is not used any more: {error}"));
        Choice { alone_first: None, ..next }
    }

    /// Ends a frame.
    pub(crate) fn end(&mut self, way: Way, cost: Option<f64>, leaf_pairs: Option<u32>) {
        let prepared = std::mem::take(&mut self.prepared);
        self.plan.backend = backend(way);
        self.plan.cost = cost;
        self.plan.actual = self.elapsed() + prepared;
        let nanoseconds = |time: Duration| time.as_secs_f64() * 1e9;
        let frame = Frame {
            nanoseconds: nanoseconds(self.plan.actual),
            beside: nanoseconds(prepared + self.lost),
            cost,
            leaf_pairs,
        };
        self.histories[self.asked].learn(&self.planner.machine, way, &frame);
    }

    /// How exact an answer has to be of which this is wanted.
    pub(crate) fn accuracy(&mut self, wanted: Accuracy) -> Accuracy {
        let limits = &self.planner.limits;
        let late = self.plan.predicted.zip(limits.time).is_some_and(|(time, most)| time > most);
        // They are in the order of what they promise.
        if late && limits.accuracy as u8 > wanted as u8 {
            self.plan.concession = Some(Concession::LessAccurate);
            return limits.accuracy;
        }
        wanted
    }

    /// When to end, complete or not.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        let limits = &self.planner.limits;
        limits.time.filter(|_| limits.incomplete).and_then(|time| self.begun?.checked_add(time))
    }

    /// Ends a frame for which time ran out, and which tells nothing of others.
    pub(crate) fn end_incomplete(&mut self, way: Way) {
        let prepared = std::mem::take(&mut self.prepared);
        self.plan.backend = backend(way);
        self.plan.cost = None;
        self.plan.concession = Some(Concession::Incomplete);
        self.plan.actual = self.elapsed() + prepared;
    }

    fn note(&mut self, choice: &Choice) {
        let time = |nanoseconds: f64| Duration::from_nanos(nanoseconds as u64);
        self.plan.expected_cost = choice.expected;
        self.plan.alternatives = choice.times.map(|t| t.map(time));
        self.plan.predicted = choice.time().map(time);
        self.plan.backend = backend(choice.way);
        self.plan.reason = if choice.expected.is_none() && choice.alone_first.is_some() {
            Reason::Unknown
        } else if choice.time().is_none() {
            Reason::OnlyWay
        } else if choice.is_best {
            Reason::Fastest
        } else {
            Reason::NotWorthChanging
        };
    }

    fn elapsed(&self) -> Duration {
        self.begun.map_or(Duration::ZERO, |begun| begun.elapsed())
    }
}

fn backend(way: Way) -> Backend {
    match way {
        Way::Alone => Backend::Sequential,
        Way::Threads(workers) => Backend::Threads { workers },
        Way::Gpu => Backend::Gpu,
        Way::Both(workers, share) => Backend::Hybrid { workers, share: share as f32 },
    }
}
