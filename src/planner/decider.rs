//! One query's planner at work: a clock, what is known, and what was decided in the last frame.

use super::history::{Choice, Frame, History, Known, Look, Offer, Way};
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
    begun: Option<Instant>,
    /// What has been decided before the question was asked, and of which history.
    ahead: Option<(usize, Choice)>,
    /// What was done before the question, for its sake.
    prepared: Duration,
    /// What was done in vain.
    lost: Duration,
    /// When to look at a question that was begun alone, once the clock has been looked at ...
    next_look: Option<f64>,
    /// ... which was at this cost and time.
    marked: Option<(f64, Duration)>,
    /// The first look at a question that was begun alone.
    looked: Option<Look>,
    /// The last frame that was worth a look at the clock, ...
    last: Option<Last>,
    /// ... unless there was another one since.
    untimed: Option<(Backend, Reason, Option<f64>)>,
    failure: Option<String>,
    /// Counts frames in which deciding may be timed.
    frames: u32,
    deciding: Duration,
}

/// A frame, from which its plan is made if anyone asks.
#[derive(Clone, Copy, Debug)]
struct Last {
    backend: Backend,
    reason: Reason,
    choice: Option<Choice>,
    cost: Option<f64>,
    actual: Duration,
    concession: Option<Concession>,
}

/// The clock is not looked at before a question has cost this much: that takes as long on some machines.
const MARK: f64 = 250.0;

/// Deciding is timed in so many frames at first and in one of so many from then on: to look at the clock takes as long.
const TIMED: u32 = 16;

impl Decider {
    pub(crate) fn new(planner: Planner) -> Self {
        Self {
            planner,
            histories: Default::default(),
            asked: 0,
            begun: None,
            ahead: None,
            prepared: Duration::ZERO,
            lost: Duration::ZERO,
            next_look: None,
            marked: None,
            looked: None,
            last: None,
            untimed: None,
            failure: None,
            frames: 0,
            deciding: Duration::ZERO,
        }
    }

    pub(crate) fn planner(&self) -> &Planner {
        &self.planner
    }

    /// Of the last frame, once there was one.
    pub(crate) fn plan(&self) -> Option<Plan> {
        if let Some((backend, reason, cost)) = self.untimed {
            return Some(Plan { backend, reason, cost, ..Plan::SMALL });
        }
        let Last { backend, reason, choice, cost, actual, concession } = self.last?;
        let time = |nanoseconds: f64| Duration::from_nanos(nanoseconds as u64);
        Some(Plan {
            backend,
            reason,
            expected_cost: choice.and_then(|choice| choice.expected),
            cost,
            predicted: choice.and_then(|choice| choice.time()).map(time),
            alternatives: choice.map_or([None; 4], |choice| choice.times.map(|t| t.map(time))),
            actual,
            deciding: self.deciding,
            concession,
            failure: self.failure.clone(),
        })
    }

    /// Whether the last answer is not what was asked for.
    pub(crate) fn has_conceded(&self) -> bool {
        self.untimed.is_none() && self.last.is_some_and(|last| last.concession.is_some())
    }

    /// Decides who will answer the next question, before it is asked: whoever moves a model can then prepare it
    /// for that, and says with [`Decider::prepared`] how long it took.
    pub(crate) fn look_ahead(&mut self, offer: &Offer) -> Choice {
        // It will be asked what was asked last.
        let choice = self.histories[self.asked].choose(self.planner.machine(), offer);
        self.ahead = Some((self.asked, choice));
        choice
    }

    pub(crate) fn prepared(&mut self, took: Duration) {
        self.prepared += took;
    }

    /// A question is about to be asked. Whether its size is worth finding out.
    pub(crate) fn is_large(&mut self, until_first: bool) -> bool {
        self.asked = usize::from(until_first);
        self.histories[self.asked].is_large()
    }

    /// The cost up to which it is begun alone, with no thought.
    pub(crate) fn begin(&mut self, known: Known) -> Option<f64> {
        (self.looked, self.marked, self.next_look) = (None, None, None);
        if self.ahead.is_some() || self.planner.limits().time.is_some() {
            return None;
        }
        let begin = self.histories[self.asked].begin(self.planner.machine(), known)?;
        self.next_look = begin.is_timed.then_some(begin.until);
        Some(if begin.is_timed { MARK.min(begin.until) } else { begin.until })
    }

    /// So much is done. If it is time for the first look at the clock and no more, how far to go on.
    pub(crate) fn mark(&mut self, spent: f64) -> Option<f64> {
        let until = self.next_look.take()?;
        self.clock(spent);
        self.marked = Some((spent, self.elapsed()));
        Some(until.max(2.0 * spent))
    }

    /// It did stay below.
    pub(crate) fn was_brief(&mut self, cost: f64) {
        self.histories[self.asked].learn_cost(self.planner.machine(), cost);
        self.end_as(Backend::Sequential, Reason::Small, Some(cost));
    }

    /// What has been decided and prepared ahead has come to nothing.
    pub(crate) fn forget_ahead(&mut self) {
        (self.ahead, self.prepared) = (None, Duration::ZERO);
    }

    /// There is nothing to do.
    pub(crate) fn keep(&mut self) {
        self.forget_ahead();
        self.end_as(Backend::Kept, Reason::Unchanged, None);
    }

    fn end_as(&mut self, backend: Backend, reason: Reason, cost: Option<f64>) {
        self.untimed = Some((backend, reason, cost));
    }

    /// Begins a frame, whose query will be asked later. No clock is needed if it is like one that needed none.
    pub(crate) fn start(&mut self) {
        let is_timed = self.last.is_some() && self.untimed.is_none();
        self.begun = is_timed.then(Instant::now);
    }

