//! `pfront-lab profile SCENE…`: where threads, and a GPU, spend the time of a frame, and how evenly fronts divide it.

use super::progress;
use anyhow::{Context, Result, ensure};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use pfront::gpu::{Gpu, GpuModel, GpuQuery, GpuQuestion, Timing};
use pfront::threads::{Pool, Report, Schedule, Settings};
use pfront::{Executor, TrianglePair};
use pfront_cli::executor::adapter_name;
use pfront_cli::output::out;
use pfront_lab::median;
use pfront_lab::player::{Objects, Player};
use pfront_lab::recording::Recording;
use pfront_lab::workload::Frame;
use pfront_testkit::scenes::Kind;
use rayon::ThreadPoolBuilder;
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(crate) struct Profile {
    /// Built-in scenes, workloads (.tcw), or meshes as record takes them
    #[arg(default_values_t = ["worm-gear", "torus-knots", "sheet"].map(str::to_owned))]
    scenes: Vec<String>,
    /// Numbers of threads [default: 1, 2, 4, ... and all of the machine]
    #[arg(short, long, value_delimiter = ',')]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=4096))]
    p: Vec<usize>,
    /// Triangles of a built-in scene
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Divide frames once, as the paper does
    #[arg(long = "static")]
    is_static: bool,
    /// Also each pass of a GPU about two objects, by the device's own clock
    #[arg(long)]
    gpu: bool,
}

/// Milliseconds of a frame, of moving and refitting, generating the front, threads that do not yet run, traversing, threads
/// that wait for the last one, merging the lists, and what is left; then busiest worker over mean, in counted tests, the
/// nodes of the front, and the number of workers past which eq. 6 promises no gain: its cost over that of its largest node. Nodes
/// that can be split are made small enough for g p workers at least, so a number near that says no more.
const COLUMNS: [&str; 11] = [
    "frame", "update", "front", "waking", "walk", "waiting", "gather", "other", "balance", "nodes",
    "eq. 6",
];

type Row = [f64; COLUMNS.len()];

/// How long the first frame is played on a GPU before it counts: one that waits for a CPU slows its clock down.
const WARM_UP: Duration = Duration::from_millis(500);

pub(crate) fn run(asked: &Profile) -> Result<bool> {
    let all = available_parallelism()?.get();
    let powers = (0..).map(|i| 1 << i).take_while(|&p| p < all).chain([all]);
    let threads = if asked.p.is_empty() { powers.collect() } else { asked.p.clone() };
    let gpu = if asked.gpu { Some(Gpu::new()?) } else { None };
    for scene in &asked.scenes {
        let mut out = out();
        writeln!(out, "{scene}: ms")?;
        write!(out, "{:>4}{:>9}", "p", "speed-up")?;
        COLUMNS.iter().try_for_each(|name| write!(out, "{name:>9}"))?;
        writeln!(out)?;
        let mut first = None;
        for &p in &threads {
            let row = played(asked, scene, p).with_context(|| scene.clone())?;
            let speed_up = *first.get_or_insert(row[0]) / row[0];
            write!(out, "{p:>4}{speed_up:>9.2}")?;
            row.iter().try_for_each(|number| write!(out, "{number:>9.3}"))?;
            writeln!(out)?;
        }
        if let Some(gpu) = &gpu {
            passes(asked, scene, gpu, &mut out).with_context(|| scene.clone())?;
        }
    }
    Ok(true)
}

