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

/// The y axis. A height is the decimal logarithm of a rate; below the lowest decade is the band.
#[derive(Clone, Debug)]
pub(super) struct Rates {
    lowest: i32,
    highest: i32,
    lines: usize,
}

/// Between lines of the band, and above the first, in decades of an axis that has `decades` of them.
fn gap(decades: i32) -> f64 {
    0.09 * f64::from(decades)
}

impl Axes {
    /// With room for all points, misses and false hits alike.
    pub(super) fn around(points: &[Point], lines: usize) -> Self {
        let rates = points.iter().flat_map(|point| {
            let Tally { missed, false_hits, .. } = point.tally;
            [missed, false_hits].map(|count| point.tally.per_million(count))
        });
        let decades = rates.filter(|rate| *rate > 0.0).map(f64::log10);
        let (low, high) = decades.fold((0.0, 3.0), |(l, h), d| (f64::min(l, d), f64::max(h, d)));
        let times = points.iter().map(|point| point.time);
        let (first, last) =
            times.fold((f64::MAX, 1e-9), |(l, h), t| (f64::min(l, t), f64::max(h, t)));
        Self {
            time: first.min(last) / 1.3..last * 1.3,
            rates: Rates { lowest: low.floor() as i32, highest: high.floor() as i32 + 1, lines },
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
        f64::from(self.lowest) - gap(self.highest - self.lowest) * (1.6 + line as f64)
    }

    /// Where the band is labelled.
    pub(super) fn label(&self) -> f64 {
        f64::from(self.lowest) - 0.15 * gap(self.highest - self.lowest)
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
        (self.lowest..=self.highest).map(f64::from).collect()
    }

    fn range(&self) -> Range<f64> {
        self.line(self.lines)..f64::from(self.highest)
    }
}

impl ValueFormatter<f64> for Rates {
    fn format_ext(&self, value: &f64) -> String {
        plain(10f64.powf(*value))
    }
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
