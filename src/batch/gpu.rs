//! Answering a batch on a GPU, which submits without waiting; the thread of the executor reads.
//!
//! A batch goes there in parts: pairs of models in f32 are one, as bodies of a world, for as many as a submission holds; a model with itself, a pair in
//! f64, by its shadow, pairs within a distance, and a lone pair are one each. Two parts are submitted at a time, so that the device works on one while
//! the other is read, and the next one gathered. A model in f64 with itself is a part that the thread answers by itself.

use super::cpu::Steps;
use super::found::Found;
use super::job::Job;
use crate::executor::{Device, Gathered, Reader, Seat, Slot, Verb, Work, check, merge_open, read};
use crate::gpu::GpuQuery;
use crate::memory::{push, reserve};
use crate::ticket::{Outcome, Shown};
use crate::{Distance, Error};
use std::collections::{HashSet, VecDeque};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};

/// Submits a batch. Returns the place of the ticket in the queue of the thread, unless there is no question.
pub(super) fn submit<T: Send + 'static>(
    device: &Arc<Device>,
    reader: &Reader,
    job: Job,
    answer: fn(Found) -> T,
) -> Result<(Arc<Outcome<T>>, Option<Seat>), Error> {
    let outcome = Arc::<Outcome<T>>::default();
    if job.questions.is_empty() {
        outcome.set(Ok(answer(Found::default())));
        return Ok((outcome, None));
    }
    let answering = Answering {
        device: device.clone(),
        outcome: outcome.clone(),
        parts: parts(&job).into(),
        in_flight: VecDeque::new(),
        found: Vec::new(),
        failure: None,
        triangles: triangles(&job),
        job,
        answer,
    };
    let seat = reader.add(Box::new(answering), outcome.flag().clone())?;
    Ok((outcome, Some(seat)))
}

/// The questions of a batch that are submitted together.
#[derive(Debug)]
enum Part {
    /// Pairs of models in f32.
    Pairs(Vec<usize>),
    One(usize),
    /// A question that no GPU answers, on the CPU.
    OnCpu(usize),
}

/// The most pairs of a part: a submission of a world has no more.
const PAIRS: usize = 65_535;

fn parts(job: &Job) -> Vec<Part> {
    let (mut pairs, mut others) = (Vec::new(), Vec::new());
    for (number, question) in job.questions.iter().enumerate() {
        if question.is_for_cpu() {
            others.push(Part::OnCpu(number));
        } else if question.pair_in_f32().is_some() && question.distance() == Distance::default() {
            pairs.push(number);
        } else {
            others.push(Part::One(number));
        }
    }
    if let [only] = pairs[..] {
        others.insert(0, Part::One(only));
        return others;
    }
    let pairs = pairs.chunks(PAIRS).map(|part| Part::Pairs(part.to_vec()));
    pairs.chain(others).collect()
}

/// Triangles of the models of pairs in f32, each once.
fn triangles(job: &Job) -> usize {
    let (mut known, mut sum, mut last) = (HashSet::new(), 0, [None; 2]);
    for (models, _) in job.questions.iter().filter_map(|question| question.pair_in_f32()) {
        let stamps = models.map(|model| Some(model.stamp()));
        // Neighbours are mostly about the same models.
        if std::mem::replace(&mut last, stamps) == stamps {
            continue;
        }
        for model in models {
            if known.insert(model.stamp()) {
                sum += model.mesh().triangles().len();
            }
        }
    }
    sum
}

impl Part {
    fn questions(&self) -> &[usize] {
        match self {
            Self::Pairs(numbers) => numbers,
            Self::One(number) | Self::OnCpu(number) => std::slice::from_ref(number),
        }
    }
}

/// A part that has been submitted, with the lists that it was submitted into.
struct InFlight {
    part: Part,
    lists: Submitted,
    /// Dropped after the lists.
    _slot: Option<Slot>,
}

enum Submitted {
    World(Box<Gathered>),
    Query(Box<GpuQuery>),
    Nothing,
}

/// A batch while it is answered.
struct Answering<T> {
    device: Arc<Device>,
    job: Job,
    /// Triangles of the models of all pairs in f32.
    triangles: usize,
    answer: fn(Found) -> T,
    outcome: Arc<Outcome<T>>,
    /// Parts that are left to be submitted, the next one first.
    parts: VecDeque<Part>,
    /// Parts that have been, the oldest first.
    in_flight: VecDeque<InFlight>,
    /// Parts that have been answered.
    found: Vec<(Part, Found)>,
    /// Why the first part could not be submitted.
    failure: Option<Error>,
}

impl<T: Send> Work for Answering<T> {
    fn begin(&mut self) -> Result<bool, Error> {
        let Some(slot) = self.device.slot() else { return Ok(false) };
        let begun = catch_unwind(AssertUnwindSafe(|| self.submit(slot)));
        let begun = begun.unwrap_or(Err(Error::Panicked));
        begun.inspect_err(|error| self.failure = Some(error.clone()))?;
        Ok(true)
    }

    fn finish(mut self: Box<Self>) {
        let outcome = self.outcome.clone();
        outcome.guard(|| {
            let found = self.find()?;
            outcome.set(Ok((self.answer)(found)));
            Ok(())
        });
    }
}