/// Plays a scene on `p` threads of a pool of their own.
fn played(asked: &Profile, scene: &str, p: usize) -> Result<Row> {
    let pool = Arc::new(ThreadPoolBuilder::new().num_threads(p).build()?);
    let schedule = if asked.is_static { Schedule::Static } else { Schedule::Hybrid };
    let settings = Settings { schedule, ..Settings::default() };
    let executor = Executor::from(Pool::from(pool).with_settings(settings));
    let (header, mut recording) = Recording::open(scene, asked.size, asked.frames)?;
    let bar = progress(header.frames.into(), "frame");
    let mut player = Player::new(Objects::new(header)?, &executor)?;
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame()? {
        let clock = Instant::now();
        player.update(frame)?;
        let update = clock.elapsed();
        player.find()?;
        frames.push(row(update, clock.elapsed(), player.report()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(middle(frames))
}

/// The parts of a frame that took `whole`.
fn row(update: Duration, whole: Duration, report: Option<&Report>) -> Row {
    let none = Report::default();
    let report = report.unwrap_or(&none);
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let [alone, waking, busy] = [report.alone_time, report.waking_time, report.busy_time].map(ms);
    let [front, traversal, gather] =
        [report.front_time, report.traversal_time, report.gather_time].map(ms);
    // One thread has no report, and one that was alone no front.
    let walk = match report.nodes {
        0 if traversal == 0.0 => ms(whole) - ms(update),
        0 => traversal,
        _ => alone + busy,
    };
    let waiting = (traversal - waking - walk).max(0.0);
    let known = [ms(update), front, waking, walk, waiting, gather];
    let other = (ms(whole) - known.iter().sum::<f64>()).max(0.0);
    let [update, front, waking, walk, waiting, gather] = known;
    let (balance, nodes) = (report.imbalance(), report.nodes as f64);
    let useful = match report.front.epsilon {
        0.0 => 0.0,
        epsilon => (report.shares.len() as f64 / epsilon).ceil(),
    };
    [ms(whole), update, front, waking, walk, waiting, gather, other, balance, nodes, useful]
}

/// The means over the half of the frames that is neither the fastest nor the slowest, without the first frame.
fn middle(mut frames: Vec<Row>) -> Row {
    let first = usize::from(frames.len() > 1);
    let frames = &mut frames[first..];
    frames.sort_by(|x, y| x[0].total_cmp(&y[0]));
    let frames = &frames[frames.len() / 4..frames.len() - frames.len() / 4];
    std::array::from_fn(|part| {
        frames.iter().map(|frame| frame[part]).sum::<f64>() / frames.len().max(1) as f64
    })
}

/// A row for each pass of a GPU about two objects, the median over frames; one for the wait of the host without timestamps, and one for
/// all passes of a count together. Each timestamp takes some microseconds itself.
fn passes(asked: &Profile, scene: &str, gpu: &Gpu, out: &mut impl Write) -> Result<()> {
    let (header, mut recording) = Recording::open(scene, asked.size, asked.frames)?;
    let objects = Objects::new(header)?;
    let (Kind::Pair, [a, b]) = (objects.kind, &objects.models[..]) else {
        return Ok(writeln!(out, "a GPU is timed for two objects")?);
    };
    let (a, b) = (GpuModel::new(gpu, a.bvh())?, GpuModel::new(gpu, b.bvh())?);
    let (mut timed, mut query) = (GpuQuery::new(gpu)?.with_timings()?, GpuQuery::new(gpu)?);
    let (mut whole, mut counts) = (GpuQuery::new(gpu)?.with_time()?, Vec::new());
    let (mut times, mut waits) = (BTreeMap::<(usize, &str), Vec<f64>>::new(), Vec::new());
    while let Some(Frame::Poses(poses)) = recording.next_frame()? {
        let question = GpuQuestion::pair(&a, &b, &poses[1]);
        let clock = Instant::now();
        while waits.is_empty() && clock.elapsed() < WARM_UP {
            query.all(&question)?;
        }
        let expected: Vec<TrianglePair> = timed.all(&question)?.to_vec();
        for (place, &Timing { pass, time, .. }) in timed.timings()?.iter().enumerate() {
            times.entry((place, pass)).or_default().push(1e3 * time.as_secs_f64());
        }
        whole.count(&question)?;
        counts.push(whole.timings()?.iter().map(|timing| 1e3 * timing.time.as_secs_f64()).sum());
        let clock = Instant::now();
        let found = query.all(&question)?;
        waits.push(1e3 * clock.elapsed().as_secs_f64());
        ensure!(found == expected, "a GPU answers one question in two ways: please report this");
    }
    let name = adapter_name(&gpu.device().adapter_info());
    writeln!(out, " GPU{:>9}{:>9.3} {name}", "frame", median(&mut waits))?;
    writeln!(out, " GPU{:>9}{:>9.3}", "count", median(&mut counts))?;
    for ((_, pass), mut times) in times {
        writeln!(out, " GPU{pass:>9}{:>9.3}", median(&mut times))?;
    }
    Ok(())
}
