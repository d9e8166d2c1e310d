//! Speed against accuracy of tests of two triangles, as comma-separated values that `docs/charts.py` draws.
//!
//! All tests take turns, round by round, so that whatever else the machine does hits all alike, and a time is the
//! median over rounds.

use crate::judge::{FAST, IN_F64, OURS, Tally, Test, cases_in_f64};
use crate::median;
use crate::suite::{BLOCK, Case, Set, Suite};
use crate::textbook;
use pfront_testkit::families::InF64;
use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

/// One test on one set.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// The set.
    pub set: String,
    /// Where its pairs come from: `family`, `contact`, or `family in f64`.
    pub source: &'static str,
    /// The test.
    pub test: &'static str,
    /// Nanoseconds per triangle pair.
    pub ns_per_pair: f64,
    /// Pairs asked about.
    pub pairs: u64,
    /// Hits that were denied.
    pub missed: u64,
    /// Hits that are none.
    pub false_hits: u64,
}

/// Measures ours, the inexact ones, and those of the textbook on all sets of a suite of so many pairs.
///
/// A round asks each test about all pairs of the set, on the calling thread; pairs are made beforehand, by all
/// threads.
pub fn measure(suite: &Suite, pairs: u64, rounds: usize, mut done: impl FnMut()) -> Vec<Point> {
    // A query about one pair is left out: it spends its time on setting up.
    let tests = [&OURS[..1], &[FAST], &textbook::tests()].concat();
    let mut points = Vec::new();
    for (number, (set, share)) in suite.sets.iter().zip(suite.shares(pairs)).enumerate() {
        let length = |block: u64| (share - block * BLOCK as u64).min(BLOCK as u64) as usize;
        let made = (0..share.div_ceil(BLOCK as u64)).into_par_iter();
        let cases = made.flat_map_iter(|block| suite.block(number, block, length(block)));
        let source = if matches!(set, Set::Contacts(_)) { "contact" } else { "family" };
        points.extend(on_cases(&set.name(), source, &cases.collect::<Vec<_>>(), &tests, rounds));
        done();
    }
    points
}

/// [`measure`] in f64: about `pairs` of each way in which families are made f64.
pub fn measure_in_f64(pairs: u64, seed: u64, rounds: usize) -> Vec<Point> {
    let set = |way: InF64| {
        let cases: Vec<_> = cases_in_f64(way, pairs, seed).flatten_iter().collect();
        on_cases(&format!("{} in f64", way.name()), "family in f64", &cases, &IN_F64, rounds)
    };
    InF64::ALL.into_iter().flat_map(set).collect()
}

fn on_cases<T>(
    set: &str,
    source: &'static str,
    cases: &[Case<T>],
    tests: &[Test<T>],
    rounds: usize,
) -> Vec<Point> {
    let mut answers = vec![false; cases.len()];
    let mut measured = vec![(Vec::new(), Tally::default()); tests.len()];
    for _ in 0..rounds.max(1) {
        for (test, (times, tally)) in tests.iter().zip(&mut measured) {
            let clock = Instant::now();
            for (answer, case) in answers.iter_mut().zip(cases) {
                *answer = (test.meets)(&case.a, &case.b);
            }
            times.push(1e9 * clock.elapsed().as_secs_f64() / cases.len().max(1) as f64);
            *tally = Tally::of(cases, black_box(&answers).iter().copied());
        }
    }
    let point = |(test, (times, tally)): (&Test<T>, &mut (Vec<f64>, Tally))| Point {
        set: set.to_owned(),
        source,
        test: test.name,
        ns_per_pair: (1e4 * median(times)).round() / 1e4,
        pairs: tally.pairs,
        missed: tally.missed,
        false_hits: tally.false_hits,
    };
    tests.iter().zip(&mut measured).map(point).collect()
}

/// Writes a line for each point.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, points: &[Point]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    points.iter().try_for_each(|point| table.serialize(point))?;
    Ok(table.flush()?)
}

/// Each test of each source over all its sets: nanoseconds, and missed and false hits per million.
pub fn summary(points: &[Point]) -> Vec<(String, [f64; 3])> {
    let mut sums: Vec<(String, [f64; 4])> = Vec::new();
    for point in points {
        let name = format!("{}: {}", point.source, point.test);
        let pairs = point.pairs as f64;
        let more = [pairs, pairs * point.ns_per_pair, point.missed as f64, point.false_hits as f64];
        match sums.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => sum.iter_mut().zip(more).for_each(|(sum, x)| *sum += x),
            None => sums.push((name, more)),
        }
    }
    let each = |[pairs, time, missed, false_hits]: [f64; 4]| {
        [time, 1e6 * missed, 1e6 * false_hits].map(|sum| sum / pairs.max(1.0))
    };
    sums.into_iter().map(|(name, sum)| (name, each(sum))).collect()
}
