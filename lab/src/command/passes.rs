//! `pfront-lab passes`: where a GPU spends its time, and what a user waits for.
//!
//! On the device, all passes are timed together, and then each with a timestamp after it. Timestamps take time themselves: the
//! sum exceeds the time of all, and an equal part of the excess is taken off each pass. At last the host is timed, without
//! timestamps. A GPU that waits for a CPU slows its clock down, so the first frame is played for half a second before it counts.

use super::progress;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use pfront::TrianglePair;
use pfront::gpu::{
    Budget, Deforming, Gpu, GpuModel, GpuQuery, GpuQuestion, GpuSettings, GpuVerb, Timing,
};
use pfront::pfront_core::bvh::BuildOptions;
use pfront_cli::executor::adapter_name;
use pfront_cli::output::out;
use pfront_lab::median;
use pfront_lab::player::Objects;
use pfront_lab::recording::Recording;
use pfront_lab::workload::Frame;
use pfront_testkit::scenes::Kind;
use std::io::Write;
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(crate) struct Passes {
    /// Built-in scenes, or workloads (.tcw), of two objects or of one
    #[arg(default_values_t = ["worm-gear", "torus-knots", "sheet"].map(str::to_owned))]
    workloads: Vec<String>,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// How many levels a pass descends [default: what suits the device]
    #[arg(long, value_name = "LEVELS")]
    depth: Option<u32>,
    /// Device memory for fronts and lists
    #[arg(long, value_name = "BYTES")]
    budget: Option<u64>,
}

/// How long the first frame is played before it counts.
const WARM_UP: Duration = Duration::from_millis(500);

pub(crate) fn run(asked: &Passes) -> Result<bool> {
    let gpu = Gpu::new()?;
    let suits = gpu.settings();
    let settings = GpuSettings {
        depth: asked.depth.unwrap_or(suits.depth),
        budget: asked.budget.map_or(suits.budget, |bytes| Budget { bytes }),
        ..suits
    };
    let info = gpu.device().adapter_info();
    let (depth, bytes) = (settings.depth, settings.budget.bytes);
    writeln!(out(), "{}, {} {}", adapter_name(&info), info.driver, info.driver_info)?;
    writeln!(out(), "{depth} levels a pass, {bytes} bytes of fronts and lists")?;
    for name in &asked.workloads {
        measure(name, asked, &gpu, settings).with_context(|| name.clone())?;
    }
    Ok(true)
}

/// The passes that are timed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Timed {
    /// Each pass on the device.
    EachPass,
    /// All passes on the device.
    AllPasses,
    /// The host.
    Host,
}

/// Objects on the device, and the query about them.
enum OnDevice {
    Pair { models: [GpuModel; 2], query: GpuQuery },
    SelfMesh { model: Deforming, query: GpuQuery },
}

/// A frame that was played.
#[derive(Default)]
struct Played {
    pairs: usize,
    passes: Vec<Timing>,
    /// Moving the vertices, submitting the question and reading the answer, on the host.
    host: [Duration; 3],
}

impl OnDevice {
    fn new(objects: &Objects, gpu: &Gpu, settings: GpuSettings, timed: Timed) -> Result<Self> {
        let query = GpuQuery::with_settings(gpu, settings)?;
        let query = match timed {
            Timed::EachPass => query.with_timings()?,
            Timed::AllPasses => query.with_time()?,
            Timed::Host => query,
        };
        match (objects.kind, &objects.models[..]) {
            (Kind::Pair, [a, b]) => {
                let models = [GpuModel::new(gpu, a.bvh())?, GpuModel::new(gpu, b.bvh())?];
                Ok(Self::Pair { models, query })
            }
            (Kind::SelfMesh, [model]) => {
                let options = BuildOptions { leaf_size: Deforming::LEAF_SIZE, join: None };
                let model = Deforming::build(gpu, model.mesh(), &options)?;
                let model = match timed {
                    Timed::EachPass => model.with_timings()?,
                    Timed::AllPasses => model.with_time()?,
                    Timed::Host => model,
                };
                Ok(Self::SelfMesh { model, query })
            }
            _ => bail!("passes are timed for two objects or one mesh: time scenes with replay"),
        }
    }

    fn play(
        &mut self,
        frame: Frame<'_>,
        verb: GpuVerb,
        found: &mut Vec<TrianglePair>,
    ) -> Result<Played> {
        let clock = Instant::now();
        let (query, moved, passes) = match (self, frame) {
            (Self::Pair { models: [a, b], query }, Frame::Poses(poses)) => {
                query.submit(&GpuQuestion::pair(a, b, &poses[1]), verb)?;
                (query, Duration::ZERO, Vec::new())
            }
            (Self::SelfMesh { model, query }, Frame::Positions(positions)) => {
                model.set_positions(positions)?;
                let moved = clock.elapsed();
                query.submit(&GpuQuestion::within(model), verb)?;
                (query, moved, model.timings()?)
            }
            _ => bail!("the frames are of another kind than the objects"),
        };
        let submitted = clock.elapsed();
        let pairs = query.read(found)? as usize;
        let host = [moved, submitted - moved, clock.elapsed() - submitted];
        let passes = [passes, query.timings()?].concat();
        Ok(Played { pairs, passes, host })
    }
}

