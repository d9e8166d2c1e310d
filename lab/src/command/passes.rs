//! `pfront-lab passes`: where a GPU spends its time.
//!
//! Passes are timed on the device, with a timestamp after each, which makes it wait for the one before. A GPU that waits
//! for a CPU slows its clock down, so the first frame is played for half a second before it counts.

use super::progress;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use pfront::gpu::{Budget, Deforming, Gpu, GpuModel, GpuQuery, GpuQuestion, GpuSettings, Timing};
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

/// Objects on the device, and the query about them.
enum OnDevice {
    Pair { models: [GpuModel; 2], query: GpuQuery },
    SelfMesh { model: Deforming, query: GpuQuery },
}

impl OnDevice {
    fn new(objects: &Objects, gpu: &Gpu, settings: GpuSettings) -> Result<Self> {
        match (objects.kind, &objects.models[..]) {
            (Kind::Pair, [a, b]) => Ok(Self::Pair {
                models: [GpuModel::new(gpu, a.bvh())?, GpuModel::new(gpu, b.bvh())?],
                query: GpuQuery::with_settings(gpu, settings)?.with_timings()?,
            }),
            (Kind::SelfMesh, [model]) => Ok(Self::SelfMesh {
                model: Deforming::new(gpu, model.bvh())?.with_timings()?,
                query: GpuQuery::with_settings(gpu, settings)?.with_timings()?,
            }),
            _ => bail!("passes are timed for two objects or one mesh: time scenes with replay"),
        }
    }

    /// Plays a frame; returns the number of pairs and the time of each pass.
    fn play(&mut self, frame: Frame<'_>) -> Result<(usize, Vec<Timing>)> {
        match (self, frame) {
            (Self::Pair { models: [a, b], query }, Frame::Poses(poses)) => {
                let pairs = query.all(&GpuQuestion::pair(a, b, &poses[1]))?.len();
                Ok((pairs, query.timings()?))
            }
            (Self::SelfMesh { model, query }, Frame::Positions(positions)) => {
                model.set_positions(positions)?;
                let pairs = query.all(&GpuQuestion::within(model))?.len();
                let mut timings = model.timings()?;
                timings.extend(query.timings()?);
                Ok((pairs, timings))
            }
            _ => bail!("the frames are of another kind than the objects"),
        }
    }
}

fn measure(name: &str, asked: &Passes, gpu: &Gpu, settings: GpuSettings) -> Result<()> {
    let (header, mut recording) = Recording::open(name, asked.size, asked.frames)?;
    ensure!(header.frames > 0, "there is no frame to time");
    let bar = progress(header.frames.into(), "frame");
    let objects = Objects::new(header)?;
    let mut device = OnDevice::new(&objects, gpu, settings)?;
    let (mut frames, mut counts) = (Vec::new(), Vec::new());
    while let Some(frame) = recording.next_frame()? {
        let clock = Instant::now();
        while frames.is_empty() && clock.elapsed() < WARM_UP {
            device.play(frame)?;
        }
        let (pairs, timings) = device.play(frame)?;
        counts.push(pairs as f64);
        frames.push(timings);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mut out = out();
    writeln!(
        out,
        "\n{name}: {} triangles, {} frames, {} pairs in the median one",
        objects.triangles(),
        frames.len(),
        median(&mut counts)
    )?;
    for (name, mut times) in by_pass(&frames) {
        writeln!(out, "  {name:<12} {:>9.3} µs", median(&mut times))?;
    }
    let mut sums: Vec<f64> = frames.iter().map(|f| f.iter().map(microseconds).sum()).collect();
    match sums.iter().any(|sum| *sum > 0.0) {
        true => writeln!(out, "  {:<12} {:>9.3} µs", "all passes", median(&mut sums))?,
        false => writeln!(out, "  the device cannot tell the time of its passes")?,
    }
    Ok(())
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
