//! The axes of a chart: time, and rates of wrong answers above a band for those that are never wrong.

use super::Point;
use crate::judge::Tally;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// Both axes of a panel.
#[derive(Clone, Debug)]
pub(super) struct Axes {
    pub(super) time: Range<f64>,
    pub(super) rates: Rates,
}

/// The y axis. A height is the decimal logarithm of a rate; below the lowest decade is the band, of named lines.
#[derive(Clone, Debug)]
pub(super) struct Rates {
    lowest: i32,
    highest: i32,
    lines: Vec<String>,
}

impl Axes {
    /// With room for all points, misses and false hits alike.
    pub(super) fn around(points: &[Point], lines: &[String]) -> Self {
        let rates = points.iter().flat_map(|point| {
            let Tally { missed, false_hits, .. } = point.tally;
            [missed, false_hits].map(|count| point.tally.per_million(count))
        });
        let decades = rates.filter(|rate| *rate > 0.0).map(f64::log10);
        let (low, high) = decades.fold((0.0, 1.0), |(l, h), d| (f64::min(l, d), f64::max(h, d)));
        let times = points.iter().map(|point| point.time);
        let (first, last) =
            times.fold((f64::MAX, 1e-9), |(l, h), t| (f64::min(l, t), f64::max(h, t)));
        Self {
            time: first.min(last) / 1.3..last * 1.3,
            rates: Rates {
                lowest: low.floor() as i32,
                highest: high.floor() as i32 + 1,
                lines: lines.to_vec(),
            },
        }
    }
}

impl Rates {
    /// Where a rate is, per million; one that is zero on a line of the band.
    pub(super) fn height(&self, rate: f64, line: usize) -> f64 {
        if rate > 0.0 { rate.log10() } else { self.line(line) }
    }

    /// Where a line of the band is.
    pub(super) fn line(&self, line: usize) -> f64 {
        f64::from(self.lowest) - self.gap() * (1.6 + line as f64)
    }

    /// Where the band is labelled.
    pub(super) fn label(&self) -> f64 {
        f64::from(self.lowest) - 0.8 * self.gap()
    }

    /// Between lines of the band.
    fn gap(&self) -> f64 {
        0.09 * f64::from(self.highest - self.lowest)
    }
}

impl Ranged for Rates {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let Range { start: low, end: high } = self.range();
        start + (f64::from(end - start) * (value - low) / (high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        let lines = (0..self.lines.len()).map(|line| self.line(line));
        (self.lowest..=self.highest).map(f64::from).chain(lines).collect()
    }

    fn range(&self) -> Range<f64> {
        self.line(self.lines.len())..f64::from(self.highest)
    }
}

impl ValueFormatter<f64> for Rates {
    fn format_ext(&self, value: &f64) -> String {
        let is_here = |line: &usize| self.line(*line) == *value;
        match (0..self.lines.len()).find(is_here) {
            Some(line) => self.lines[line].clone(),
            None => plain(10f64.powf(*value)),
        }
    }
}

/// What is written below a time: of each decade, not every digit.
pub(super) fn tick(x: f64) -> String {
    let digit = x / 10f64.powf(x.log10().floor() + 1e-9);
    let is_written = [1.0, 2.0, 5.0, 10.0].iter().any(|d| (digit / d - 1.0).abs() < 1e-6);
    if is_written { plain(x) } else { String::new() }
}

/// A number as short as it can be said.
pub(super) fn plain(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        _ if x >= 9_999.5 => format!("{x:.0e}"),
        _ if x >= 9.95 => format!("{x:.0}"),
        _ if x >= 0.95 => format!("{}", (10.0 * x).round() / 10.0),
        _ if x >= 0.0095 => format!("{}", (1000.0 * x).round() / 1000.0),
        _ => format!("{x:.0e}"),
    }
}
