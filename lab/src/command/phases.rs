//! `pfront-lab phases SCENE…`: where threads spend the time of a frame.
//!
//! The chart shows thread time, which is time multiplied by the number of threads: a part that is divided perfectly is as
//! high for any number of them, and one that a single thread does while the others wait grows in proportion.
//! The bound on all this is the machine's own: as many frames at once as there are threads, each on one, slow each other
//! down by memory, clock rate and cores that share a core.

use super::progress;
use anyhow::{Context, Result};
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use pfront::Executor;
use pfront::threads::{Pool, Report, Schedule, Settings};
use pfront_cli::output::{Draft, out};
use pfront_lab::player::{Objects, Player};
use pfront_lab::plot::{Axis, Figure, Panel, Scale, Series, Style};
use pfront_lab::recording::Recording;
use rayon::ThreadPoolBuilder;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::{ScopedJoinHandle, available_parallelism, scope, sleep};
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(crate) struct Phases {
    /// Built-in scenes, workloads (.tcw), or meshes as record takes them
    #[arg(required = true)]
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
    /// How frames are divided
    #[arg(long, value_enum, value_delimiter = ',', default_value = "static,hybrid")]
    schedule: Vec<Divided>,
    /// Milliseconds before each frame in which nothing is done, so that threads fall asleep
    #[arg(long, value_name = "MS", default_value_t = 0)]
    rest: u64,
    /// Draw the chart
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Divided {
    Static,
    Hybrid,
}

impl From<Divided> for Schedule {
    fn from(divided: Divided) -> Self {
        match divided {
            Divided::Static => Self::Static,
            Divided::Hybrid => Self::Hybrid,
        }
    }
}

/// The parts of a frame: moving and refitting; generating the front; threads that do not yet run; traversing; threads that
/// wait for the last one; merging the lists; and what is left.
const PARTS: [&str; 7] = ["update", "front", "waking", "walk", "waiting", "gather", "other"];

/// Milliseconds of each part.
type Times = [f64; PARTS.len()];

pub(crate) fn run(phases: &Phases) -> Result<bool> {
    let all = available_parallelism()?.get();
    let powers = (0..).map(|i| 1 << i).take_while(|&p| p < all).chain([all]);
    let threads = if phases.p.is_empty() { powers.collect() } else { phases.p.clone() };
    let mut panels = Vec::new();
    for scene in &phases.scenes {
        let copies = |&p: &usize| copies(phases, scene, p).with_context(|| scene.clone());
        let copies: Vec<f64> = threads.iter().map(copies).collect::<Result<_>>()?;
        let mut out = out();
        writeln!(out, "{scene}: ms; copies is a frame of so many at once, each on one thread")?;
        write!(out, "{:<9}{:>4}{:>9} speed-up", "schedule", "p", "frame")?;
        PARTS.iter().try_for_each(|name| write!(out, "{name:>9}"))?;
        writeln!(out, "{:>9}", "copies")?;
        for &divided in &phases.schedule {
            let schedule = Schedule::from(divided);
            let mut rows: Vec<Times> = Vec::new();
            for (&p, copies) in threads.iter().zip(&copies) {
                let times = played(phases, scene, schedule, p)?;
                rows.push(times);
                let frame = |times: &Times| times.iter().sum::<f64>();
                let speed_up = frame(&rows[0]) / frame(&times);
                let schedule = format!("{schedule:?}");
                write!(out, "{schedule:<9}{p:>4}{:>9.3}{speed_up:>9.2}", frame(&times))?;
                times.iter().try_for_each(|time| write!(out, "{time:>9.3}"))?;
                writeln!(out, "{copies:>9.3}")?;
            }
            panels.push(panel(&format!("{scene}: {schedule:?}"), &threads, &rows, &copies));
        }
    }
    if let Some(path) = &phases.svg {
        let title = "Thread time of a frame, by parts".to_owned();
        let figure = Figure { title, columns: phases.schedule.len(), panels };
        let mut file = Draft::new(path)?;
        file.write_all(figure.svg().as_bytes())?;
        file.finish()?;
    }
    Ok(true)
}

/// Plays a scene on `p` threads of a pool of their own.
fn played(phases: &Phases, scene: &str, schedule: Schedule, p: usize) -> Result<Times> {
    let pool = Arc::new(ThreadPoolBuilder::new().num_threads(p).build()?);
    let settings = Settings { schedule, ..Settings::default() };
    let executor = Executor::from(Pool::from(pool).with_settings(settings).measured());
    let (header, mut recording) = Recording::open(scene, phases.size, phases.frames)?;
    let bar = progress(header.frames.into(), "frame");
    let mut player = Player::new(Objects::new(header)?, &(&executor).into())?;
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame()? {
        sleep(Duration::from_millis(phases.rest));
        let clock = Instant::now();
        player.update(frame)?;
        let update = clock.elapsed();
        player.find()?;
        frames.push(parts(update, clock.elapsed(), player.report()));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(middle(frames))
}

/// The parts of a frame that took `whole`.
fn parts(update: Duration, whole: Duration, report: Option<&Report>) -> Times {
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
    [update, front, waking, walk, waiting, gather, other]
}

/// The means over the half of the frames that is neither the fastest nor the slowest, without the first frame.
fn middle(mut frames: Vec<Times>) -> Times {
    let first = usize::from(frames.len() > 1);
    let frames = &mut frames[first..];
    frames.sort_by(|x, y| x.iter().sum::<f64>().total_cmp(&y.iter().sum()));
    let frames = &frames[frames.len() / 4..frames.len() - frames.len() / 4];
    std::array::from_fn(|part| {
        frames.iter().map(|frame| frame[part]).sum::<f64>() / frames.len().max(1) as f64
    })
}

/// The time of a frame of one of `p` copies of a scene, which are played at once, each on one thread.
fn copies(phases: &Phases, scene: &str, p: usize) -> Result<f64> {
    let (header, _) = Recording::open(scene, phases.size, phases.frames)?;
    let objects = Objects::new(header)?;
    let copy = || -> Result<Times> {
        let (_, mut recording) = Recording::open(scene, phases.size, phases.frames)?;
        let mut player = Player::new(objects.clone(), &(&Executor::sequential()).into())?;
        let mut frames = Vec::new();
        while let Some(frame) = recording.next_frame()? {
            let clock = Instant::now();
            player.update(frame)?;
            player.find()?;
            frames.push(parts(Duration::ZERO, clock.elapsed(), None));
        }
        Ok(middle(frames))
    };
    let copies: Vec<Times> = scope(|scope| {
        let threads: Vec<ScopedJoinHandle<'_, _>> = (0..p).map(|_| scope.spawn(copy)).collect();
        let panicked = |_| anyhow::anyhow!("a thread has panicked");
        threads.into_iter().map(|thread| thread.join().map_err(panicked)?).collect::<Result<_>>()
    })?;
    Ok(copies.iter().flatten().sum::<f64>() / p as f64)
}

/// The parts stacked upon each other, against the number of threads.
fn panel(title: &str, threads: &[usize], rows: &[Times], copies: &[f64]) -> Panel {
    let curve = |name: &str, style, value: &dyn Fn(usize) -> f64| {
        let points = threads.iter().enumerate().map(|(i, &p)| (p as f64, p as f64 * value(i)));
        Series { name: name.to_owned(), points: points.collect(), style }
    };
    let stacked = PARTS
        .iter()
        .enumerate()
        .rev()
        .map(|(part, name)| curve(name, Style::Area, &|row| rows[row][..=part].iter().sum()));
    // A copy is one thread's own frame.
    let copy = |row: usize| copies[row] / threads[row] as f64;
    let bound = curve("a frame of copies at once", Style::Line, &copy);
    Panel {
        title: title.to_owned(),
        better: "down",
        x: Axis { label: "threads p".to_owned(), scale: Scale::Log },
        y: Axis { label: "p times ms of a frame".to_owned(), scale: Scale::Linear },
        series: stacked.chain([bound]).collect(),
    }
}
