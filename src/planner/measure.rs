//! Measuring a [`Machine`]: two questions, a short and a long one, are asked each way. What they take on top of
//! a time that grows with their cost is what the way takes to get going.

use super::Machine;
use crate::core::bvtt::{PairQuery, Query};
use crate::{Error, Model, Pose, TrianglePair};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Cells along a side of the sheets that are asked about; two triangles each.
const SHORT: usize = 32;
const LONG: usize = 192;
/// The least and most runs of a question, and how long more than the least of them may take.
const RUNS: [usize; 2] = [POSES, 15];
const MOST: Duration = Duration::from_millis(40);

/// Nobody wakes a thread in less, in nanoseconds.
#[cfg(feature = "threads")]
const LEAST_FORK: f64 = 2000.0;

/// How many poses the sheets take in turn: threads that are asked the same question over and over know who has to
/// do what, and take less than those do who are asked of something that moves.
const POSES: usize = 5;

/// Two wavy sheets through each other.
struct Sheets {
    sheet: Model,
    poses: [Pose; POSES],
    /// In box tests, on average.
    cost: f64,
}

impl Sheets {
    fn new(side: usize) -> Result<Self, Error> {
        let at = |i: usize| i as f32 / side as f32;
        let wave = |x: f32, y: f32| 0.1 * (9.0 * x).sin() * (7.0 * y).cos();
        let grid = (0..=side).flat_map(|j| (0..=side).map(move |i| (at(i), at(j))));
        let positions = grid.map(|(x, y)| [x, y, wave(x, y)]).collect();
        let corner = |i: usize, j: usize| (j * (side + 1) + i) as u32;
        let cells = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
        let triangles = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| corner(i + x, j + y));
            [[a, b, c], [b, d, c]]
        });
        let sheet = Model::new(positions, triangles.collect())?;
        let poses = std::array::from_fn(|i| {
            Pose::from_translation([0.011 + 0.004 * i as f32, 0.007, 0.003])
        });
        let own = Self { sheet, poses, cost: 0.0 };
        let mut cost = 0.0;
        for query in own.queries()? {
            let mut cursor = query.start();
            // Never broken off.
            let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
            let work = cursor.work;
            cost += work.cost();
        }
        Ok(Self { cost: cost / POSES as f64, ..own })
    }

    #[cfg(feature = "gpu")]
    fn pose(&self, run: usize) -> &Pose {
        &self.poses[run % POSES]
    }

    /// One for each pose.
    fn queries(&self) -> Result<Vec<PairQuery<'_>>, Error> {
        let bvh = self.sheet.bvh();
        let all = self.poses.iter().map(|pose| Ok(PairQuery::new(bvh, bvh, *pose)?));
        all.collect()
    }
}

/// What a way takes, in nanoseconds.
#[cfg(feature = "gpu")]
struct Line {
    start: f64,
    each: f64,
}

#[cfg(feature = "gpu")]
impl Line {
    /// Through what a short and a long question take.
    fn through(costs: [f64; 2], times: [f64; 2]) -> Self {
        // Where noise is more than what they differ by, it is taken for that.
        let each = (times[1] - times[0]).max(0.05 * times[0]) / (costs[1] - costs[0]);
        Self { start: (times[0] - each * costs[0]).max(0.0), each }
    }
}

impl Machine {
    /// Measures this machine, but no GPU, in less than a second; where the clock or memory fails,
    /// [`Machine::typical`]. No two runs give quite the same.
    ///
    /// Threads are those of the rayon pool of whoever asks.
    #[must_use]
    pub fn measure() -> Self {
        let typical = Self::typical();
        measured(&typical).unwrap_or(typical)
    }

    /// The same with a GPU, measured which takes less than a second too, or two on an adapter that computes on the
    /// CPU. Makes it a choice of planners that have both.
    ///
    /// # Errors
    /// What the GPU reports.
    #[cfg(feature = "gpu")]
    pub fn measure_gpu(mut self, gpu: &crate::gpu::Gpu) -> Result<Self, crate::gpu::Error> {
        let (Ok(short), Ok(long)) = (Sheets::new(SHORT), Sheets::new(LONG)) else {
            return Ok(self);
        };
        self.device = Some(on_gpu(gpu, &short, &long)?);
        Ok(self)
    }
}

