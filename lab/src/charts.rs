//! Line charts on a page, as one SVG; and those of the paper's section 5, from counted work.

use crate::command::balance::{Figures, Series, quantile};
use anyhow::{Result, anyhow};
use pfront::threads::{Report, Share};
use plotters::coord::Shift;
use plotters::prelude::*;

type Panel<'p> = DrawingArea<SVGBackend<'p>, Shift>;

/// A line, and its name if it has one.
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) scale: Scale,
    pub(crate) curves: Vec<Curve>,
}

/// The scale of y.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    /// From 0 on.
    Linear,
    /// From 1 on; less is drawn as 1.
    Log,
}

/// All charts of `all`, as SVG.
///
/// # Errors
/// If plotters cannot draw them.
pub(crate) fn draw(all: &[Series]) -> Result<String> {
    let largest = all.iter().map(|series| series.triangles).max();
    let frames: Vec<&Series> = all.iter().filter(|s| Some(s.triangles) == largest).collect();
    // More lines could not be told apart.
    let few = frames.iter().filter(|series| series.workers <= 8);
    let few = few.max_by_key(|series| series.workers).or(frames.first());
    let Some(few) = few else { return Ok(String::new()) };
    let charts = [
        shares(few, "box tests", |share| share.work.box_tests as f64),
        shares(few, "triangle tests", |share| share.work.triangle_tests as f64),
        against_p(all, "Speed-up, counted", "speed-up", true, Figures::speed_up),
        against_p(all, "Imbalance, median", "busiest ÷ mean", false, Report::imbalance),
        against_frames(&frames, "Imbalance", "busiest ÷ mean", Report::imbalance),
        against_frames(&frames, "Time spent on the front", "% of the frame", |report| {
            100.0 * report.front_time()
        }),
        against_frames(&frames, "Memory of the front", "KiB", |r| r.front_bytes as f64 / 1024.0),
        against_p(all, "Memory of the front, median", "KiB", false, |report| {
            report.front_bytes as f64 / 1024.0
        }),
        against_frames(&frames, "Error of predicted costs", "% of the mean", |report| {
            100.0 * report.error()
        }),
    ];
    page(&charts, 3)
}

/// Charts of 500 × 400 in rows of `columns`, on white, as SVG.
///
/// # Errors
/// If plotters cannot draw them.
pub(crate) fn page(charts: &[Chart], columns: usize) -> Result<String> {
    let (rows, mut svg) = (charts.len().div_ceil(columns), String::new());
    let size = (500 * columns as u32, 400 * rows as u32);
    let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    root.fill(&WHITE).map_err(|e| anyhow!("{e}"))?;
    for (panel, chart) in root.split_evenly((rows, columns)).iter().zip(charts) {
        chart.draw(panel).map_err(|e| anyhow!("{e}"))?;
    }
    root.present().map_err(|e| anyhow!("{e}"))?;
    drop(root);
    Ok(svg)
}

/// The paper's Fig. 4: what each worker did in each frame.
fn shares(series: &Series, what: &str, count: impl Fn(&Share) -> f64) -> Chart {
    let of_worker = |worker: usize| {
        let shares = series.frames.iter().map(|report| report.shares(&count));
        let points = shares.enumerate().map(|(i, s)| (i as f64, 100.0 * s[worker])).collect();
        Curve { name: String::new(), points }
    };
    Chart {
        title: format!("Share of {what} of each of {} workers", series.workers),
        x: "frame",
        y: "%",
        scale: Scale::Linear,
        curves: (0..series.workers).map(of_worker).collect(),
    }
}

/// Medians over frames, a curve for each model size.
fn against_p(
    all: &[Series],
    title: &str,
    y: &'static str,
    with_ideal: bool,
    value: impl Fn(&Report) -> f64,
) -> Chart {
    let mut curves: Vec<Curve> = Vec::new();
    for part in all.chunk_by(|s, t| s.triangles == t.triangles) {
        let point = |s: &Series| (s.workers as f64, quantile(&s.frames, 0.5, &value));
        let points = part.iter().map(point).collect();
        curves.push(Curve { name: format!("{} triangles", part[0].triangles), points });
    }
    if with_ideal {
        let points = all.iter().map(|s| (s.workers as f64, s.workers as f64)).collect();
        curves.push(Curve { name: "p".to_owned(), points });
    }
    Chart { title: title.to_owned(), x: "p", y, scale: Scale::Linear, curves }
}

/// Each frame, a curve for each p.
fn against_frames(
    all: &[&Series],
    title: &str,
    y: &'static str,
    value: impl Fn(&Report) -> f64,
) -> Chart {
    let curve = |series: &&Series| Curve {
        name: format!("p = {}", series.workers),
        points: series.frames.iter().enumerate().map(|(i, r)| (i as f64, value(r))).collect(),
    };
    let curves = all.iter().map(curve).collect();
    Chart { title: title.to_owned(), x: "frame", y, scale: Scale::Linear, curves }
}

impl Chart {
    fn draw(&self, panel: &Panel<'_>) -> Result<(), Box<dyn std::error::Error + '_>> {
        let log = self.scale == Scale::Log;
        let height = |y: f64| if log { y.max(1.0).log10() } else { y };
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(1e-9, f64::max);
        let (right, top) =
            (most(&mut points().map(|p| p.0)), most(&mut points().map(|p| height(p.1))));
        let mut chart = ChartBuilder::on(panel)
            .caption(&self.title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(38)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..1.02 * right, 0.0..1.1 * top)?;
        let label = |y: &f64| if log { short(10_f64.powf(*y)) } else { short(*y) };
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(WHITE).x_desc(self.x).y_desc(self.y).y_label_formatter(&label);
        mesh.draw()?;
        for (i, curve) in self.curves.iter().enumerate() {
            let colour = Palette99::pick(i).to_rgba();
            let line = LineSeries::new(curve.points.iter().map(|p| (p.0, height(p.1))), colour);
            let drawn = chart.draw_series(line)?;
            if !curve.name.is_empty() {
                let key = move |(x, y)| PathElement::new([(x, y), (x + 14, y)], colour);
                drawn.label(&curve.name).legend(key);
            }
        }
        if self.curves.iter().any(|curve| !curve.name.is_empty()) {
            let labels = &mut chart.configure_series_labels();
            labels.background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.2)).draw()?;
        }
        Ok(())
    }
}

/// Three digits of a number.
fn short(number: f64) -> String {
    let digits =
        if number == 0.0 { 0 } else { (2.0 - number.abs().log10().floor()).max(0.0) as usize };
    let text = format!("{number:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
