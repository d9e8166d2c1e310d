//! What the frames so far tell of the next, and which way to take.
//!
//! A frame costs about as many box tests as the last one. Where nothing is known, or frames jump, it is begun alone,
//! and what is left after a while is estimated by the overlap of its boxes, as the paper does with the nodes of a
//! front (Zhang & Kim 2014, eqs. 2 and 3), times how wrong that was before. What it takes each way is predicted by the [`Machine`], and corrected by what the way took before. Another way is
//! taken once it saves what changing costs: some part of a frame elsewhere, or an upload to the GPU, in as many
//! frames as there were so far. That is about the rule of ski rental, which takes at most twice what the best would
//! have taken who knew the future; and it is what keeps plans from swinging to and fro.

mod known;
mod learn;
mod predict;
mod way;

pub(crate) use way::{Begin, Choice, Frame, Known, Look, Offer, Way};

use super::Machine;
use super::forecast::Forecast;
use known::{HOPELESS, OfWay, Ratio, SHORT};
use way::{ALONE, GPU, WAYS};

/// A question is brief if it would have to cost so many times what is expected before others could help.
const BRIEF: f64 = 2.0;
/// An unknown question is looked at after this part of that.
const LOOK: f64 = 0.08;
/// A question that ends with the first pair is looked at after so many times that.
const PATIENCE: f64 = 4.0;
/// It is looked at again when it has cost so many times as much.
const AGAIN: f64 = 3.0;
/// Others are called in after this part of the time that it takes to get the first of them to work, if they would
/// take half as long; the later the less.
const SOON: f64 = 0.3;
/// Others that were never asked have to be so many times faster than they promise.
const DOUBT: f64 = 1.25;
/// A GPU takes so many times as long for larger models than those that it was measured with, which have fewer levels:
/// 1.7 to 3.4 in 16 courses of two bodies that take one thread a millisecond or more.
const LARGER: f64 = 2.0;
/// Box tests in one question can take so many times longer than in another.
const PACE: f64 = 10.0;
/// From so many box tests on it is worth while to find out how large a question is.
const LARGE: f64 = 1000.0;
/// A question that is asked alone may cost so many times what is expected before it is looked at.
const SURELY: f64 = 2.0;
/// At least so many frames will follow.
const FRAMES: f64 = 1.0;
/// So many of a mesh whose vertices are moved.
const FRAMES_OF_MOTION: f64 = 4.0;
/// Numbers of threads that are told apart.
const NUMBERS: usize = 9;
/// A way that was not tried yet counts as this much of its prediction, so that it is tried.
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
    ways: [OfWay; WAYS],
    /// The ratio of each number of threads, by its logarithm.
    workers: [Ratio; NUMBERS],
    /// The last number of them.
    last_workers: u32,
    current: Option<usize>,
    /// Frames since the way was changed.
    stay: u32,
    forecast: Forecast,
    /// Nanoseconds of a box test on the calling thread, as long as that was only seen to begin.
    begun: Option<f64>,
    /// What it would have saved to call in others at once, where nothing is known of a frame, in nanoseconds of
    /// one on average.
    at_once: f64,
    frames: u32,
    /// Box tests for each leaf pair that a GPU counts.
    per_leaf_pair: Option<f64>,
}

impl Default for History {
    fn default() -> Self {
        let ratio = Ratio { value: 1.0, frames: 0 };
        let known = OfWay { ratio, saved: 0.0, forget: FORGET };
        let mut ways = [known; WAYS];
        ways[GPU].ratio.value = LARGER;
        Self {
            ways,
            workers: [ratio; NUMBERS],
            last_workers: 0,
            current: None,
            stay: 0,
            forecast: Forecast::default(),
            begun: None,
            at_once: 0.0,
            frames: 0,
            per_leaf_pair: None,
        }
    }
}

impl History {
    /// How a question is begun alone without a thought: to its end, if that is likely to be near; if nothing is
    /// known, until there is something to go by.
    pub(crate) fn begin(&self, machine: &Machine, known: Known) -> Option<Begin> {
        // In less nobody else has even begun.
        let question = machine.device.as_ref().map_or(f64::INFINITY, |device| device.question);
        let others = if machine.threads > 1 { machine.fork } else { TELLING };
        let most = others.min(question).max(TELLING) / machine.test;
        match self.forecast.cost(known.size).or(known.expected()) {
            Some(expected) if !self.forecast.is_jumpy() => {
                let is_brief = BRIEF * expected <= most;
                let patience = if known.until_first { PATIENCE } else { 1.0 };
                is_brief.then_some(Begin { until: patience * most, is_timed: false })
            }
            _ if known.until_first => Some(Begin { until: PATIENCE * most, is_timed: true }),
            Some(_) if self.at_once > 0.0 => None,
            _ => Some(Begin { until: LOOK * most, is_timed: true }),
        }
    }

    /// Whether the last question was answered by a GPU.
    pub(crate) fn is_on_gpu(&self) -> bool {
        self.current == Some(GPU)
    }

    /// Whether the last question was large enough to compare sizes.
    pub(crate) fn is_large(&self) -> bool {
        self.forecast.cost(None).is_some_and(|cost| cost > LARGE)
    }