impl<T> Answering<T> {
    fn find(&mut self) -> Result<Found, Error> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        while !self.parts.is_empty() || !self.in_flight.is_empty() {
            check(Some(self.outcome.flag()))?;
            // The ticket whose turn it is never waits for those after it.
            let slot = match self.in_flight.len() {
                0 => Some(self.device.slot_at_once()),
                1 if !self.parts.is_empty() => self.device.slot(),
                _ => None,
            };
            match slot {
                Some(slot) if !self.parts.is_empty() => self.submit(slot)?,
                _ => self.read()?,
            }
        }
        self.merge()
    }

    /// Submits the next part.
    fn submit(&mut self, slot: Slot) -> Result<(), Error> {
        let Some(part) = self.parts.pop_front() else { return Ok(()) };
        let lists = match &part {
            Part::Pairs(numbers) => {
                let pairs: Vec<_> =
                    numbers.iter().filter_map(|&n| self.job.questions[n].pair_in_f32()).collect();
                let mut world = Box::new(self.device.lend_gathered()?);
                world.set_cancel(Some(self.outcome.flag().clone()));
                world.submit(&pairs, self.triangles, self.job.verb)?;
                Submitted::World(world)
            }
            &Part::One(number) => {
                let mut lists = Box::new(self.device.lend()?);
                lists.set_cancel(Some(self.outcome.flag().clone()));
                self.submit_one(number, &mut lists)?;
                if self.job.questions.len() == 1 && self.device.show() {
                    let buffers = [lists.hits_buffer(), lists.count_buffer()].map(Clone::clone);
                    let shown =
                        Shown { device: self.device.clone(), buffers, lists: Mutex::default() };
                    self.outcome.shown.show(shown);
                }
                Submitted::Query(lists)
            }
            Part::OnCpu(_) => Submitted::Nothing,
        };
        let slot = (!matches!(lists, Submitted::Nothing)).then_some(slot);
        self.in_flight.push_back(InFlight { part, lists, _slot: slot });
        Ok(())
    }

    fn submit_one(&self, number: usize, lists: &mut GpuQuery) -> Result<(), Error> {
        let subject = &self.job.questions[number];
        let [a, b] = subject.both();
        let there = [self.device.model(a)?, self.device.model(b)?];
        let outlines = Default::default();
        let left_open = subject.left_open(&outlines)?;
        let there = there.each_ref().map(|model| &**model);
        let question = subject.question(there, left_open.as_ref())?;
        lists.submit(&question, self.job.verb.into())?;
        Ok(())
    }

    /// Reads the oldest part that has been submitted. After an error nobody uses its lists again.
    fn read(&mut self) -> Result<(), Error> {
        let Some(InFlight { part, mut lists, _slot }) = self.in_flight.pop_front() else {
            return Ok(());
        };
        match self.read_part(&part, &mut lists) {
            Ok(found) => {
                self.give_back(lists);
                self.found.push((part, found));
                Ok(())
            }
            Err(error) => {
                if error == Error::Cancelled {
                    self.give_back(lists);
                }
                Err(error)
            }
        }
    }

    fn read_part(&self, part: &Part, lists: &mut Submitted) -> Result<Found, Error> {
        let (mut found, verb) = (Found::default(), self.job.verb);
        match (part, lists) {
            (Part::Pairs(numbers), Submitted::World(world)) => {
                world.read(numbers.len(), verb, &mut found.answers, &mut found.pairs)?;
            }
            (&Part::One(number), Submitted::Query(lists)) => {
                let mut answer = read(lists, verb, &mut found.pairs)?;
                let outlines = Default::default();
                if !lists.open().is_empty()
                    && let Some(tree) = self.job.questions[number].left_open(&outlines)?
                {
                    let intersects = |pair| tree.intersects(pair);
                    answer = merge_open(lists, verb, answer, &mut found.pairs, intersects)?;
                }
                if verb != Verb::All {
                    found.pairs.clear();
                }
                push(&mut found.answers, answer)?;
            }
            _ => {
                for &number in part.questions() {
                    let mut steps = Steps::part(self.job.clone(), number..number + 1);
                    while !steps.step()? {
                        check(Some(self.outcome.flag()))?;
                    }
                    found = steps.found;
                }
            }
        }
        Ok(found)
    }

    /// Gives lists back to the device, or to the ticket that shows them.
    fn give_back(&self, lists: Submitted) {
        match lists {
            Submitted::World(mut world) => {
                world.set_cancel(None);
                self.device.take_back_gathered(*world);
            }
            Submitted::Query(mut lists) => {
                lists.set_cancel(None);
                self.device.take_back(self.outcome.shown.keep(*lists));
            }
            Submitted::Nothing => {}
        }
    }

    /// The answers in the order of questions.
    fn merge(&mut self) -> Result<Found, Error> {
        if let [_] = self.found[..] {
            return Ok(self.found.pop().map(|(_, found)| found).unwrap_or_default());
        }
        let questions = self.job.questions.len();
        // The part of each question, its number there, and the place of its pairs.
        let mut places: Vec<(usize, usize, Range<usize>)> = vec![(0, 0, 0..0); questions];
        for (at, (part, found)) in self.found.iter().enumerate() {
            let mut end = 0;
            for (i, (&number, answer)) in part.questions().iter().zip(&found.answers).enumerate() {
                let start = end;
                if self.job.verb == Verb::All {
                    end += answer.count as usize;
                }
                places[number] = (at, i, start..end);
            }
        }
        let mut all = Found::default();
        reserve(&mut all.answers, questions)?;
        reserve(&mut all.pairs, self.found.iter().map(|(_, found)| found.pairs.len()).sum())?;
        for (at, i, pairs) in places {
            let (_, found) = &self.found[at];
            all.answers.push(found.answers[i]);
            all.pairs.extend_from_slice(&found.pairs[pairs]);
        }
        Ok(all)
    }
}

/// Parts that have been submitted go on; their lists serve the next ticket afterwards.
impl<T> Drop for Answering<T> {
    fn drop(&mut self) {
        for InFlight { lists, _slot, .. } in std::mem::take(&mut self.in_flight) {
            self.give_back(lists);
        }
    }
}
