//! Speed against accuracy, charted.
//!
//! Time is on the x axis, wrong answers per million on the y axis, both logarithmic, what is missed and what
//! is a false hit in panels of their own; where nothing is wrong, a point is in a band of its own, with
//! what that says about the rate: 0 of N bounds it by 3/N (Hanley & Lippman-Hand, *If Nothing Goes Wrong, Is
//! Everything All Right?*, JAMA 1983). A step line joins what nothing else beats in both.
//!
//! [`Charts`] is all of it:
//! - [`pairs`]: tests of single triangle pairs, on every set of the suite;
//! - [`frames`]: whole queries, every configuration of them, on the sets harvested from meshes in contact.
//!
//! All configurations take turns, round by round, so that whatever else the machine does hits all alike,
//! and a time is the median over rounds.

mod axes;
mod draw;
pub mod frames;
pub mod pairs;
mod report;
mod table;

pub use draw::{Figure, Row};
pub use report::{Charts, Plan};
pub use table::write_csv;

use crate::judge::Tally;
use std::io;
use thiserror::Error;

/// What goes wrong while measuring or charting.
#[derive(Debug, Error)]
pub enum ChartError {
    /// A query was refused.
    #[error(transparent)]
    Query(#[from] pfront::Error),
    /// The GPU failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] pfront::gpu::GpuError),
    /// There are no threads to be had.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// plotters cannot draw.
    #[error("cannot draw: {0}")]
    Draw(String),
    /// A table cannot be written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A file cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// How a configuration looks: shape and colour, both by number, and a word beside the mark.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// What the legend calls it.
    pub name: String,
    /// Shape of the mark.
    pub shape: usize,
    /// Its colour.
    pub colour: usize,
    /// Beside the mark; empty for nothing.
    pub tag: String,
    /// On which line of the band it is where nothing is wrong.
    pub line: usize,
}

/// One configuration on one set: a point of a chart.
#[derive(Clone, Debug)]
pub struct Point {
    /// The set.
    pub set: String,
    /// Whether its pairs are from real contact.
    pub is_real: bool,
    /// The configuration in full.
    pub configuration: String,
    /// How it is drawn.
    pub look: Look,
    /// Nanoseconds a triangle pair, or milliseconds a frame.
    pub time: f64,
    /// Right and wrong answers.
    pub tally: Tally,
}

/// Which points no other beats: none is at least as fast and as seldom wrong, and better in one of both.
#[must_use]
pub fn front(points: &[Point], wrong: impl Fn(&Tally) -> u64) -> Vec<bool> {
    let figures = |p: &Point| (p.time, p.tally.per_million(wrong(&p.tally)));
    let beaten = |p: &Point| {
        points.iter().any(|other| {
            let ((x, y), (u, v)) = (figures(p), figures(other));
            u <= x && v <= y && (u < x || v < y)
        })
    };
    points.iter().map(|p| !beaten(p)).collect()
}

/// Several sets as one: mean times, weighted by their pairs, and all answers together. Each set must have
/// the same configurations in the same order.
#[must_use]
pub fn together(name: &str, sets: &[&[Point]]) -> Vec<Point> {
    let Some(first) = sets.first() else { return Vec::new() };
    let joined = |i: usize| {
        let mut point = Point { set: name.to_owned(), tally: Tally::default(), ..first[i].clone() };
        let (mut time, mut weight) = (0.0, 0.0);
        for other in sets.iter().map(|set| &set[i]) {
            point.tally.add(&other.tally);
            time += other.time * other.tally.pairs as f64;
            weight += other.tally.pairs as f64;
        }
        point.time = time / f64::max(weight, 1.0);
        point
    };
    (0..first.len()).map(joined).collect()
}
