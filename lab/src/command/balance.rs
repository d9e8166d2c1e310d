//! `pfront-lab balance SCENE`: how evenly fronts divide work, by count.

use super::progress;
use anyhow::{Context, Result};
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use pfront::Executor;
use pfront::threads::{Pool, Report, Schedule, Settings, Share};
use pfront_cli::output::{Draft, out};
use pfront_lab::player::{Objects, Player};
use pfront_lab::plot::{self, Axis, Figure, Panel, Scale, Style};
use pfront_lab::recording::Recording;
use pfront_lab::stability::Reference;
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct Balance {
    /// The name of a built-in scene, a workload (.tcw), or meshes as record takes them
    scene: String,
    /// Numbers of workers
    #[arg(short, long, value_delimiter = ',', default_values_t = [1, 2, 4, 8, 16, 32, 64])]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=65_536))]
    p: Vec<usize>,
    /// Triangles of a built-in scene, several to compare
    #[arg(long, value_name = "TRIANGLES", value_delimiter = ',')]
    size: Vec<usize>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Divide each frame as if it were the first
    #[arg(long)]
    no_coherence: bool,
    /// Beside it Algorithm 1, which knows the true costs: slow
    #[arg(long)]
    reference: bool,
    /// A table of all frames together, or one line for each frame
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Draw the charts of the paper
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Table,
    Csv,
}

/// The frames of one scene under one number of workers.
struct Series {
    triangles: usize,
    workers: usize,
    frames: Vec<Frame>,
    /// The reference for the frame in the middle.
    reference: Option<Reference>,
}

/// One frame under one number of workers; in CSV, a line.
#[derive(Clone, Serialize)]
struct Frame {
    triangles: usize,
    p: usize,
    frame: usize,
    box_tests: u64,
    triangle_tests: u64,
    /// The busiest worker's cost over the mean.
    imbalance: f64,
    /// All work over that of the busiest worker and the front: the speed-up if all tests take equally long.
    speed_up: f64,
    front_nodes: usize,
    front_bytes: usize,
    front_box_tests: u64,
    /// The share of all work that went into the front.
    front_work: f64,
    /// The share of all time that the front took.
    front_time: f64,
    /// The mean over workers of |predicted − true| over the mean true cost, as shares of the whole.
    prediction_error: f64,
    coherent: bool,
    /// The most workers that this front can keep busy (eq. 6): p over its ε, rounded up.
    useful: f64,
}

impl Frame {
    fn new(triangles: usize, p: usize, frame: usize, report: &Report) -> Self {
        let costs = || report.shares.iter().map(|share| share.work.cost());
        let (total, front) = (costs().sum::<f64>(), report.front.box_tests as f64);
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let shares = |cost: fn(&Share) -> f64| {
            let total: f64 = report.shares.iter().map(cost).sum();
            report.shares.iter().map(move |s| share(cost(s), total))
        };
        let predicted = shares(|s| s.predicted).zip(shares(|s| s.work.cost()));
        let time = report.front_time + report.traversal_time + report.gather_time;
        let busiest = costs().fold(0.0, f64::max) + front;
        Self {
            triangles,
            p,
            frame,
            box_tests: report.work().box_tests,
            triangle_tests: report.work().triangle_tests,
            imbalance: report.imbalance(),
            speed_up: if busiest > 0.0 { total / busiest } else { 1.0 },
            front_nodes: report.nodes,
            front_bytes: report.front_bytes,
            front_box_tests: report.front.box_tests,
            front_work: share(front, front + total),
            front_time: share(report.front_time.as_secs_f64(), time.as_secs_f64()),
            prediction_error: predicted.map(|(p, found)| (p - found).abs()).fold(0.0, |x, y| x + y),
            coherent: report.front.coherent,
            useful: if report.nodes > 0 { (p as f64 / report.front.epsilon).ceil() } else { 1.0 },
        }
    }
}

impl Series {
    /// The value that a share `q` of the frames does not exceed.
    fn quantile(&self, q: f64, value: fn(&Frame) -> f64) -> f64 {
        let mut values: Vec<f64> = self.frames.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        values.get((q * last as f64).round() as usize).copied().unwrap_or(0.0)
    }
}

pub(crate) fn run(balance: &Balance) -> Result<bool> {
    let sizes: Vec<Option<usize>> = match &balance.size[..] {
        [] => vec![None],
        sizes => sizes.iter().copied().map(Some).collect(),
    };
    let mut all = Vec::new();
    for &size in &sizes {
        for &workers in &balance.p {
            all.push(series(balance, size, workers)?);
        }
    }
    match balance.format {
        Format::Table => table(&mut out(), &all)?,
        Format::Csv => {
            let mut csv = csv::Writer::from_writer(out());
            all.iter().flat_map(|s| &s.frames).try_for_each(|frame| csv.serialize(frame))?;
            csv.flush()?;
        }
    }
    if let Some(path) = &balance.svg {
        let mut file = Draft::new(path)?;
        file.write_all(
            figure(
                &Path::new(&balance.scene).file_stem().unwrap_or_default().to_string_lossy(),
                &all,
            )
            .svg()
            .as_bytes(),
        )?;
        file.finish()?;
    }
    Ok(true)
}

