//! Tests of single triangle pairs, on every set of a suite.

use super::{Look, Point};
use crate::judge::{OURS, Tally, Test};
use crate::median;
use crate::suite::{BLOCK, Case, Suite};
use crate::textbook;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Ours, in three colours, and the textbook's in grey. What a query makes of one pair is left out: it
/// spends its time on setting up.
fn tests() -> Vec<(Test, Look)> {
    let look = |test: Test, shape, colour| {
        (test, Look { name: test.name.to_owned(), shape, colour, ..Look::default() })
    };
    let [exact, _, conservative, fast] = OURS;
    let ours = [exact, conservative, fast].into_iter().enumerate();
    let ours = ours.map(|(i, test)| {
        let (test, mut looks) = look(test, i, i);
        looks.name = format!("pfront {}", test.name);
        (test, looks)
    });
    let others = textbook::tests().into_iter().enumerate();
    ours.chain(others.map(|(i, test)| look(test, 3 + i, 3))).collect()
}

/// Measures all tests, a set after the other: for each, its points. `pairs` is of the whole suite, `done` is
/// told the number of sets that are done.
///
/// A round asks each test about all pairs of the set, on the calling thread; pairs are made beforehand, by all
/// threads.
pub fn measure(suite: &Suite, pairs: u64, rounds: usize, done: impl Fn(usize)) -> Vec<Vec<Point>> {
    let tests = tests();
    let shares = suite.shares(pairs);
    let set = |(set, &share): (usize, &u64)| {
        let blocks = share.div_ceil(BLOCK as u64);
        let length = |block: u64| (share - block * BLOCK as u64).min(BLOCK as u64) as usize;
        let made = (0..blocks).into_par_iter();
        let cases: Vec<Case> =
            made.flat_map_iter(|block| suite.block(set, block, length(block))).collect();
        let measured = on_cases(&cases, &tests, rounds);
        done(set + 1);
        let points = tests.iter().zip(measured).map(|((_, look), (time, tally))| Point {
            set: suite.sets()[set].name().to_owned(),
            is_real: suite.sets()[set].contacts().is_some(),
            configuration: look.name.clone(),
            look: look.clone(),
            time,
            tally,
        });
        points.collect()
    };
    shares.iter().enumerate().map(set).collect()
}

/// For each test, the nanoseconds a pair takes, and how it did.
fn on_cases(cases: &[Case], tests: &[(Test, Look)], rounds: usize) -> Vec<(f64, Tally)> {
    let mut answers = vec![false; cases.len()];
    let mut times = vec![Vec::new(); tests.len()];
    let mut tallies = vec![Tally::default(); tests.len()];
    for _ in 0..rounds.max(1) {
        for (i, (test, _)) in tests.iter().enumerate() {
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
