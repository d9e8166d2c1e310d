//! The rules against machines that are not what they were measured to be.

use super::predict::predicted;
use super::*;
use crate::planner::Machine;
use crate::planner::machine::Device;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};

const THREADS_THERE: u32 = 16;

fn measured() -> Machine {
    let device =
        Device { name: "a GPU".to_owned(), question: 2e5, test: 0.05, setup: 1e6, upload: 20.0 };
    Machine {
        threads: THREADS_THERE,
        test: 3.0,
        speedup: 11.0,
        fork: 8000.0,
        fork_more: 1000.0,
        device: Some(device),
    }
}

/// A machine on which each way takes so many times what is expected.
struct World {
    machine: Machine,
    off: [f64; WAYS],
    upload: f64,
    there: bool,
    /// Frames of equal cost do not take equally long.
    noise: ChaCha8Rng,
}

impl World {
    fn new(off: [f64; WAYS]) -> Self {
        Self { machine: measured(), off, upload: 5e5, there: false, noise: seeded(1) }
    }

    fn offer(&self) -> Offer {
        let gpu = Some(if self.there { 0.0 } else { self.upload });
        Offer {
            threads: THREADS_THERE,
            gpu,
            gpu_upkeep: 0.0,
            known: Known::default(),
            moves: false,
            queries: 1,
            upkeep: 0.0,
            unmade: 0.0,
        }
    }

    fn takes(&self, way: Way, cost: f64) -> f64 {
        let expected = if way == Way::Gpu { LARGER } else { 1.0 };
        self.off[way.family()] * expected * predicted(&self.machine, way, cost)
    }

    /// Asks a question of this cost, and returns by which way and what it took.
    fn frame(&mut self, history: &mut History, cost: f64) -> (Way, f64) {
        let (machine, offer) = (self.machine.clone(), self.offer());
        let begin = history.begin(&machine, Known::default()).map(|begin| begin.until);
        let mut choice = begin.is_none().then(|| history.choose(&machine, &offer));
        let mut until = begin.or(choice.and_then(|choice| choice.alone_until));
        let (mut spent, mut first) = (0.0, None);
        while let Some(end) = until.filter(|&end| end < cost) {
            spent = end;
            // Boxes promise three times too much.
            let took = spent * machine.test * self.off[0];
            let look = Look { spent, rest: 3.0 * (cost - spent), nanoseconds: Some(took) };
            first.get_or_insert(look);
            let next = history.look(&machine, &offer, look);
            until = next.alone_until;
            choice = Some(next);
        }
        let Some(mut choice) = choice else {
            history.learn_cost(&machine, cost);
            return (Way::Alone, self.takes(Way::Alone, cost));
        };
        if until.is_some() {
            choice.way = Way::Alone;
        }
        let beside = match choice.way {
            Way::Alone => 0.0,
            _ => spent * self.machine.test * self.off[0],
        };
        let noise = self.noise.random_range(0.9..1.1);
        let mut took = beside + noise * self.takes(choice.way, cost);
        if choice.way == Way::Gpu && !self.there {
            took += self.upload;
            self.there = true;
        }
        let on_gpu = choice.way == Way::Gpu;
        let leaf_pairs = on_gpu.then_some((cost / 7.0) as u32);
        let cost = (!on_gpu).then_some(cost);
        history.learn(
            &machine,
            choice.way,
            &Frame { nanoseconds: took, beside, cost, leaf_pairs, look: first, ..Frame::default() },
        );
        (choice.way, took)
    }

    /// What all frames take over what the best single way takes for them.
    fn regret(mut self, costs: impl Iterator<Item = f64> + Clone) -> f64 {
        let ways = [Way::Alone, Way::Threads(2), Way::Threads(8), Way::Threads(16), Way::Gpu];
        let best = ways.map(|way| {
            let upload = if way == Way::Gpu { self.upload } else { 0.0 };
            upload + costs.clone().map(|cost| self.takes(way, cost)).sum::<f64>()
        });
        let best = best.into_iter().fold(f64::INFINITY, f64::min);
        let mut history = History::default();
        costs.map(|cost| self.frame(&mut history, cost).1).sum::<f64>() / best
    }
}

#[test]
fn the_best_way_is_found_whatever_the_machine_was_thought_to_be() {
    for off in [[1.0; WAYS], [1.0, 1.0, 30.0], [1.0, 4.0, 30.0], [1.4, 0.7, 0.7], [0.7, 1.4, 1.4]] {
        for cost in [10.0, 1e3, 1e4, 1e5, 1e6, 1e7] {
            let still = World::new(off).regret((0..300).map(|_| cost));
            assert!(still < 1.35, "{off:?} {cost}: {still}");
            let slow = World::new(off)
                .regret((0..300).map(|i| cost * (1.0 + (0.02 * f64::from(i)).sin().powi(2))));
            assert!(slow < 1.35, "{off:?} {cost}, changing: {slow}");
        }
    }
}

#[test]
fn jumps_cost_little() {
    for cost in [1e4, 1e5, 1e6] {
        let mut rng = seeded(2);
        let jumping = [(); 300].map(|()| if rng.random_bool(0.5) { cost } else { 100.0 });
        let regret = World::new([1.0; WAYS]).regret(jumping.into_iter());
        assert!(regret < 1.25, "{cost}: {regret}");
    }
}