    /// Decides.
    pub(crate) fn choose(&mut self, machine: &Machine, offer: &Offer) -> Choice {
        // Who has paid for a GPU does not pay again for what the CPU lacks, before it has paid for itself.
        let horizon = if self.is_on_gpu() { f64::from(self.frames) } else { self.horizon(offer) };
        let upkeep = offer.upkeep + offer.unmade / horizon.max(1.0);
        let offer = &Offer { upkeep, ..*offer };
        let expected = self.forecast.cost(offer.known.size).or(offer.known.expected());
        let alone = Choice { expected, ..Choice::alone(offer) };
        if offer.threads <= 1 && offer.gpu.is_none() {
            return alone;
        }
        let fork = machine.fork / machine.test;
        let Some(cost) = expected else {
            if let Some(times) = self.surely_gpu(machine, offer) {
                return Choice { way: Way::Gpu, times, ..alone };
            }
            return Choice { alone_until: Some(LOOK * fork), ..alone };
        };
        let (times, ways) = self.predict(machine, offer, cost);
        let best = least(&times);
        let family = self.change(best, &times, offer);
        let way = ways[family];
        let alone_until = match way {
            Way::Threads(_) if self.forecast.is_jumpy() && self.at_once <= 0.0 => Some(LOOK * fork),
            // However near the mean is to what is best alone, the next frame may be nothing like it.
            Way::Alone if self.forecast.is_jumpy() => Some(LOOK * fork),
            // Else a surprise would be walked to its end, however large.
            Way::Alone => Some(SURELY * cost.max(fork)),
            _ => None,
        };
        Choice { way, alone_until, times, is_best: family == best, ..alone }
    }

    /// What it takes, if a GPU that finds everything is faster than threads that need not even begin.
    fn surely_gpu(&self, machine: &Machine, offer: &Offer) -> Option<[Option<f64>; WAYS]> {
        let (Some(all), Some(device)) = (offer.known.guess, &machine.device) else { return None };
        let gpu = self.on_gpu(device, all, offer) + offer.gpu? / self.horizon(offer);
        (gpu < offer.upkeep).then_some([Some(offer.upkeep), None, Some(gpu)])
    }

    /// Decides about the rest of a question that was begun alone.
    pub(crate) fn look(&self, machine: &Machine, offer: &Offer, look: Look) -> Choice {
        let Look { spent, nanoseconds, .. } = look;
        // By now that is done.
        let offer = &Offer { upkeep: 0.0, ..*offer };
        let rest = self.forecast.of(look);
        let expected = Some(spent + rest);
        let alone = Choice { expected, alone_until: Some(AGAIN * spent), ..Choice::alone(offer) };
        if offer.threads <= 1 && offer.gpu.is_none() {
            return Choice { alone_until: None, ..alone };
        }
        // What takes longer alone takes as much longer elsewhere.
        let usual = self.alone(machine, spent);
        let pace = nanoseconds.map_or(1.0, |took| (took / usual).clamp(PACE.recip(), PACE));
        let (mut times, ways) = self.predict(machine, offer, pace * (spent + rest));
        // What is done alone is done.
        times[ALONE] = Some(self.alone(machine, pace * rest));
        if self.forecast.cost(None).is_none() && offer.threads > 1 {
            // A guess is not worth an upload, and threads count what it costs.
            times[GPU] = None;
        }
        let best = least(&self.with_upload(&times, offer));
        // The less has been seen, the surer it has to be.
        let doubt = 1.0 + SOON * machine.fork / self.alone(machine, pace * spent);
        if best == ALONE || times[ALONE] < times[best].map(|time| doubt * time) {
            return Choice { times, ..alone };
        }
        Choice { way: ways[best], alone_until: None, times, ..alone }
    }

    /// The current way, or `best` if that has earned it.
    fn change(&mut self, best: usize, times: &[Option<f64>; WAYS], offer: &Offer) -> usize {
        let Some((current, now)) = self.current.and_then(|way| Some((way, times[way]?))) else {
            return least(&self.with_upload(times, offer));
        };
        // One frame is no trial of a GPU that had to be made ready first.
        let is_first = current == GPU && self.ways[current].ratio.frames == 1;
        if is_first && now < HOPELESS * times[best].unwrap_or(now) {
            return current;
        }
        for (known, time) in self.ways.iter_mut().zip(times) {
            known.saved = time.map_or(0.0, |time| (known.saved + now - time).max(0.0));
        }
        let horizon = self.horizon(offer);
        let pays = |&(way, time): &(usize, f64)| {
            let saved = self.ways[way].saved;
            let upload = if way == GPU { offer.gpu.unwrap_or(0.0) } else { 0.0 };
            let gain = now - time;
            gain > 0.0 && saved >= CHANGING * now && saved + gain * horizon >= upload
        };
        let doubted = |(way, time): (usize, &Option<f64>)| {
            let is_known = way == ALONE || self.ways[way].ratio.frames > 0;
            Some((way, if is_known { 1.0 } else { DOUBT } * (*time)?))
        };
        let others = times.iter().enumerate().filter_map(doubted);
        let best = others.filter(pays).min_by(|x, y| x.1.total_cmp(&y.1));
        best.map_or(current, |(way, _)| way)
    }

    /// What each way takes with its part of an upload.
    fn with_upload(&self, times: &[Option<f64>; WAYS], offer: &Offer) -> [Option<f64>; WAYS] {
        let mut times = *times;
        if let Some(time) = &mut times[GPU] {
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

#[cfg(test)]
mod tests;
