//! How often each method is right: answers to triangle pairs against their truth.

#[cfg(feature = "gpu")]
mod gpu;
mod in_f64;

#[cfg(feature = "gpu")]
pub use gpu::OnGpu;
pub use in_f64::{IN_F64, cases_in_f64, judge_in_f64};

use crate::suite::{Block, Case, Suite};
use anyhow::Result;
use pfront::pfront_core::bvtt::{PairBvtt, Query};
use pfront::pfront_core::triangle::intersects;
use pfront::pfront_core::{Aabb, Triangle};
use pfront::{Bvh, Mesh, Node, Pose};
use pfront_testkit::inexact;
use rayon::prelude::*;

/// A way to tell whether two triangles meet.
#[derive(Clone, Copy, Debug)]
pub struct Test<T = Triangle> {
    /// Its name.
    pub name: &'static str,
    /// The test.
    pub meets: fn(&T, &T) -> bool,
}

/// The triangle test, and what a query makes of the pair, which decides what it can by certified tests in f32 vectors
/// first.
pub const OURS: [Test; 2] = [
    Test { name: "Exact", meets: intersects },
    Test { name: "Exact, in a query", meets: in_query },
];

/// Asks a query about two meshes of one triangle each.
fn in_query(a: &Triangle, b: &Triangle) -> bool {
    let leaves = [a, b].map(|corners| {
        let Aabb { min, max } = Aabb::of(corners);
        [Node { min, max, first: 0, count: 1 }]
    });
    let bvh = |i: usize, corners| {
        Bvh::new_unchecked(Mesh::new_unchecked(corners, &[[0, 1, 2]]), &leaves[i], &[0])
    };
    let query = PairBvtt::new(bvh(0, a), bvh(1, b), Pose::IDENTITY);
    query.is_ok_and(|query| query.count() > 0)
}

/// The test of pfront by signs of plain f32: see [`inexact`].
pub const FAST: Test = Test { name: "Fast", meets: inexact::fast };

/// How some answers compare with the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Pairs asked about.
    pub pairs: u64,
    /// The pairs among them that meet.
    pub hits: u64,
    /// Hits that were denied.
    pub missed: u64,
    /// Hits that are none.
    pub false_hits: u64,
}

impl Tally {
    /// The tally of some pairs, with one answer each.
    pub fn of<T>(cases: &[Case<T>], answers: impl IntoIterator<Item = bool>) -> Self {
        let mut tally = Self::default();
        cases.iter().zip(answers).for_each(|(case, answer)| tally.count(case.meets, answer));
        tally
    }

    /// Counts one more pair.
    fn count(&mut self, meets: bool, answer: bool) {
        self.pairs += 1;
        self.hits += u64::from(meets);
        self.missed += u64::from(meets && !answer);
        self.false_hits += u64::from(!meets && answer);
    }

    /// Counts others too.
    pub fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.hits += other.hits;
        self.missed += other.missed;
        self.false_hits += other.false_hits;
    }

    /// Both kinds of wrong answers.
    pub fn wrong(&self) -> u64 {
        self.missed + self.false_hits
    }

    /// The rate of errors, per million, that is not exceeded with 95 % confidence where no error was seen: 3/N.
    pub fn bound(&self) -> f64 {
        3e6 / self.pairs.max(1) as f64
    }
}

/// The tallies of tests on some cases.
pub fn tallies<T>(tests: &[Test<T>], cases: &[Case<T>]) -> Vec<Tally> {
    let answers = |test: &Test<T>| {
        let meets = test.meets;
        cases.iter().map(move |case| meets(&case.a, &case.b))
    };
    tests.iter().map(|test| Tally::of(cases, answers(test))).collect()
}

/// For each set of a suite of so many pairs, a tally for each test, in the rayon pool of the caller; `beside` is told
/// every block.
///
/// # Errors
/// If `beside` fails.
pub fn judge(
    suite: &Suite,
    pairs: u64,
    tests: &[Test],
    mut beside: impl FnMut(&Block) -> Result<()>,
) -> Result<Vec<Vec<Tally>>> {
    let mut scores = vec![vec![Tally::default(); tests.len()]; suite.sets.len()];
    for blocks in suite.waves(pairs) {
        let found: Vec<_> = blocks.par_iter().map(|block| tallies(tests, &block.cases)).collect();
        for (block, found) in blocks.iter().zip(found) {
            beside(block)?;
            scores[block.set].iter_mut().zip(&found).for_each(|(score, tally)| score.add(tally));
        }
    }
    Ok(scores)
}
