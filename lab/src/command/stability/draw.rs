//! The frames of every scene: imbalance, size of the front, costs as predicted and as they were, and time.

use super::Played;
use crate::charts::{self, Chart, Curve, Scale};
use anyhow::Result;
use pfront_lab::stability::times::Times;
use pfront_lab::stability::{Frame, Method, Series};

/// A row of charts for each scene, as SVG.
///
/// # Errors
/// If plotters cannot draw them.
pub(super) fn page(workers: &[usize], all: &[Played]) -> Result<String> {
    // Enough to tell methods apart, and not so many that hardly anything is left for each.
    let few = workers.iter().copied().filter(|&p| p <= 64).max();
    let Some(p) = few.or(workers.first().copied()) else { return Ok(String::new()) };
    let mut all_charts = Vec::new();
    for Played { outcome, times, .. } in all {
        for (scene, times) in times {
            let is_meant = |series: &&Series| series.scene == *scene && series.workers == p;
            let series: Vec<&Series> = outcome.series.iter().filter(is_meant).collect();
            all_charts.extend(of_scene(scene, p, &series, times));
        }
    }
    charts::page(&all_charts, 4)
}

fn of_scene(scene: &str, p: usize, series: &[&Series], times: &[Times]) -> [Chart; 4] {
    let chart = |what: &str, y, curves| Chart {
        title: format!("{scene}: {what}"),
        x: "frame",
        y,
        scale: Scale::Log,
        curves,
    };
    let of_all = |value: fn(&Frame) -> f64| -> Vec<Curve> {
        series.iter().map(|s| curve(s.method.name(), s, value)).collect()
    };
    let mut imbalance = of_all(|frame| frame.imbalance);
    let ours = series.iter().find(|s| s.method == Method::Ours);
    imbalance.extend(ours.map(|s| curve("limit", s, |frame| frame.limit)));
    let mut costs = Vec::new();
    for s in series.iter().filter(|s| matches!(s.method, Method::Ours | Method::Printed)) {
        let name = s.method.name();
        costs.push(curve(&format!("{name}, predicted"), s, |frame| frame.predicted));
        costs.push(curve(&format!("{name}, true"), s, |frame| frame.makespan));
    }
    let taken = |t: &Times| {
        let points = t.milliseconds.iter().enumerate().map(|(i, &ms)| (i as f64, ms)).collect();
        Curve { name: t.name.to_owned(), points }
    };
    let time = chart("time by schedule, all threads", "ms", times.iter().map(taken).collect());
    [
        chart(&format!("imbalance, p = {p}"), "busiest ÷ mean", imbalance),
        chart(&format!("front, p = {p}"), "nodes", of_all(|frame| frame.nodes as f64)),
        chart(&format!("dearest worker, p = {p}"), "box tests", costs),
        Chart { scale: Scale::Linear, ..time },
    ]
}

/// What is a number; a first frame may have no limit.
fn curve(name: &str, series: &Series, value: impl Fn(&Frame) -> f64) -> Curve {
    let points = series.frames.iter().enumerate().map(|(i, frame)| (i as f64, value(frame)));
    Curve { name: name.to_owned(), points: points.filter(|point| point.1.is_finite()).collect() }
}