fn measure(name: &str, asked: &Passes, gpu: &Gpu, settings: GpuSettings) -> Result<()> {
    let play = |timed, verb| play(name, asked, gpu, settings, timed, verb);
    let sum = |frame: &Played| frame.passes.iter().map(microseconds).sum();
    let (_, frames) = play(Timed::AllPasses, GpuVerb::Count)?;
    let unsorted = middle(&frames, sum);
    let (objects, frames) = play(Timed::AllPasses, GpuVerb::All)?;
    let all = middle(&frames, sum);
    let mut out = out();
    writeln!(
        out,
        "\n{name}: {} triangles, {} frames, {} pairs in the median one",
        objects.triangles(),
        frames.len(),
        middle(&frames, |frame| frame.pairs as f64)
    )?;
    if all > 0.0 {
        writeln!(out, "  device, count {unsorted:>7.1} µs")?;
        writeln!(out, "  device, all   {all:>7.1} µs")?;
        let (_, frames) = play(Timed::EachPass, GpuVerb::All)?;
        let each: Vec<_> = frames.into_iter().map(|frame| frame.passes).collect();
        let passes: Vec<(String, f64)> = by_pass(&each)
            .into_iter()
            .map(|(pass, mut times)| (pass, median(&mut times)))
            .collect();
        let excess = passes.iter().map(|(_, time)| time).sum::<f64>() - all;
        let timestamp = excess.max(0.0) / passes.len() as f64;
        for (pass, time) in passes {
            writeln!(out, "    {pass:<11} {:>7.1} µs", (time - timestamp).max(0.0))?;
        }
        writeln!(out, "    and about {timestamp:.1} µs for the timestamp of each, taken off")?;
    } else {
        writeln!(out, "  the device cannot tell the time of its passes")?;
    }
    let (_, frames) = play(Timed::Host, GpuVerb::All)?;
    let micros = |time: Duration| 1e6 * time.as_secs_f64();
    for (part, name) in ["move", "submit", "read"].iter().enumerate() {
        writeln!(out, "  host, {name:<7} {:>7.1} µs", middle(&frames, |f| micros(f.host[part])))?;
    }
    let whole = middle(&frames, |frame| micros(frame.host.iter().sum()));
    writeln!(out, "  a user waits  {whole:>7.1} µs")?;
    if let Some(time) = two_in_flight(name, asked, gpu, settings)? {
        writeln!(out, "  two in flight {:>7.1} µs", micros(time))?;
    }
    Ok(())
}

/// Plays all frames.
fn play(
    name: &str,
    asked: &Passes,
    gpu: &Gpu,
    settings: GpuSettings,
    timed: Timed,
    verb: GpuVerb,
) -> Result<(Objects, Vec<Played>)> {
    let (header, mut recording) = Recording::open(name, asked.size, asked.frames)?;
    ensure!(header.frames > 0, "there is no frame to time");
    let bar = progress(header.frames.into(), "frame");
    let objects = Objects::new(header)?;
    let mut device = OnDevice::new(&objects, gpu, settings, timed)?;
    let (mut frames, mut found) = (Vec::new(), Vec::new());
    while let Some(frame) = recording.next_frame()? {
        let clock = Instant::now();
        while frames.is_empty() && clock.elapsed() < WARM_UP {
            device.play(frame, verb, &mut found)?;
        }
        frames.push(device.play(frame, verb, &mut found)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok((objects, frames))
}

/// The time of a frame of two objects while the one before is still on the device; `None` for one mesh, which must not move
/// before its answer is read.
fn two_in_flight(
    name: &str,
    asked: &Passes,
    gpu: &Gpu,
    settings: GpuSettings,
) -> Result<Option<Duration>> {
    let (header, mut recording) = Recording::open(name, asked.size, asked.frames)?;
    let objects = Objects::new(header)?;
    let (Kind::Pair, [a, b]) = (objects.kind, &objects.models[..]) else { return Ok(None) };
    let (a, b) = (GpuModel::new(gpu, a.bvh())?, GpuModel::new(gpu, b.bvh())?);
    let mut queries =
        [GpuQuery::with_settings(gpu, settings)?, GpuQuery::with_settings(gpu, settings)?];
    let mut found = Vec::new();
    let (mut clock, mut played) = (Instant::now(), 0);
    let begin = clock;
    while let Some(Frame::Poses(poses)) = recording.next_frame()? {
        let question = GpuQuestion::pair(&a, &b, &poses[1]);
        if played == 0 {
            while begin.elapsed() < WARM_UP {
                queries[0].all(&question)?;
                queries[1].all(&question)?;
            }
            clock = Instant::now();
        }
        queries[0].submit(&question, GpuVerb::All)?;
        queries[1].read(&mut found)?;
        queries.swap(0, 1);
        played += 1;
    }
    queries[1].read(&mut found)?;
    Ok(Some(clock.elapsed() / u32::max(played, 1)))
}

/// The median over frames.
fn middle(frames: &[Played], value: impl Fn(&Played) -> f64) -> f64 {
    median(&mut frames.iter().map(value).collect::<Vec<_>>())
}

fn microseconds(timing: &Timing) -> f64 {
    1e6 * timing.time.as_secs_f64()
}

/// The times of each pass that the longest frame has; one that comes again is numbered from 2.
fn by_pass(frames: &[Vec<Timing>]) -> Vec<(String, Vec<f64>)> {
    let longest = frames.iter().max_by_key(|passes| passes.len());
    let mut seen: Vec<&str> = Vec::new();
    let mut all = Vec::new();
    for pass in longest.into_iter().flatten().map(|timing| timing.pass) {
        let nth = seen.iter().filter(|other| **other == pass).count();
        seen.push(pass);
        let time = |passes: &Vec<Timing>| {
            let mut same = passes.iter().filter(|timing| timing.pass == pass);
            same.nth(nth).map_or(0.0, microseconds)
        };
        let name = if nth > 0 { format!("{pass} {}", nth + 1) } else { pass.to_owned() };
        all.push((name, frames.iter().map(time).collect()));
    }
    all
}
