//! Answers to triangle pairs in f64.

use super::Tally;
use crate::textbook;
use pfront::Accuracy;
use pfront::pfront_core::triangle::{intersects, intersects_f64};
use pfront_testkit::families::{Family, InF64, Triangle64};
use pfront_testkit::oracle::intersect;
use pfront_testkit::rng::seeded;
use rayon::prelude::*;

/// A way to tell whether two triangles in f64 meet.
#[derive(Clone, Copy, Debug)]
pub struct TestInF64 {
    /// What it is called.
    pub name: &'static str,
    /// The test.
    pub meets: fn(&Triangle64, &Triangle64) -> bool,
}

/// Ours, ours after all coordinates were rounded to f32, and the best of the textbook.
pub const TESTS_IN_F64: [TestInF64; 3] = [
    TestInF64 { name: "Exact, in f64", meets: |a, b| intersects_f64(a, b) == Ok(true) },
    TestInF64 { name: "Exact, rounded to f32 before", meets: rounded },
    textbook::IN_F64,
];

fn rounded(a: &Triangle64, b: &Triangle64) -> bool {
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(|x| x as f32)));
    intersects(&a, &b, Accuracy::Exact)
}

/// For each way in which families are made f64, and each test, a tally of about `pairs` in all, in the rayon pool of the
/// caller.
pub fn tallies_in_f64(pairs: u64, seed: u64) -> [[Tally; TESTS_IN_F64.len()]; InF64::ALL.len()] {
    let share = pairs.div_ceil((Family::ALL.len() * InF64::ALL.len()) as u64);
    let of_family = |way: InF64, (stream, family): (u64, Family)| {
        let mut rng = seeded(seed);
        rng.set_stream(stream + 100 * way as u64);
        let mut tallies = [Tally::default(); TESTS_IN_F64.len()];
        for _ in 0..share {
            let Some((a, b)) = way.pair(family, &mut rng) else { continue };
            let truth = intersect(&a, &b);
            let both = tallies.iter_mut().zip(&TESTS_IN_F64);
            both.for_each(|(tally, test)| tally.count(truth, (test.meets)(&a, &b)));
        }
        tallies
    };
    InF64::ALL.map(|way| {
        let families: Vec<_> = (0..).zip(Family::ALL).collect();
        let all: Vec<_> = families.into_par_iter().map(|family| of_family(way, family)).collect();
        let mut sums = [Tally::default(); TESTS_IN_F64.len()];
        for tallies in &all {
            sums.iter_mut().zip(tallies).for_each(|(sum, own)| sum.add(own));
        }
        sums
    })
}
