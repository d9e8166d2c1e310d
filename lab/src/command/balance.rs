//! `pfront balance SCENE`: how evenly fronts divide work, by count.

use super::{milliseconds, progress};
use crate::args::{Balance, BalanceFormat};
use crate::charts;
use anyhow::{Context, Result};
use pfront::Executor;
use pfront::threads::{Report, Schedule, Settings, Share, Traversal};
use pfront_cli::output::{Draft, out};
use pfront_lab::player::{Objects, Player};
use pfront_lab::recording::Recording;
use pfront_lab::stability::Reference;
use std::io::{self, Write};

/// The frames of one scene under one number of workers.
pub(crate) struct Series {
    pub(crate) triangles: usize,
    pub(crate) workers: usize,
    pub(crate) frames: Vec<Report>,
    /// Of the frame in the middle.
    reference: Option<Reference>,
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
    let mut out = out();
    match balance.format {
        BalanceFormat::Table => table(&mut out, &all)?,
        BalanceFormat::Csv => lines(&mut out, &all)?,
    }
    if let Some(path) = &balance.svg {
        let mut file = Draft::new(path)?;
        file.write_all(charts::draw(&all)?.as_bytes())?;
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
    let (count, bar) = (header.frames, progress(header.frames.into()));
    let executor = Executor::from(Traversal::new(workers).with_settings(settings));
    let objects = Objects::new(header).with_context(|| balance.scene.clone())?;
    let triangles = objects.triangles();
    let mut player = Player::new(objects, &(&executor).into())?;
    let (mut frames, mut reference) = (Vec::new(), None);
    while let Some(frame) = recording.next_frame()? {
        player.update(frame)?;
        player.all()?;
        if balance.reference && frames.len() == count as usize / 2 {
            reference = player.reference(workers)?;
        }
        frames.extend(player.report().cloned());
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Series { triangles, workers, frames, reference })
}

/// What the charts show of a frame.
pub(crate) trait Figures {
    /// What all workers did, in box tests.
    fn total(&self) -> f64;
    /// Total over what the busiest worker and the front cost: the speed-up if all tests take equally long.
    fn speed_up(&self) -> f64;
    /// How much of all work went into the front.
    fn front_work(&self) -> f64;
    /// How much of all time did.
    fn front_time(&self) -> f64;
    /// The mean over workers of |predicted − true| over the mean true cost, as shares of the whole.
    fn error(&self) -> f64;
    /// Of the sum of `count` over workers, the share that each has.
    fn shares(&self, count: impl Fn(&Share) -> f64) -> Vec<f64>;
}

impl Figures for Report {
    fn total(&self) -> f64 {
        self.shares.iter().map(|share| share.work.cost()).sum()
    }

    fn speed_up(&self) -> f64 {
        let costs = self.shares.iter().map(|share| share.work.cost());
        let busiest = costs.fold(0.0, f64::max) + self.front.box_tests as f64;
        if busiest > 0.0 { self.total() / busiest } else { 1.0 }
    }

    fn front_work(&self) -> f64 {
        let front = self.front.box_tests as f64;
        if front > 0.0 { front / (front + self.total()) } else { 0.0 }
    }

    fn front_time(&self) -> f64 {
        let front = milliseconds(self.front_time);
        let all = front + milliseconds(self.traversal_time + self.gather_time);
        if all > 0.0 { front / all } else { 0.0 }
    }

    fn error(&self) -> f64 {
        let predicted = self.shares(|share| share.predicted);
        let found = self.shares(|share| share.work.cost());
        predicted.iter().zip(found).map(|(p, f)| (p - f).abs()).sum()
    }

    fn shares(&self, count: impl Fn(&Share) -> f64) -> Vec<f64> {
        let total: f64 = self.shares.iter().map(&count).sum();
        let share = |s| if total > 0.0 { count(s) / total } else { 0.0 };
        self.shares.iter().map(share).collect()
    }
}

/// The value that a share `q` of the values do not exceed.
pub(crate) fn quantile(frames: &[Report], q: f64, value: impl Fn(&Report) -> f64) -> f64 {
    let mut values: Vec<f64> = frames.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((q * last as f64).round() as usize).copied().unwrap_or(0.0)
}

fn table(out: &mut impl Write, all: &[Series]) -> io::Result<()> {
    writeln!(
        out,
        "                ------ imbalance -------- speed-up ------------ front ----------- predicted\n\
         triangles     p median    p90  most Alg.1  counted  nodes     bytes   tests    time     error"
    )?;
    for Series { triangles, workers, frames, reference } in all {
        let median = |value: &dyn Fn(&Report) -> f64| quantile(frames, 0.5, value);
        let imbalance = |q| quantile(frames, q, Report::imbalance);
        write!(out, "{triangles:>9} {workers:>5} {:>6.3} ", imbalance(0.5))?;
        write!(out, "{:>6.3} {:>5.2} ", imbalance(0.9), imbalance(1.0))?;
        match reference {
            Some(found) => write!(out, "{:>5.2} ", found.imbalance)?,
            None => write!(out, "{:>5} ", "-")?,
        }
        write!(out, "{:>8.2} ", median(&Figures::speed_up))?;
        write!(out, "{:>6} ", median(&|report| report.nodes as f64))?;
        write!(out, "{:>9} ", median(&|report| report.front_bytes as f64))?;
        write!(out, "{:>6.2}% ", 100.0 * median(&Figures::front_work))?;
        write!(out, "{:>6.2}% ", 100.0 * median(&Figures::front_time))?;
        writeln!(out, "{:>8.1}%", 100.0 * median(&Figures::error))?;
    }
    Ok(())
}

fn lines(out: &mut impl Write, all: &[Series]) -> io::Result<()> {
    writeln!(
        out,
        "triangles,p,frame,box_tests,triangle_tests,imbalance,speed_up,front_nodes,front_bytes,\
         front_box_tests,front_ms,walk_ms,prediction_error,coherent"
    )?;
    for Series { triangles, workers, frames, .. } in all {
        for (i, report) in frames.iter().enumerate() {
            let (work, [front, walk]) =
                (report.work(), [report.front_time, report.traversal_time].map(milliseconds));
            writeln!(
                out,
                "{triangles},{workers},{i},{},{},{:.4},{:.3},{},{},{},{front:.4},{walk:.4},{:.4},{}",
                work.box_tests,
                work.triangle_tests,
                report.imbalance(),
                report.speed_up(),
                report.nodes,
                report.front_bytes,
                report.front.box_tests,
                report.error(),
                u8::from(report.front.coherent)
            )?;
        }
    }
    Ok(())
}
