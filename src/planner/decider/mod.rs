//! One query's planner at work: a clock, what is known, and what was decided in the last frame.

mod end;

use super::clock::Clock;
use super::history::{Choice, History, Known, Look, Offer, Way};
use super::last::Last;
use super::plan::{Backend, Plan, Reason};
use super::{Concession, Planner};
use crate::Accuracy;
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use std::time::{Duration, Instant};

#[derive(Clone, Debug)]
pub(crate) struct Decider {
    planner: Planner,
    /// Histories of whole answers, and of those that stop at the first pair.
    histories: [History; 2],
    /// The history of the last question.
    asked: usize,
    clock: Clock,
    /// What has been decided before the question was asked, and of which history.
    ahead: Option<(usize, Choice)>,
    /// What was done before the question, for its sake.
    prepared: Duration,
    /// When to look at a question that was begun alone, once the clock has been looked at.
    next_look: Option<f64>,
    /// The first look at a question that was begun alone.
    looked: Option<Look>,
    /// Nanoseconds of a box test, as of the last look.
    pace: Option<f64>,
    /// The last frame that was worth a look at the clock, ...
    last: Option<Last>,
    /// ... unless there was another one since.
    untimed: Option<(Backend, Reason, Option<f64>)>,
    failure: Option<String>,
    /// Whether the GPU has failed in this frame.
    has_failed: bool,
    /// Whether the last frame was not answered by threads.
    was_elsewhere: bool,
    /// Counts frames in which deciding may be timed.
    frames: u32,
    deciding: Duration,
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
            clock: Clock::default(),
            ahead: None,
            prepared: Duration::ZERO,
            next_look: None,
            looked: None,
            pace: None,
            last: None,
            untimed: None,
            failure: None,
            has_failed: false,
            was_elsewhere: false,
            frames: 0,
            deciding: Duration::ZERO,
        }
    }

    pub(crate) fn planner(&self) -> &Planner {
        &self.planner
    }

    /// The plan of the last frame, once there was one.
    pub(crate) fn plan(&self) -> Option<Plan> {
        let plan = match self.untimed {
            Some((backend, reason, cost)) => Plan { backend, reason, cost, ..Plan::SMALL },
            None => self.last?.plan(),
        };
        Some(Plan { deciding: self.deciding, failure: self.failure.clone(), ..plan })
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

    /// Whether the last question of this kind was answered by a GPU, and the next one may be as well.
    pub(crate) fn is_on_gpu(&self) -> bool {
        self.planner.limits().time.is_none() && self.histories[self.asked].is_on_gpu()
    }

    pub(crate) fn prepared(&mut self, took: Duration) {
        self.prepared = took;
    }

    /// A question is about to be asked, perhaps for the first pair only.
    pub(crate) fn ask(&mut self, until_first: bool) {
        self.asked = usize::from(until_first);
        (self.looked, self.pace, self.next_look) = (None, None, None);
    }

    /// Whether its size is worth finding out.
    pub(crate) fn is_large(&self) -> bool {
        self.histories[self.asked].is_large()
    }

    /// The cost up to which it is begun alone, with no thought.
    pub(crate) fn begin(&mut self, known: Known) -> Option<f64> {
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
        self.clock.mark(spent);
        Some(until.max(2.0 * spent))
    }

    /// What has been decided and prepared ahead has come to nothing.
    pub(crate) fn forget_ahead(&mut self) {
        (self.ahead, self.prepared) = (None, Duration::ZERO);
    }

    /// Begins a frame, whose query will be asked later. No clock is needed if it is like one that needed none.
    pub(crate) fn start(&mut self) {
        let is_limited = self.planner.limits().time.is_some();
        let is_timed = is_limited || self.last.is_some() && self.untimed.is_none();
        self.clock = Clock::started(is_timed);
    }

    /// Begins a frame that is a query and no more.
    pub(crate) fn start_asking(&mut self, until_first: bool) {
        self.ask(until_first);
        self.clock = Clock::started(false);
    }

    /// Looks at the clock, if that has not been done in this frame. So much has been done alone; what was done
    /// before that is the same each way.
    pub(crate) fn clock(&mut self, spent: f64) {
        let alone = spent * self.planner.machine().test;
        self.clock.look(Duration::from_nanos(alone as u64));
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
            self.deciding = self.clock.spent();
        }
        self.frames = self.frames.wrapping_add(1);
        choice
    }

    /// All up to now was done for this question and others to come.
    pub(crate) fn made(&mut self) {
        self.clock.lose();
    }

    /// Decides about what was begun alone and is not over, after `choice` if there was one.
    pub(crate) fn look(
        &mut self,
        offer: &Offer,
        choice: Option<&Choice>,
        [spent, rest]: [f64; 2],
    ) -> Choice {
        if choice.is_none() && !self.clock.is_marked() {
            self.clock(spent);
        }
        let look = Look { spent, rest, nanoseconds: self.clock.pace(spent) };
        let history = &self.histories[self.asked];
        let next = history.look(self.planner.machine(), offer, look);
        let was_unknown = || self.last.is_some_and(|last| last.reason == Reason::Unknown);
        let reason = match (next.way, choice) {
            (Way::Alone, None) => Reason::Unknown,
            (Way::Alone, Some(_)) if was_unknown() => Reason::Unknown,
            _ => Reason::Outgrown,
        };
        if next.way != Way::Alone {
            self.clock.lose();
        }
        self.looked.get_or_insert(look);
        self.pace = look.nanoseconds.map(|took| took / spent.max(1.0));
        let conceded = choice.and(self.last).and_then(|last| last.concession);
        self.note(next, reason, conceded);
        next
    }

    /// How exact an answer has to be of which this is wanted.
    pub(crate) fn accuracy(&mut self, wanted: Accuracy) -> Accuracy {
        let limits = self.planner.limits();
        let (Some(most), Some(last)) = (limits.time, &mut self.last) else { return wanted };
        let predicted = last.choice.time();
        let late = predicted.is_some_and(|time| time > most.as_secs_f64() * 1e9);
        // They are in the order of what they promise.
        if late && limits.accuracy as u8 > wanted as u8 {
            last.concession = Some(Concession::LessAccurate);
            return limits.accuracy;
        }
        wanted
    }

    /// Makes threads ready for a question. Of what they found out in their last frame nothing may be true any
    /// more if others were answered elsewhere since: one of almost nothing would leave all to one worker.
    #[cfg(feature = "threads")]
    pub(crate) fn prepare(&self, traversal: &mut Traversal, workers: u32) {
        if self.was_elsewhere {
            traversal.forget();
        }
        traversal.workers = workers as usize;
        traversal.deadline = self.deadline();
    }

    /// When to end, complete or not.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        let limits = self.planner.limits();
        limits
            .time
            .filter(|_| limits.incomplete)
            .and_then(|time| self.clock.begun()?.checked_add(time))
    }

    fn note(&mut self, choice: Choice, reason: Reason, concession: Option<Concession>) {
        self.untimed = None;
        self.last = Some(Last { concession, ..Last::new(choice, reason) });
    }
}
