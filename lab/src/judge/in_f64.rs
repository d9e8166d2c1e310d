//! Answers to triangle pairs in f64.

use super::{Tally, Test, tallies};
use crate::suite::{BLOCK, Case};
use crate::textbook;
use pfront::pfront_core::triangle::{intersects, intersects_f64};
use pfront_testkit::families::{Family, InF64, Triangle64};
use pfront_testkit::oracle::intersect;
use pfront_testkit::rng::seeded;
use rayon::prelude::*;

/// Ours, ours after all coordinates were rounded to f32, and the best of the textbook.
pub const IN_F64: [Test<Triangle64>; 3] = [
    Test { name: "Exact, in f64", meets: |a, b| intersects_f64(a, b) == Ok(true) },
    Test { name: "Exact, rounded to f32 before", meets: rounded },
    textbook::IN_F64,
];

fn rounded(a: &Triangle64, b: &Triangle64) -> bool {
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(|x| x as f32)));
    intersects(&a, &b)
}

/// About `pairs` pairs of all families, made f64 in one way, in blocks; by the rayon pool of the caller. Pairs with a
/// coordinate beyond 2^125 are left out.
pub fn cases_in_f64(
    way: InF64,
    pairs: u64,
    seed: u64,
) -> impl ParallelIterator<Item = Vec<Case<Triangle64>>> {
    let share = pairs.div_ceil(Family::ALL.len() as u64);
    let blocks = share.div_ceil(BLOCK as u64);
    (0..blocks * Family::ALL.len() as u64).into_par_iter().map(move |number| {
        let (block, family) = (number % blocks, number / blocks);
        let mut rng = seeded(seed ^ (family << 32) ^ ((way as u64) << 40));
        rng.set_stream(block);
        let length = (share - block * BLOCK as u64).min(BLOCK as u64);
        let pair = |_| way.pair(Family::ALL[family as usize], &mut rng);
        let pairs = (0..length).filter_map(pair);
        pairs.map(|(a, b)| Case { a, b, meets: intersect(&a, &b) }).collect()
    })
}

/// For each way in which families are made f64, and each test, a tally of about `pairs` in all.
pub fn judge_in_f64(pairs: u64, seed: u64) -> Vec<Vec<Tally>> {
    let both = |mut sums: Vec<Tally>, others: Vec<Tally>| {
        sums.iter_mut().zip(&others).for_each(|(sum, other)| sum.add(other));
        sums
    };
    let way = |way| {
        let blocks = cases_in_f64(way, pairs.div_ceil(InF64::ALL.len() as u64), seed);
        let found = blocks.map(|cases| tallies(&IN_F64, &cases));
        found.reduce(|| vec![Tally::default(); IN_F64.len()], both)
    };
    InF64::ALL.map(way).into()
}
