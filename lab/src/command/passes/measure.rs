//! The frames of one workload, on the GPU and on threads.
//!
//! A GPU that keeps the time of its passes spends some on that. So there are two of it: one is asked
//! how long its passes took, the other is timed from outside. A GPU that waits for a CPU slows its clock
//! down. So it plays all frames first, after half a second of the first one, and threads play them
//! after it. All answers are compared.

use crate::args::Passes;
use crate::command::{milliseconds, progress};
use crate::play::{objects, update};
use crate::recording::Recording;
use anyhow::{Result, ensure};
use pfront::gpu::{GpuReport, Timing};
use pfront::{Executor, TrianglePair};
use pfront_cli::executor as how;
use pfront_lab::engine::{Engine, On, OnGpu};
use pfront_lab::workload::Frame;
use serde::Serialize;
use std::time::{Duration, Instant};

/// What the frames of one workload took.
#[derive(Serialize)]
pub(crate) struct Measured {
    pub(crate) name: String,
    pub(crate) triangles: usize,
    pub(crate) frames: usize,
    /// Pairs that meet.
    pub(crate) pairs: Spread,
    /// Device time of each pass in microseconds, in their order; empty if the device cannot tell.
    pub(crate) passes: Vec<Pass>,
    /// Device time of all passes in microseconds.
    pub(crate) device: Option<Spread>,
    pub(crate) gpu: Took,
    pub(crate) one_thread: Took,
    pub(crate) all_threads: Took,
    /// Bytes of device memory that the models take, without fronts and lists.
    pub(crate) device_bytes: u64,
    /// The most of any frame.
    pub(crate) most: Most,
}

#[derive(Serialize)]
pub(crate) struct Pass {
    pub(crate) name: String,
    #[serde(flatten)]
    pub(crate) time: Spread,
}

/// Milliseconds of a frame, from outside.
#[derive(Serialize)]
pub(crate) struct Took {
    /// Moving the objects: uploading and refitting, which a GPU goes on with in the query.
    pub(crate) update: Spread,
    /// From the question to the pairs in the memory of the host.
    pub(crate) query: Spread,
    /// Both.
    pub(crate) frame: Spread,
}

#[derive(Clone, Copy, Default, Serialize)]
pub(crate) struct Most {
    pub(crate) runs: u32,
    pub(crate) front: u32,
    pub(crate) leaf_pairs: u32,
    pub(crate) undecided: u32,
    pub(crate) on_cpu: u32,
}

/// Of all frames.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    /// What nine of ten do not exceed.
    pub(crate) p90: f64,
}

/// Runs the workload called `name`.
///
/// # Errors
/// If it cannot be run, or the answers differ.
pub(super) fn measure(name: &str, bench: &Passes, on: &OnGpu, threads: usize) -> Result<Measured> {
    let mut recording = Recording::open(name, bench.size, bench.frames)?;
    let header = recording.take_header()?;
    ensure!(header.frames > 0, "there is no frame to time");
    let bar = progress(2 * u64::from(header.frames));
    let objects = objects(header)?;
    let triangles = objects.triangles();
    let mut device = OnDevice {
        timed: objects.clone().engine(On::Gpu(OnGpu { timed: true, ..on.clone() }).into())?,
        passes: Vec::new(),
        most: Most::default(),
        lane: Lane::new(objects.clone().engine(On::Gpu(on.clone()).into())?),
        answers: Vec::new(),
    };
    while let Some(frame) = recording.next_frame()? {
        device.run(frame)?;
        bar.inc(1);
    }
    let mut one_thread = Lane::new(objects.clone().engine(Executor::sequential().into())?);
    let mut all_threads = Lane::new(objects.engine(how::threads(threads)?.into())?);
    let mut recording = Recording::open(name, bench.size, bench.frames)?;
    for (number, answer) in device.answers.iter().enumerate() {
        let Some(frame) = recording.next_frame()? else { break };
        if number == 0 {
            // It wakes threads and makes buffers, and does not count. Another verb, since an answer is kept.
            for lane in [&mut one_thread, &mut all_threads] {
                update(&mut *lane.engine, frame)?;
                lane.engine.count()?;
            }
        }
        let same = one_thread.run(frame)? == answer && all_threads.run(frame)? == answer;
        ensure!(same, "the answers to frame {number} differ: please report this");
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Measured {
        name: name.to_owned(),
        triangles,
        frames: device.answers.len(),
        pairs: Spread::of(device.answers.iter().map(|answer| answer.len() as f64).collect()),
        device: all_passes(&device.passes),
        passes: by_pass(&device.passes),
        gpu: device.lane.took(),
        one_thread: one_thread.took(),
        all_threads: all_threads.took(),
        device_bytes: device.lane.engine.device_bytes(),
        most: device.most,
    })
}