fn series(balance: &Balance, size: Option<usize>, workers: usize) -> Result<Series> {
    let (header, mut recording) = Recording::open(&balance.scene, size, balance.frames)?;
    let settings = Settings {
        schedule: Schedule::Static,
        coherence: !balance.no_coherence,
        ..Settings::default()
    };
    let (count, bar) = (header.frames, progress(header.frames.into(), "frame"));
    let executor = Executor::from(Pool::new(workers).with_settings(settings));
    let objects = Objects::new(header).with_context(|| balance.scene.clone())?;
    let triangles = objects.triangles();
    let mut player = Player::new(objects, &(&executor).into())?;
    let (mut frames, mut reference) = (Vec::new(), None);
    while let Some(frame) = recording.next_frame()? {
        player.update(frame).with_context(|| balance.scene.clone())?;
        player.all()?;
        if balance.reference && frames.len() == count as usize / 2 {
            reference = player.reference(workers)?;
        }
        let number = frames.len();
        frames.extend(player.report().map(|r| Frame::new(triangles, workers, number, r)));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Series { triangles, workers, frames, reference })
}

fn table(out: &mut impl Write, all: &[Series]) -> io::Result<()> {
    writeln!(
        out,
        "                ------ imbalance -------- speed-up ------------ front ----------- predicted   eq. 6\n\
         triangles     p median    p90  most Alg.1  counted  nodes     bytes   tests    time     error workers"
    )?;
    for series in all {
        let median = |value| series.quantile(0.5, value);
        let imbalance = |q| series.quantile(q, |frame| frame.imbalance);
        write!(out, "{:>9} {:>5} {:>6.3} ", series.triangles, series.workers, imbalance(0.5))?;
        write!(out, "{:>6.3} {:>5.2} ", imbalance(0.9), imbalance(1.0))?;
        match series.reference {
            Some(found) => write!(out, "{:>5.2} ", found.imbalance)?,
            None => write!(out, "{:>5} ", "-")?,
        }
        write!(out, "{:>8.2} ", median(|frame| frame.speed_up))?;
        write!(out, "{:>6} ", median(|frame| frame.front_nodes as f64))?;
        write!(out, "{:>9} ", median(|frame| frame.front_bytes as f64))?;
        write!(out, "{:>6.2}% ", 100.0 * median(|frame| frame.front_work))?;
        write!(out, "{:>6.2}% ", 100.0 * median(|frame| frame.front_time))?;
        write!(out, "{:>8.1}%", 100.0 * median(|frame| frame.prediction_error))?;
        writeln!(out, "{:>8}", median(|frame| frame.useful))?;
    }
    Ok(())
}

/// Medians against p, and the imbalance of each frame of the largest model.
fn figure(name: &str, all: &[Series]) -> Figure {
    let excess = |frame: &Frame| 100.0 * (frame.imbalance - 1.0);
    let curve = |name: String, points| plot::Series { name, points, style: Style::Line };
    let panel = |title: &str, better, x: &str, y: &str, scale, series| Panel {
        title: title.to_owned(),
        better,
        x: Axis { label: x.to_owned(), scale },
        y: Axis { label: y.to_owned(), scale: Scale::Linear },
        series,
    };
    let against_p = |title: &str, better, y: &str, value: fn(&Frame) -> f64| {
        let sizes = all.chunk_by(|s, t| s.triangles == t.triangles);
        let of_size = |part: &[Series]| {
            let points = part.iter().map(|s| (s.workers as f64, s.quantile(0.5, value)));
            curve(format!("{} triangles", part[0].triangles), points.collect())
        };
        panel(title, better, "workers p", y, Scale::Log, sizes.map(of_size).collect())
    };
    let largest = all.iter().map(|series| series.triangles).max();
    let frames = all.iter().filter(|series| Some(series.triangles) == largest).map(|series| {
        let points = series.frames.iter().map(|frame| (frame.frame as f64, excess(frame)));
        curve(format!("p = {}", series.workers), points.collect())
    });
    let mut speed_up =
        against_p("Speed-up, counted", "up", "times as fast", |frame| frame.speed_up);
    let ideal = all.iter().filter(|s| Some(s.triangles) == largest);
    let ideal = ideal.map(|s| (s.workers as f64, s.workers as f64)).collect();
    speed_up.series.push(curve("p times".to_owned(), ideal));
    let above = "busiest worker, % above the mean";
    Figure {
        title: format!("{name}: how evenly a front divides the work (medians over frames)"),
        columns: 2,
        panels: vec![
            speed_up,
            panel(
                "Imbalance of each frame",
                "down",
                "frame",
                above,
                Scale::Linear,
                frames.collect(),
            ),
            against_p("Imbalance", "down", above, excess),
            against_p("Error of predicted costs", "down", "% of the mean", |frame| {
                100.0 * frame.prediction_error
            }),
            against_p("Time spent on the front", "down", "% of the frame", |frame| {
                100.0 * frame.front_time
            }),
            against_p("Memory of the front", "down", "KiB", |frame| {
                frame.front_bytes as f64 / 1024.0
            }),
        ],
    }
}