    /// Begins a frame that is a query and no more.
    pub(crate) fn start_asking(&mut self) {
        self.begun = None;
    }

    /// Looks at the clock, if that has not been done in this frame. So much has been done alone; what was done
    /// before that is the same each way.
    pub(crate) fn clock(&mut self, spent: f64) {
        let alone = self.alone(spent);
        self.lost = Duration::ZERO;
        match self.begun {
            None => self.begun = Instant::now().checked_sub(alone),
            Some(_) => self.lost = self.elapsed().saturating_sub(alone),
        }
    }

    fn alone(&self, cost: f64) -> Duration {
        Duration::from_nanos((cost * self.planner.machine().test) as u64)
    }

    /// Decides who answers.
    pub(crate) fn choose(&mut self, offer: &Offer) -> Choice {
        let choice = match self.ahead.take().filter(|(of, _)| *of == self.asked) {
            Some((_, choice)) => choice,
            None => {
                let history = &mut self.histories[self.asked];
                history.choose(self.planner.machine(), offer)
            }
        };
        let reason = if choice.expected.is_none() && choice.alone_until.is_some() {
            Reason::Unknown
        } else if choice.time().is_none() {
            Reason::OnlyWay
        } else if choice.is_best {
            Reason::Fastest
        } else {
            Reason::NotWorthChanging
        };
        self.note(choice, reason, None);
        if self.frames < TIMED || self.frames.is_multiple_of(TIMED) {
            self.deciding = self.elapsed().saturating_sub(self.lost);
        }
        self.frames = self.frames.wrapping_add(1);
        choice
    }

    /// Decides about what was begun alone and is not over, after `choice` if there was one.
    pub(crate) fn look(
        &mut self,
        offer: &Offer,
        choice: Option<&Choice>,
        [spent, rest]: [f64; 2],
    ) -> Choice {
        if choice.is_none() && self.marked.is_none() {
            self.clock(spent);
        }
        let nanoseconds = self.marked.map(|(before, time)| {
            let took = self.elapsed().saturating_sub(time).as_secs_f64() * 1e9;
            took * spent / (spent - before)
        });
        let look = Look { spent, rest, nanoseconds };
        let history = &self.histories[self.asked];
        let next = history.look(self.planner.machine(), offer, look);
        let known = choice.is_some_and(|choice| choice.expected.is_some());
        let reason = match next.way {
            Way::Alone if !known => Reason::Unknown,
            _ => Reason::Outgrown,
        };
        if next.way != Way::Alone {
            self.lost = self.elapsed();
        }
        self.looked.get_or_insert(look);
        let conceded = choice.and(self.last).and_then(|last| last.concession);
        self.note(next, reason, conceded);
        next
    }

    /// Goes on without a GPU, and says how.
    #[cfg(feature = "gpu")]
    pub(crate) fn gpu_failed(&mut self, error: &crate::gpu::Error) -> Way {
        self.lost = self.elapsed();
        if let Some(last) = &mut self.last {
            last.reason = Reason::GpuFailed;
        }
        self.failure = Some(format!("the GPU is not used any more: {error}"));
        match self.planner.threads(0) {
            1 => Way::Alone,
            threads => Way::Threads(threads),
        }
    }

    /// Ends a frame.
    pub(crate) fn end(&mut self, way: Way, cost: Option<f64>, leaf_pairs: Option<u32>) {
        let beside = self.lost + std::mem::take(&mut self.prepared);
        let actual = self.finish(way, beside - self.lost, cost);
        let nanoseconds = |time: Duration| time.as_secs_f64() * 1e9;
        let frame = Frame {
            nanoseconds: nanoseconds(actual),
            beside: nanoseconds(beside),
            gpu_upkeep: self
                .last
                .and_then(|last| last.choice)
                .map_or(0.0, |choice| choice.gpu_upkeep),
            size: self.last.and_then(|last| last.choice).and_then(|choice| choice.size),
            look: self.looked,
            cost,
            leaf_pairs,
        };
        self.histories[self.asked].learn(self.planner.machine(), way, &frame);
    }

    /// Ends a frame for which time ran out, and which tells nothing of others.
    pub(crate) fn end_incomplete(&mut self, way: Way) {
        let prepared = std::mem::take(&mut self.prepared);
        self.finish(way, prepared, None);
        if let Some(last) = &mut self.last {
            last.concession = Some(Concession::Incomplete);
        }
    }

    fn finish(&mut self, way: Way, prepared: Duration, cost: Option<f64>) -> Duration {
        let actual = self.elapsed() + prepared;
        if let Some(last) = &mut self.last {
            (last.backend, last.cost, last.actual) = (backend(way), cost, actual);
        }
        actual
    }

    /// How exact an answer has to be of which this is wanted.
    pub(crate) fn accuracy(&mut self, wanted: Accuracy) -> Accuracy {
        let limits = self.planner.limits();
        let (Some(most), Some(last)) = (limits.time, &mut self.last) else { return wanted };
        let predicted = last.choice.and_then(|choice| choice.time());
        let late = predicted.is_some_and(|time| time > most.as_secs_f64() * 1e9);
        // They are in the order of what they promise.
        if late && limits.accuracy as u8 > wanted as u8 {
            last.concession = Some(Concession::LessAccurate);
            return limits.accuracy;
        }
        wanted
    }

    /// When to end, complete or not.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        let limits = self.planner.limits();
        limits.time.filter(|_| limits.incomplete).and_then(|time| self.begun?.checked_add(time))
    }

    fn note(&mut self, choice: Choice, reason: Reason, concession: Option<Concession>) {
        let (backend, actual) = (backend(choice.way), Duration::ZERO);
        self.untimed = None;
        let choice = Some(choice);
        self.last = Some(Last { backend, reason, choice, cost: None, actual, concession });
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