/// What the device says.
struct OnDevice {
    timed: Box<dyn Engine>,
    passes: Vec<Vec<Timing>>,
    most: Most,
    lane: Lane,
    answers: Vec<Vec<TrianglePair>>,
}

/// One who answers, timed from outside: milliseconds of updates and queries.
struct Lane {
    engine: Box<dyn Engine>,
    times: Vec<[f64; 2]>,
}

/// How long the first frame is played before it counts.
const WARM_UP: Duration = Duration::from_millis(500);

impl OnDevice {
    fn run(&mut self, frame: Frame<'_>) -> Result<()> {
        let number = self.answers.len();
        let clock = Instant::now();
        while number == 0 && clock.elapsed() < WARM_UP {
            for engine in [&mut self.timed, &mut self.lane.engine] {
                update(&mut **engine, frame)?;
                engine.all()?;
            }
        }
        let answer = self.lane.run(frame)?.to_vec();
        update(&mut *self.timed, frame)?;
        let same = self.timed.all()? == answer;
        ensure!(same, "the answers to frame {number} differ: please report this");
        self.answers.push(answer);
        self.passes.push(self.timed.timings()?);
        if let Some(report) = self.timed.gpu_report() {
            self.most.add(&report);
        }
        Ok(())
    }
}

impl Lane {
    fn new(engine: Box<dyn Engine>) -> Self {
        Self { engine, times: Vec::new() }
    }

    fn run(&mut self, frame: Frame<'_>) -> Result<&[TrianglePair]> {
        let clock = Instant::now();
        update(&mut *self.engine, frame)?;
        let update = milliseconds(clock.elapsed());
        let clock = Instant::now();
        let pairs = self.engine.all()?;
        self.times.push([update, milliseconds(clock.elapsed())]);
        Ok(pairs)
    }

    fn took(&self) -> Took {
        let spread = |of: fn(&[f64; 2]) -> f64| Spread::of(self.times.iter().map(of).collect());
        Took {
            update: spread(|[update, _]| *update),
            query: spread(|[_, query]| *query),
            frame: spread(|[update, query]| update + query),
        }
    }
}

impl Most {
    fn add(&mut self, report: &GpuReport) {
        for (most, now) in [
            (&mut self.runs, report.runs),
            (&mut self.front, report.longest_front),
            (&mut self.leaf_pairs, report.leaf_pairs),
            (&mut self.undecided, report.undecided),
            (&mut self.on_cpu, report.on_cpu),
        ] {
            *most = now.max(*most);
        }
    }
}

impl Spread {
    /// Of at least one value.
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1) as f64;
        let at = |share: f64| values.get((share * last).round() as usize).copied().unwrap_or(0.0);
        Self { median: at(0.5), p90: at(0.9) }
    }
}

fn microseconds(timing: &Timing) -> f64 {
    1e6 * timing.time.as_secs_f64()
}

/// Of all passes together.
fn all_passes(frames: &[Vec<Timing>]) -> Option<Spread> {
    let sums: Vec<f64> =
        frames.iter().map(|passes| passes.iter().map(microseconds).sum()).collect();
    frames.iter().any(|passes| !passes.is_empty()).then(|| Spread::of(sums))
}

/// Of each pass that the longest frame has; one that comes again is numbered from 2.
fn by_pass(frames: &[Vec<Timing>]) -> Vec<Pass> {
    let longest = frames.iter().max_by_key(|passes| passes.len());
    let names = longest.into_iter().flatten().map(|timing| timing.pass);
    let mut passes: Vec<(&str, usize)> = Vec::new();
    for name in names {
        let before = passes.iter().filter(|(other, _)| *other == name).count();
        passes.push((name, before));
    }
    let time = |passes: &[Timing], (name, nth): (&str, usize)| {
        passes.iter().filter(|timing| timing.pass == name).nth(nth).map_or(0.0, microseconds)
    };
    let pass = |&(name, nth): &(&str, usize)| {
        let times = frames.iter().map(|passes| time(passes, (name, nth)));
        Pass {
            name: if nth > 0 { format!("{name} {}", nth + 1) } else { name.to_owned() },
            time: Spread::of(times.collect()),
        }
    };
    passes.iter().map(pass).collect()
}
