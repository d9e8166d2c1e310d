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

use crate::judge::{OURS, Tally, Test};
use crate::median;
use crate::suite::{BLOCK, Case, Suite};
use crate::textbook;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// One test on one set: a point of a chart.
#[derive(Clone, Debug)]
pub struct Point {
    /// The set.
    pub set: String,
    /// Whether its pairs are from real contact.
    pub is_real: bool,
    /// The test.
    pub test: String,
    /// Nanoseconds per triangle pair.
    pub time: f64,
    /// Right and wrong answers.
    pub tally: Tally,
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

/// Ours, and those of the textbook. What a query makes of one pair is left out: it spends its time on setting up.
fn tests() -> Vec<(String, Test)> {
    let [exact, _, conservative, fast] = OURS;
    let ours = [exact, conservative, fast].map(|test| (format!("pfront {}", test.name), test));
    let others = textbook::tests().into_iter().map(|test| (test.name.to_owned(), test));
    ours.into_iter().chain(others).collect()
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
        let measured = on_cases(&cases, &tests, rounds);
        done(number + 1);
        let set = &suite.sets()[number];
        let points = tests.iter().zip(measured).map(|((name, _), (time, tally))| Point {
            set: set.name().to_owned(),
            is_real: set.contacts().is_some(),
            test: name.clone(),
            time,
            tally,
        });
        points.collect()
    };
    shares.iter().enumerate().map(set).collect()
}

/// For each test, the nanoseconds per pair, and how it did.
fn on_cases(cases: &[Case], tests: &[(String, Test)], rounds: usize) -> Vec<(f64, Tally)> {
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
    times.iter_mut().map(|times| median(times)).zip(tallies).collect()
}