#[test]
fn plans_do_not_flap() {
    // Where one thread and several take just as long.
    let mut world = World::new([1.0, 1.0, 9.0]);
    let cost = (4000.0..9000.0).step_by_hundreds().find(|&cost| {
        let all = Machine::worker_counts(THREADS_THERE);
        let threaded = all.map(|p| world.machine.threaded(cost, p));
        threaded.fold(f64::INFINITY, f64::min) < world.machine.alone(cost)
    });
    let cost = cost.expect("several threads are faster at some point");
    let mut history = History::default();
    let families: Vec<_> = (0..500).map(|_| world.frame(&mut history, cost).0.family()).collect();
    let changes = families.windows(2).filter(|two| two[0] != two[1]).count();
    assert!(changes < 20, "{changes}");
}

#[test]
fn without_a_choice_nothing_is_chosen() {
    let mut history = History::default();
    let offer = Offer { threads: 1, gpu: None, ..World::new([1.0; WAYS]).offer() };
    for cost in [1e2, 1e8, 1e2] {
        let choice = history.choose(&measured(), &offer);
        assert_eq!((choice.way, choice.alone_until), (Way::Alone, None));
        let frame = Frame { nanoseconds: cost, cost: Some(cost), ..Frame::default() };
        history.learn(&measured(), choice.way, &frame);
    }
}

#[test]
fn a_gpu_is_asked_for_a_first_pair_where_cpus_would_still_be_refitting() {
    let (machine, mut history) = (measured(), History::default());
    let known = Known { until_first: true, guess: Some(2e7), size: None };
    let offer = |gpu: f64, unmade: f64| Offer {
        gpu: Some(gpu),
        known,
        moves: true,
        upkeep: 2e6,
        unmade,
        ..World::new([1.0; WAYS]).offer()
    };
    // The certificates alone take longer than the upload, each over some frames.
    let first = history.choose(&machine, &offer(1e7, 4e7));
    assert_eq!((first.way, first.alone_until), (Way::Gpu, None));
    let frame = Frame {
        nanoseconds: 1.2e7,
        beside: 1e7,
        leaf_pairs: Some(1_000_000),
        known,
        ..Frame::default()
    };
    history.learn(&machine, Way::Gpu, &frame);
    // Nothing is known of the first pair yet, ...
    assert!(history.choose(&machine, &offer(0.0, 4e7)).expected.is_none());
    // ... and where there is less to be made, the CPU gets its chance.
    let fast = Offer { upkeep: 1e5, ..offer(0.0, 0.0) };
    assert_eq!(history.choose(&machine, &fast).way, Way::Alone);
    assert_eq!(History::default().choose(&machine, &offer(1e8, 0.0)).way, Way::Alone);
}

#[test]
fn a_gpu_does_not_find_first_pairs_for_ever() {
    let (mut world, mut history) = (World::new([1.0; WAYS]), History::default());
    world.there = true;
    let known = Known { until_first: true, ..Known::default() };
    let offer = Offer { known, ..world.offer() };
    let frame = |way, cost: Option<f64>| Frame {
        nanoseconds: world.takes(way, 1e7),
        cost,
        leaf_pairs: Some(1_000_000).filter(|_| cost.is_none()),
        known,
        ..Frame::default()
    };
    // A near miss that took the calling thread long.
    history.learn(&world.machine, Way::Alone, &frame(Way::Alone, Some(1e7)));
    assert_eq!(history.choose(&world.machine, &offer).way, Way::Gpu);
    // From now on a first pair is near, which a GPU does not tell.
    let frames = (0..200).position(|_| {
        let way = history.choose(&world.machine, &offer).way;
        history.learn(&world.machine, Way::Gpu, &frame(Way::Gpu, None));
        way != Way::Gpu
    });
    assert!(frames.is_some_and(|frames| (10..100).contains(&frames)), "{frames:?}");
}

#[test]
fn a_look_counts_no_upkeep_that_is_done() {
    let (world, history) = (World::new([1.0; WAYS]), History::default());
    let look = Look { spent: 1e4, rest: 4e5, nanoseconds: None };
    let way = |upkeep: f64| {
        let offer = Offer { upkeep, gpu: None, ..world.offer() };
        history.look(&world.machine, &offer, look).way
    };
    assert_eq!((way(0.0), way(1e9)), (Way::Threads(16), Way::Threads(16)));
}

#[test]
fn a_gpu_that_was_never_asked_is_doubted_more_than_threads_that_were() {
    let (mut world, mut history) = (World::new([1.0; WAYS]), History::default());
    world.there = true;
    let threads = Frame { cost: Some(2.4e6), ..Frame::default() };
    let took = |way| world.takes(way, 2.4e6);
    // Threads and the GPU would take about as long, the calling thread far longer.
    for (way, times) in [(Way::Threads(16), 3), (Way::Alone, 1)] {
        for _ in 0..times {
            let frame = Frame { nanoseconds: took(way), ..threads };
            history.learn(&world.machine, way, &frame);
        }
    }
    let choice = history.choose(&world.machine, &world.offer());
    let [alone, threads, gpu] = choice.times.map(|time| time.unwrap_or(f64::INFINITY));
    assert!(gpu < threads && threads < DOUBT * gpu && 5.0 * threads < alone, "{choice:?}");
    assert_eq!(choice.way, Way::Threads(16), "{choice:?}");
}

/// Steps over a range of floats.
trait Hundreds {
    fn step_by_hundreds(self) -> impl Iterator<Item = f64>;
}

impl Hundreds for std::ops::Range<f64> {
    fn step_by_hundreds(self) -> impl Iterator<Item = f64> {
        std::iter::successors(Some(self.start), |x| Some(x + 100.0))
            .take_while(move |&x| x < self.end)
    }
}
