//! What a question takes each way.

use super::known::Ratio;
use super::way::{ALONE, GPU, THREADS, WAYS};
use super::{History, OTHER_NUMBER, Offer, PACE, SHORT, UNTRIED, Way, slot};
use crate::planner::Machine;
use crate::planner::machine::Device;

/// What each query adds on threads, for its node of the front, in nanoseconds.
const QUERY: f64 = 300.0;

impl History {
    /// What each way will take, and what it is exactly.
    pub(super) fn predict(
        &self,
        machine: &Machine,
        offer: &Offer,
        cost: f64,
    ) -> ([Option<f64>; WAYS], [Way; WAYS]) {
        let cpu = self.ratio(THREADS, ALONE);
        let mut times = [Some(self.alone(machine, cost) + offer.upkeep), None, None];
        let mut ways = [Way::Alone, Way::Alone, Way::Gpu];
        if offer.threads > 1 {
            // Which number is best, a first frame does not tell.
            let hope = if self.ways[THREADS].ratio.frames > SHORT { UNTRIED } else { 1.0 };
            let time = |workers: u32| {
                let known = self.workers[slot(workers)];
                let ratio = if known.frames > 0 { known.value } else { hope * cpu };
                let last = if workers == self.last_workers { OTHER_NUMBER } else { 1.0 };
                let each = offer.queries.saturating_sub(1) as f64 * QUERY;
                (workers, last * ratio * machine.threaded(cost, workers) + each)
            };
            let all = Machine::worker_counts(offer.threads).map(time);
            let (workers, time) =
                all.fold((1, f64::INFINITY), |x, y| if y.1 < x.1 { y } else { x });
            (times[THREADS], ways[THREADS]) = (Some(time + offer.upkeep), Way::Threads(workers));
        }
        if let (Some(_), Some(device)) = (offer.gpu, &machine.device) {
            times[GPU] = Some(self.on_gpu(device, cost, offer));
        }
        (times, ways)
    }

    /// What so many box tests take the calling thread.
    pub(super) fn alone(&self, machine: &Machine, cost: f64) -> f64 {
        let ratio = match self.begun.filter(|_| self.ways[ALONE].ratio.frames == 0) {
            // The beginning of a question is its slowest part: half of it is believed.
            Some(pace) => (pace / machine.test).clamp(PACE.recip(), PACE).sqrt(),
            None => self.ratio(ALONE, THREADS),
        };
        ratio * machine.alone(cost)
    }

    /// What a question of so many takes a GPU, once it has what it needs.
    pub(super) fn on_gpu(&self, device: &Device, cost: f64, offer: &Offer) -> f64 {
        let Ratio { value, frames } = self.ways[GPU].ratio;
        let (ask, upkeep) = (device.ask(cost), offer.gpu_upkeep);
        // How it refits was found on large models.
        if frames == 0 { value * ask + upkeep } else { value * (ask + upkeep) }
    }

    /// How wrong predictions are for a way; of one that was never taken, what is known of its sibling.
    pub(super) fn ratio(&self, own: usize, sibling: usize) -> f64 {
        match self.ways[own].ratio.frames {
            // It may be the question that takes longer or the other way: half of it each.
            0 if own != sibling => self.ways[sibling].ratio.value.sqrt(),
            _ => self.ways[own].ratio.value,
        }
    }
}

/// What a machine should take, before anything is known of the question but its cost.
pub(super) fn predicted(machine: &Machine, way: Way, cost: f64) -> f64 {
    match way {
        Way::Alone => machine.alone(cost),
        Way::Threads(workers) => machine.threaded(cost, workers),
        Way::Gpu => machine.device.as_ref().map_or(f64::INFINITY, |device| device.ask(cost)),
    }
}
