//! What the frames so far tell of the next, and which way to take.
//!
//! A frame costs about as many box tests as the last one, or, where frames jump, as frames do on average. What
//! that takes each way is predicted by the [`Machine`], and corrected by what the way took before. Another way is
//! taken once it saves what changing costs: some part of a frame elsewhere, or an upload to the GPU, in as many
//! frames as there were so far. That is about the rule of ski rental, which takes at most twice what the best would
//! have taken who knew the future; and it is what keeps plans from swinging to and fro.

mod known;
mod predict;
mod way;

pub(crate) use way::{Choice, Frame, Offer, Way};

use super::Machine;
use super::forecast::Forecast;
use known::{HOPELESS, Known, Ratio, SHORT};
use predict::predicted;
use way::{ALONE, BOTH, GPU, THREADS, WAYS};

/// An unknown question is begun on the calling thread for as long as it takes to fork so many times: it then
/// has cost little beside what it will.
const FORKS: f64 = 1.0;
/// A question that is asked alone may cost so many times what is expected before others are called in.
const SURELY: f64 = 4.0;
/// A question is brief if it would have to cost so many times what is expected before others could help.
const BRIEF: f64 = 2.0;
/// Where costs jump, others are called in only after this part of their time has been spent alone.
const PROBE: f64 = 0.05;
/// A question that outgrew what it was begun with is taken to be so many times larger: ...
const OUTGROWN: f64 = 2.0;
/// ... and so many if nothing was known of it.
const UNKNOWN: f64 = 8.0;
/// Box tests for each leaf pair that a GPU counts, before that is known.
const PER_LEAF_PAIR: f64 = 60.0;
/// At least so many frames will follow.
const FRAMES: f64 = 2.0;
/// So many of a mesh whose vertices are moved.
const FRAMES_OF_MOTION: f64 = 8.0;
/// Numbers of threads that are told apart.
const NUMBERS: usize = 9;
/// One that was not tried is hoped to be so much better than thought, so that it is.
const UNTRIED: f64 = 0.8;
/// Another number of threads has to be so much better.
const OTHER_NUMBER: f64 = 0.93;
/// Part of a frame that changing costs, unless it is known better.
const CHANGING: f64 = 0.15;
/// How many frames elsewhere it takes to forget most of what a way took too long, at first. Each time it proves
/// to be a mistake to have forgotten, twice as many.
const FORGET: f64 = 100.0;

/// Frames that take less than so many nanoseconds tell nothing of a way.
const TELLING: f64 = 3000.0;

#[derive(Clone, Debug)]
pub(crate) struct History {
    ways: [Known; WAYS],
    /// The ratio of each number of threads, by its logarithm.
    workers: [Ratio; NUMBERS],
    /// The last number of them.
    last_workers: u32,
    current: Option<usize>,
    /// Frames since the way was changed.
    stay: u32,
    forecast: Forecast,
    frames: u32,
    /// Box tests for each leaf pair that a GPU counts.
    per_leaf_pair: Option<f64>,
}

impl Default for History {
    fn default() -> Self {
        let ratio = Ratio { value: 1.0, frames: 0 };
        let known = Known { ratio, saved: 0.0, forget: FORGET };
        Self {
            ways: [known; WAYS],
            workers: [ratio; NUMBERS],
            last_workers: 0,
            current: None,
            stay: 0,
            forecast: Forecast::default(),
            frames: 0,
            per_leaf_pair: None,
        }
    }
}

impl History {
    /// The cost up to which a question can be asked alone without a thought, if it is likely to stay below.
    pub(crate) fn brief(&self, machine: &Machine) -> Option<f64> {
        // In less nobody else has even begun.
        let question = machine.device.as_ref().map_or(f64::INFINITY, |device| device.question);
        let others = if machine.threads > 1 { machine.fork } else { TELLING };
        let most = others.min(question).max(TELLING) / machine.test;
        let expected = self.forecast.cost().unwrap_or(0.0);
        (BRIEF * expected <= most && !self.forecast.is_jumpy()).then_some(most)
    }

    /// Takes note of the cost of a frame that was asked so.
    pub(crate) fn learn_cost(&mut self, cost: f64) {
        self.forecast.learn(cost);
        self.frames = self.frames.saturating_add(1);
    }

    /// Decides.
    pub(crate) fn choose(&mut self, machine: &Machine, offer: &Offer) -> Choice {
        let forecast = self.forecast;
        let expected = forecast.cost().or(offer.guess);
        let alone = Choice {
            way: Way::Alone,
            alone_first: None,
            expected,
            gpu_upkeep: offer.gpu_upkeep,
            times: [None; WAYS],
            is_best: true,
        };
        if offer.threads <= 1 && offer.gpu.is_none() {
            return alone;
        }
        let Some(cost) = expected else {
            return Choice { alone_first: Some(begin(machine)), ..alone };
        };
        let (times, ways) = self.predict(machine, offer, cost);
        let best = least(&times);
        let family = self.change(best, &times, offer);
        let way = ways[family];
        let begin = match way {
            // Else a surprise would be walked to its end, however large.
            Way::Alone => Some(begin(machine).max(SURELY * cost)),
            _ if forecast.is_jumpy() => times[family].map(|time| PROBE * time / machine.test),
            _ => None,
        };
        Choice { way, alone_first: begin, times, is_best: family == best, ..alone }
    }

