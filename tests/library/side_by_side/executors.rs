//! Executors that queries share, and flags that cancel some of their questions.

use super::truth::Verb;
use pfront::{Error, Executor};
use pfront_testkit::rng::{Rng, RngExt};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// An executor, with a flag and without.
pub(crate) struct FlaggedExecutor {
    pub(crate) name: &'static str,
    plain: Executor,
    flagged: Executor,
    flag: Arc<AtomicBool>,
}

impl FlaggedExecutor {
    fn new(name: &'static str, plain: Executor) -> Self {
        let flag = Arc::new(AtomicBool::new(false));
        Self { name, flagged: plain.clone().with_cancel(flag.clone()), plain, flag }
    }
}

/// The executor of a query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueryExecutor {
    pub(crate) executor: usize,
    is_flagged: bool,
}

impl QueryExecutor {
    pub(crate) fn at(executor: usize) -> Self {
        Self { executor, is_flagged: true }
    }
}

/// Sets flags from another thread, while a question is answered.
struct Canceller {
    orders: Sender<(Arc<AtomicBool>, Duration)>,
    done: Receiver<()>,
}

impl Canceller {
    fn new() -> Self {
        let (orders, received) = channel::<(Arc<AtomicBool>, Duration)>();
        let (tell, done) = channel();
        std::thread::spawn(move || {
            for (flag, delay) in received {
                let clock = Instant::now();
                while clock.elapsed() < delay {
                    std::hint::spin_loop();
                }
                flag.store(true, Relaxed);
                tell.send(()).unwrap();
            }
        });
        Self { orders, done }
    }
}

/// All executors.
pub(crate) struct Executors {
    pub(crate) all: Vec<FlaggedExecutor>,
    canceller: Canceller,
    /// Questions that were cancelled.
    pub(crate) cancelled: u64,
}

impl Executors {
    pub(crate) fn new() -> Self {
        let mut all = vec![FlaggedExecutor::new("sequential", Executor::sequential())];
        #[cfg(feature = "threads")]
        {
            use pfront::threads::{Pool, Schedule, Settings};
            let threads = |threads, schedule, max_nodes| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let settings = Settings { schedule, max_nodes, ..Settings::default() };
                Executor::from(Pool::from(Arc::new(pool)).with_settings(settings))
            };
            all.push(FlaggedExecutor::new("hybrid", threads(2, Schedule::Hybrid, 1 << 20)));
            all.push(FlaggedExecutor::new("static", threads(3, Schedule::Static, 12)));
            all.push(FlaggedExecutor::new("hybrid of few nodes", threads(2, Schedule::Hybrid, 64)));
        }
        #[cfg(feature = "gpu")]
        {
            use pfront::gpu::{Budget, Gpu, GpuSettings};
            let gpu = Gpu::new().unwrap();
            let small = GpuSettings { depth: 3, budget: Budget::LEAST, ..gpu.settings() };
            all.push(FlaggedExecutor::new("gpu", Executor::gpu(&gpu, gpu.settings())));
            all.push(FlaggedExecutor::new("gpu, small lists", Executor::gpu(&gpu, small)));
            let both = Executor::sequential().and_gpu(&gpu, gpu.settings()).unwrap();
            all.push(FlaggedExecutor::new("cpu and gpu", both));
        }
        Self { all, canceller: Canceller::new(), cancelled: 0 }
    }

    /// Another executor for a query.
    pub(crate) fn elsewhere(&self, rng: &mut impl Rng) -> QueryExecutor {
        QueryExecutor {
            executor: rng.random_range(0..self.all.len()),
            is_flagged: rng.random_range(0..4) > 0,
        }
    }

    pub(crate) fn executor(&self, seat: QueryExecutor) -> &Executor {
        let executor = &self.all[seat.executor];
        if seat.is_flagged { &executor.flagged } else { &executor.plain }
    }

    /// Asks a question, some of them under a flag that is set, and then again, as a rule with another verb.
    pub(crate) fn ask(
        &mut self,
        rng: &mut impl Rng,
        seat: QueryExecutor,
        mut question: impl FnMut(Verb, usize) -> Result<(), Error>,
    ) {
        let mut verb = || {
            let most = [usize::MAX, rng.random_range(1..40)][rng.random_range(0..2)];
            (Verb::ALL[rng.random_range(0..Verb::ALL.len())], most)
        };
        let [(first, most), (then, most_then)] = [verb(), verb()];
        let (flag_of, way) = match rng.random_range(0..3) {
            0 => (rng.random_range(0..self.all.len()), rng.random_range(0..12)),
            _ => (seat.executor, rng.random_range(0..12)),
        };
        let delay = Duration::from_micros(rng.random_range(0..120));
        let flag = &self.all[flag_of].flag;
        match way {
            0 => flag.store(true, Relaxed),
            1 => self.canceller.orders.send((flag.clone(), delay)).unwrap(),
            _ => return question(first, most).unwrap(),
        }
        let answer = question(first, most);
        if way == 1 {
            self.canceller.done.recv().unwrap();
        }
        flag.store(false, Relaxed);
        if let Err(error) = answer {
            assert_eq!(error, Error::Cancelled);
            assert!(
                seat.is_flagged && seat.executor == flag_of,
                "cancelled by the flag of another"
            );
            self.cancelled += 1;
        }
        question(then, most_then).unwrap();
    }
}
