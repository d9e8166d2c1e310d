//! Speed against accuracy of tests of two triangles, charted.
//!
//! Time is on the x axis, wrong answers per million on the y axis, both logarithmic, what is missed and what is a false
//! hit in panels of their own. Where nothing is wrong, a point is on the line of 0: 0 of N bounds the rate by 3/N (Hanley
//! & Lippman-Hand, *If Nothing Goes Wrong, Is Everything All Right?*, JAMA 1983).
//!
//! All tests take turns, round by round, so that whatever else the machine does hits all alike, and a time is the
//! median over rounds.

mod report;

pub use report::{figure, summary, write_csv};

use crate::judge::{IN_F64, INEXACT, OURS, Tally, Test, cases_in_f64};
use crate::median;
use crate::suite::{BLOCK, Case, Suite};
use crate::textbook;
use pfront_testkit::families::InF64;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// One test on one set: a point of a chart.
#[derive(Clone, Debug)]
pub struct Point {
    /// The set.
    pub set: String,
    /// Where its pairs come from.
    pub source: Source,
    /// The test.
    pub test: String,
    /// Nanoseconds per triangle pair.
    pub time: f64,
    /// Right and wrong answers.
    pub tally: Tally,
}

/// Where the pairs of a set come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Pairs that are made to be hard.
    Family,
    /// Pairs from real contact.
    Contact,
    /// Pairs that are made to be hard, in f64.
    FamilyInF64,
}

/// The points that no other beats: none is at least as fast and as seldom wrong, and better in one of both.
pub fn front(points: &[Point]) -> Vec<bool> {
    let figures = |p: &Point| (p.time, p.tally.per_million(p.tally.wrong()));
    let beaten = |p: &Point| {
        points.iter().any(|other| {
            let ((x, y), (u, v)) = (figures(p), figures(other));
            u <= x && v <= y && (u < x || v < y)
        })
    };
    points.iter().map(|p| !beaten(p)).collect()
}

/// Several sets as one: mean times, weighted by their pairs, and all answers together. Each set must have the same
/// tests in the same order.
pub fn together(name: &str, sets: &[&[Point]]) -> Vec<Point> {
    let Some(first) = sets.first() else { return Vec::new() };
    let joined = |i: usize| {
        let mut point = Point { set: name.to_owned(), tally: Tally::default(), ..first[i].clone() };
        let mut time = 0.0;
        for other in sets.iter().map(|set| &set[i]) {
            point.tally.add(&other.tally);
            time += other.time * other.tally.pairs as f64;
        }
        point.time = time / point.tally.pairs.max(1) as f64;
        point
    };
    (0..first.len()).map(joined).collect()
}

/// Ours, the inexact ones, and those of the textbook. A query about one pair is left out: it spends its time on setting up.
fn tests() -> Vec<(String, Test)> {
    let [exact, _] = OURS;
    let others = INEXACT.into_iter().chain(textbook::tests());
    [named(exact)].into_iter().chain(others.map(|test| (test.name.to_owned(), test))).collect()
}

fn named<T>(ours: Test<T>) -> (String, Test<T>) {
    (format!("pfront {}", ours.name), ours)
}

/// Measures all tests, a set after the other: for each, its points. `pairs` is of the whole suite, `done` is told the
/// number of sets that are done.
///
/// A round asks each test about all pairs of the set, on the calling thread; pairs are made beforehand, by all
/// threads.
pub fn measure(suite: &Suite, pairs: u64, rounds: usize, done: impl Fn(usize)) -> Vec<Vec<Point>> {
    let tests = tests();
    let shares = suite.shares(pairs);
    let set = |(number, &share): (usize, &u64)| {
        let blocks = share.div_ceil(BLOCK as u64);
        let length = |block: u64| (share - block * BLOCK as u64).min(BLOCK as u64) as usize;
        let made = (0..blocks).into_par_iter();
        let cases: Vec<Case> =
            made.flat_map_iter(|block| suite.block(number, block, length(block))).collect();
        let set = &suite.sets()[number];
        let source = if set.contacts().is_some() { Source::Contact } else { Source::Family };
        let points = on_cases(set.name(), source, &cases, &tests, rounds);
        done(number + 1);
        points
    };
    shares.iter().enumerate().map(set).collect()
}

/// [`measure`] in f64: about `pairs` of each way in which families are made f64.
pub fn measure_in_f64(pairs: u64, seed: u64, rounds: usize) -> Vec<Vec<Point>> {
    let [exact, rounded, textbook] = IN_F64;
    let tests = [named(exact), named(rounded), (textbook.name.to_owned(), textbook)];
    let set = |way: InF64| {
        let cases: Vec<_> = cases_in_f64(way, pairs, seed).flatten_iter().collect();
        on_cases(&format!("{} in f64", way.name()), Source::FamilyInF64, &cases, &tests, rounds)
    };
    InF64::ALL.map(set).into()
}

/// A point for each test.
fn on_cases<T>(
    set: &str,
    source: Source,
    cases: &[Case<T>],
    tests: &[(String, Test<T>)],
    rounds: usize,
) -> Vec<Point> {
    let mut answers = vec![false; cases.len()];
    let mut times = vec![Vec::new(); tests.len()];
    let mut tallies = vec![Tally::default(); tests.len()];
    for _ in 0..rounds.max(1) {
        for (i, (_, test)) in tests.iter().enumerate() {
            let clock = Instant::now();
            for (answer, case) in answers.iter_mut().zip(cases) {
                *answer = (test.meets)(&case.a, &case.b);
            }
            times[i].push(1e9 * clock.elapsed().as_secs_f64() / cases.len().max(1) as f64);
            tallies[i] = Tally::of(cases, black_box(&answers).iter().copied());
        }
    }
    let measured = times.iter_mut().map(|times| median(times)).zip(tallies);
    let point = |((name, _), (time, tally)): (&(String, _), _)| Point {
        set: set.to_owned(),
        source,
        test: name.clone(),
        time,
        tally,
    };
    tests.iter().zip(measured).map(point).collect()
}