    /// Decides once more, where a question that was begun alone is not over after this cost.
    pub(crate) fn outgrown(
        &mut self,
        machine: &Machine,
        offer: &Offer,
        choice: &Choice,
        cost: f64,
    ) -> Choice {
        if choice.way != Way::Alone {
            return Choice { alone_first: None, ..*choice };
        }
        let expected = if choice.expected.is_some() { OUTGROWN } else { UNKNOWN } * cost;
        let (mut times, ways) = self.predict(machine, offer, expected);
        times[ALONE] = None;
        if choice.expected.is_none() && offer.threads > 1 {
            // A guess is not worth an upload, and threads count what it costs.
            (times[GPU], times[BOTH]) = (None, None);
        }
        let best = least(&self.with_upload(&times, offer));
        Choice {
            way: ways[best],
            alone_first: None,
            expected: Some(expected),
            times,
            is_best: true,
            ..*choice
        }
    }

    /// Takes note of what a frame took, of its cost in box tests if that was counted, else of the leaf pairs
    /// that a GPU found.
    pub(crate) fn learn(&mut self, machine: &Machine, way: Way, frame: &Frame) {
        let forecast = &mut self.forecast;
        let cost = match (frame.cost, frame.leaf_pairs, self.per_leaf_pair) {
            (Some(cost), ..) => Some(cost),
            (None, Some(pairs), Some(each)) => Some(each * f64::from(pairs)),
            (None, Some(pairs), None) => match forecast.cost().filter(|_| pairs > 0) {
                Some(cost) => {
                    self.per_leaf_pair = Some(cost / f64::from(pairs));
                    Some(cost)
                }
                None => Some(PER_LEAF_PAIR * f64::from(pairs)),
            },
            (None, None, _) => None,
        };
        self.frames = self.frames.saturating_add(1);
        if let Some(cost) = cost {
            forecast.learn(cost);
        }
        let family = way.family();
        if self.current != Some(family) {
            if let Some(left) = self.current.filter(|_| self.stay < SHORT) {
                self.ways[left].forget *= 2.0;
            }
            (self.current, self.stay) = (Some(family), 0);
            self.ways.iter_mut().for_each(|known| known.saved = 0.0);
        }
        self.stay = self.stay.saturating_add(1);
        for (other, known) in self.ways.iter_mut().enumerate().filter(|&(way, _)| way != family) {
            known.ratio.forget(known.forget);
            if other == THREADS {
                self.workers.iter_mut().for_each(|own| own.forget(known.forget));
            }
        }
        let Some(cost) = cost.or(forecast.cost()) else { return };
        let upkeep = if way == Way::Gpu { frame.gpu_upkeep } else { 0.0 };
        let predicted = predicted(machine, way, cost) + upkeep;
        if predicted < TELLING {
            return;
        }
        let sample = (frame.nanoseconds - frame.beside) / predicted;
        let known = &mut self.ways[family];
        if let Way::Threads(workers) = way {
            let own = &mut self.workers[slot(workers)];
            if own.frames == 0 {
                *own = known.ratio;
            }
            own.learn(sample);
            self.last_workers = workers;
        }
        known.ratio.learn(sample);
    }

    /// The current way, or `best` if that has earned it.
    fn change(&mut self, best: usize, times: &[Option<f64>; WAYS], offer: &Offer) -> usize {
        let Some((current, now)) = self.current.and_then(|way| Some((way, times[way]?))) else {
            return least(&self.with_upload(times, offer));
        };
        // One frame is no trial.
        if self.ways[current].ratio.frames == 1 && now < HOPELESS * times[best].unwrap_or(now) {
            return current;
        }
        for (known, time) in self.ways.iter_mut().zip(times) {
            known.saved = time.map_or(0.0, |time| (known.saved + now - time).max(0.0));
        }
        let (saved, time) = (self.ways[best].saved, times[best].unwrap_or(now));
        let upload = if best >= GPU { offer.gpu.unwrap_or(0.0) } else { 0.0 };
        let pays = saved + (now - time) * self.horizon(offer) >= upload;
        if pays && saved >= CHANGING * now { best } else { current }
    }

    /// What each way takes with its part of an upload.
    fn with_upload(&self, times: &[Option<f64>; WAYS], offer: &Offer) -> [Option<f64>; WAYS] {
        let mut times = *times;
        for time in times[GPU..].iter_mut().flatten() {
            *time += offer.gpu.unwrap_or(0.0) / self.horizon(offer);
        }
        times
    }

    /// How many frames there will be, for all that is known: as many more as there were.
    fn horizon(&self, offer: &Offer) -> f64 {
        let least = if offer.moves { FRAMES_OF_MOTION } else { FRAMES };
        least + f64::from(self.frames)
    }
}

fn least(times: &[Option<f64>; WAYS]) -> usize {
    let times = times.iter().enumerate().filter_map(|(way, time)| Some((way, (*time)?)));
    times.min_by(|x, y| x.1.total_cmp(&y.1)).map_or(ALONE, |(way, _)| way)
}

/// The place of a number of threads.
fn slot(workers: u32) -> usize {
    (workers.max(1).ilog2() as usize).min(NUMBERS - 1)
}

/// The cost with which an unknown question is begun.
fn begin(machine: &Machine) -> f64 {
    FORKS * machine.fork_of(machine.threads.max(2)) / machine.test
}

#[cfg(test)]
mod tests;
