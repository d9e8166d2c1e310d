//! What frames tell.

use super::known::{Ratio, SHORT};
use super::predict::predicted;
use super::way::{ALONE, Frame, THREADS, Way};
use super::{History, TELLING, slot};
use crate::planner::Machine;

/// Box tests for each leaf pair that a GPU counts, before that is known.
const PER_LEAF_PAIR: f64 = 60.0;
/// What becomes of the forecast of a first pair with each frame in which a GPU has found it.
const FADING: f64 = 0.9;
/// To call in others after a look takes so much of the time that the first of them takes to get to work.
const LATE: f64 = 0.4;
/// Weight of a frame in what it would save to do without a look.
const AMONG_JUMPS: f64 = 0.1;

impl History {
    /// Takes note of the cost of a frame that was asked so.
    pub(crate) fn learn_cost(&mut self, machine: &Machine, cost: f64) {
        self.forecast.learn(cost, None);
        if self.forecast.is_jumpy() {
            self.learn_at_once(machine, cost);
        }
        self.frames = self.frames.saturating_add(1);
    }

    /// Takes note of what a frame took, of its cost in box tests if that was counted, else of the leaf pairs
    /// that a GPU found.
    pub(crate) fn learn(&mut self, machine: &Machine, way: Way, frame: &Frame) {
        let forecast = &mut self.forecast;
        let size = frame.known.size;
        let before = forecast.cost(size);
        let cost = match (frame.cost, frame.leaf_pairs, self.per_leaf_pair) {
            // What a GPU counts is what there is, however near the first pair was. That is tried when it has
            // been hoped for long enough.
            (None, Some(pairs), each) if frame.known.until_first => before
                .map(|cost| FADING * cost.min(each.unwrap_or(PER_LEAF_PAIR) * f64::from(pairs))),
            (Some(cost), ..) => Some(cost),
            (None, Some(pairs), Some(each)) => Some(each * f64::from(pairs)),
            (None, Some(pairs), None) => match before.filter(|_| pairs > 0) {
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
            // What a GPU counts is of all, whatever has changed.
            forecast.learn(cost, size.filter(|_| frame.cost.is_some()));
            if let Some(look) = frame.look {
                forecast.learn_rest(look, cost);
            }
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
        if let Some(cost) = cost {
            self.learn_at_once(machine, cost);
        }
        let Some(cost) = cost.or(before).or(frame.known.guess) else { return };
        self.begun = frame.pace.or(self.begun);
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
        match (way, known.ratio.frames) {
            // Which needs no waking.
            (Way::Alone, 0) => known.ratio = Ratio { value: sample.clamp(0.1, 30.0), frames: 1 },
            _ => known.ratio.learn(sample),
        }
    }

    /// Had others been called in at once: what would that have saved?
    fn learn_at_once(&mut self, machine: &Machine, cost: f64) {
        if machine.threads <= 1 {
            return;
        }
        let threaded = Machine::worker_counts(machine.threads).map(|p| machine.threaded(cost, p));
        let threads = self.ratio(THREADS, ALONE) * threaded.fold(f64::INFINITY, f64::min);
        let after_a_look = self.alone(machine, cost).min(threads + LATE * machine.fork);
        self.at_once += AMONG_JUMPS * (after_a_look - threads - self.at_once);
    }
}