fn measured(typical: &Machine) -> Result<Machine, Error> {
    let sheets = [Sheets::new(SHORT)?, Sheets::new(LONG)?];
    let mut pairs: Vec<TrianglePair> = Vec::new();
    let times = undisturbed(&sheets, |query| {
        pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            pairs.push(pair);
            ControlFlow::Continue(())
        });
        pairs.sort_unstable();
    })?;
    let test = times[1] / sheets[1].cost;
    let machine = Machine { test, threads: 1, speedup: 1.0, ..typical.clone() };
    #[cfg(feature = "threads")]
    let machine = on_threads(machine, &sheets, times)?;
    Ok(machine)
}

/// `alone` is what the questions take on one thread.
#[cfg(feature = "threads")]
fn on_threads(machine: Machine, sheets: &[Sheets; 2], alone: [f64; 2]) -> Result<Machine, Error> {
    let threads = crate::threads::Traversal::default().workers as u32;
    if threads < 2 {
        return Ok(machine);
    }
    let on = |workers: u32| -> Result<[f64; 2], Error> {
        let mut traversal = crate::threads::Traversal::new(workers as usize);
        let mut pairs = Vec::<TrianglePair>::new();
        undisturbed(sheets, |query| traversal.all(std::slice::from_ref(query), &mut pairs))
    };
    let two = on(2)?;
    let all = if threads == 2 { two } else { on(threads)? };
    let speedup = |times: [f64; 2], workers: u32| {
        let each = (times[1] - times[0]).max(0.05 * times[0]);
        ((alone[1] - alone[0]) / each).clamp(1.0, f64::from(workers))
    };
    // What a short question takes beyond its part of the work.
    let fork =
        |times: [f64; 2], workers| (times[0] - alone[0] / speedup(times, workers)).max(LEAST_FORK);
    let more = f64::from(threads.max(3) - 2);
    Ok(Machine {
        threads,
        speedup: speedup(all, threads),
        fork: fork(two, 2),
        fork_more: ((fork(all, threads) - fork(two, 2)) / more).max(0.0),
        ..machine
    })
}

#[cfg(feature = "gpu")]
fn on_gpu(
    gpu: &crate::gpu::Gpu,
    short: &Sheets,
    long: &Sheets,
) -> Result<super::Device, crate::gpu::Error> {
    use crate::gpu;
    let (mut times, mut first) = ([f64::INFINITY; 2], [f64::INFINITY; 2]);
    let mut setup = 0.0_f64;
    // In two rounds, of which others may disturb one.
    for _ in 0..2 {
        for ((time, first), sheets) in times.iter_mut().zip(&mut first).zip([short, long]) {
            let clock = Instant::now();
            let mut query = gpu::PairQuery::new(gpu)?;
            // Memory that was used before is to be had sooner.
            setup = setup.max(clock.elapsed().as_secs_f64() * 1e9);
            let clock = Instant::now();
            let model = gpu::Model::new(gpu, sheets.sheet.bvh())?;
            query.all(&model, &model, sheets.pose(0))?;
            *first = first.min(clock.elapsed().as_secs_f64() * 1e9);
            let often = median(|run| query.all(&model, &model, sheets.pose(run)).map(|_| ()))?;
            *time = time.min(often);
        }
    }
    let first = [0, 1].map(|i| (first[i] - times[i]).max(0.0));
    let line = Line::through([short.cost, long.cost], times);
    let triangles = [short, long].map(|sheets| sheets.sheet.mesh().triangles().len() as f64);
    let upload = Line::through(triangles, first);
    Ok(super::Device {
        name: gpu.device().adapter_info().name,
        question: line.start,
        test: line.each,
        setup: setup + upload.start,
        upload: upload.each,
    })
}

/// What both questions take, in nanoseconds: asked in two rounds, of which others may disturb one.
fn undisturbed(
    sheets: &[Sheets; 2],
    mut ask: impl FnMut(&PairQuery<'_>),
) -> Result<[f64; 2], Error> {
    let mut times = [f64::INFINITY; 2];
    for _ in 0..2 {
        for (time, sheets) in times.iter_mut().zip(sheets) {
            let queries = sheets.queries()?;
            *time = time.min(median(|run| {
                ask(&queries[run % POSES]);
                Ok::<_, Error>(())
            })?);
        }
    }
    Ok(times)
}

/// What a run takes, in nanoseconds.
fn median<E>(mut run: impl FnMut(usize) -> Result<(), E>) -> Result<f64, E> {
    let begun = Instant::now();
    let mut times = Vec::new();
    // The first wakes threads, fills caches and grows buffers.
    run(0)?;
    while times.len() < RUNS[0] || times.len() < RUNS[1] && begun.elapsed() < MOST {
        let clock = Instant::now();
        run(times.len() + 1)?;
        times.push(clock.elapsed().as_secs_f64() * 1e9);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}
