//! The cases: drawn from a seed, spread evenly over kinds, motions, sizes and lengths.
//!
//! They are a Latin hypercube (McKay, Beckman & Conover, *A Comparison of Three Methods for Selecting Values of Input
//! Variables*, Technometrics 1979): of n cases, one lies in each of n equal parts of every variable's range, so that a
//! few dozen cover all of them evenly, whatever the seed.

use super::case::{Built, Case, Verb};
use super::cloth::{self, Cloth};
use super::crowd::{self, Crowd};
use super::pair::{self, Pair};
use super::scale::Scale;
use anyhow::Result;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded, seq::SliceRandom};

/// A case to be: little, unlike the case itself, which is built, run and dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    number: usize,
    actors: Actors,
    frames: [usize; 2],
    verb: Verb,
    seed: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Actors {
    Pair(Pair),
    Cloth(Cloth),
    Crowd(Crowd),
}

const VERBS: [Verb; 4] = [Verb::All, Verb::Any, Verb::All, Verb::Count];
/// Fewest and most frames, as long as they are not too expensive: so few that nothing learned pays, up to many.
const LENGTHS: [[usize; 2]; 6] = [[48, 64], [1, 4], [48, 64], [150, 250], [48, 64], [8, 24]];

/// Draws cases: of eight, three are of two bodies, two of cloth, three of many bodies.
pub fn recipes(seed: u64, cases: usize) -> Vec<Recipe> {
    let random = &mut seeded(seed);
    let cloths = cases / 4;
    let crowds = (cases - cloths) / 2;
    let pairs = cases - cloths - crowds;
    let mut actors = Vec::new();
    let [sizes, mixtures] = [(); 2].map(|()| spread(pairs, random));
    let motions = deal(&pair::Motion::ALL, pairs, random);
    for ((size, mixture), motion) in sizes.into_iter().zip(mixtures).zip(motions) {
        actors.push(Actors::Pair(Pair { motion, size, mixture }));
    }
    let sizes = spread(cloths, random);
    let motions = deal(&cloth::Motion::ALL, cloths, random);
    for (size, motion) in sizes.into_iter().zip(motions) {
        actors.push(Actors::Cloth(Cloth { motion, size }));
    }
    let [counts, sizes, densities] = [(); 3].map(|()| spread(crowds, random));
    let motions = deal(&crowd::Motion::ALL, crowds, random);
    for (((count, size), density), motion) in
        counts.into_iter().zip(sizes).zip(densities).zip(motions)
    {
        actors.push(Actors::Crowd(Crowd { motion, count, size, density }));
    }
    let mut rest = Vec::new();
    for part in [pairs, cloths, crowds] {
        let (verbs, lengths) = (deal(&VERBS, part, random), deal(&LENGTHS, part, random));
        rest.extend(verbs.into_iter().zip(lengths));
    }
    let all = actors.into_iter().zip(rest).enumerate();
    let recipe = |(number, (actors, (verb, frames)))| Recipe {
        number,
        actors,
        frames,
        verb,
        seed: random.random(),
    };
    all.map(recipe).collect()
}

/// One number in each of `n` equal parts of 0 to 1, in random order.
fn spread(n: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut all: Vec<f64> =
        (0..n).map(|part| (part as f64 + random.random::<f64>()) / n as f64).collect();
    all.shuffle(random);
    all
}

/// `n` of some values, each as often as the others or once more, in random order.
fn deal<T: Copy>(values: &[T], n: usize, random: &mut ChaCha8Rng) -> Vec<T> {
    let mut turns = values.to_vec();
    turns.shuffle(random);
    let mut all: Vec<T> = turns.into_iter().cycle().take(n).collect();
    all.shuffle(random);
    all
}

/// A little of each kind, for whoever has to get ready.
pub(super) fn samples() -> [Recipe; 3] {
    let actors = [
        Actors::Pair(Pair { motion: pair::Motion::Passing, size: 0.8, mixture: 0.0 }),
        Actors::Cloth(Cloth { motion: cloth::Motion::Folding, size: 0.8 }),
        Actors::Crowd(Crowd { motion: crowd::Motion::All, count: 0.5, size: 0.8, density: 0.5 }),
    ];
    actors.map(|actors| Recipe { number: 0, actors, frames: [1, 4], verb: Verb::All, seed: 0 })
}

impl Recipe {
    /// The name of the case in tables.
    pub fn name(&self) -> String {
        let kind = match self.actors {
            Actors::Pair(_) => "pair",
            Actors::Cloth(_) => "self",
            Actors::Crowd(_) => "scene",
        };
        format!("{kind} {}", self.number + 1)
    }

    /// Builds the models and all frames.
    ///
    /// # Errors
    /// If a scene cannot be made.
    pub fn build(&self, scale: &Scale) -> Result<Case> {
        let random = &mut seeded(self.seed);
        let seconds = match self.actors {
            Actors::Pair(pair) => pair.seconds(scale),
            Actors::Cloth(cloth) => cloth.seconds(scale),
            Actors::Crowd(crowd) => crowd.seconds(scale),
        };
        let [fewest, most] = self.frames;
        let frames =
            random.random_range(fewest..=most).min((scale.seconds / seconds) as usize).max(1);
        let Built { class, objects, frames } = match self.actors {
            Actors::Pair(pair) => pair.build(scale, frames, random),
            Actors::Cloth(cloth) => cloth.build(scale, frames, random),
            Actors::Crowd(crowd) => crowd.build(scale, frames, random),
        }?;
        Ok(Case { name: self.name(), class, objects, frames, verb: self.verb })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regret::scale::by_factors;
    use std::collections::HashSet;

    #[test]
    fn a_seed_gives_the_same_cases_each_time() {
        assert_eq!(recipes(7, 48), recipes(7, 48));
        assert_ne!(recipes(7, 48), recipes(8, 48));
        for recipe in recipes(7, 8) {
            let [one, other] = [(); 2].map(|()| recipe.build(&Scale::QUICK).unwrap());
            assert!(one.frames == other.frames && one.class == other.class, "{}", one.name);
            for (one, other) in one.objects.models.iter().zip(&other.objects.models) {
                assert_eq!(one.mesh().shadow(), other.mesh().shadow());
            }
        }
    }

    #[test]
    fn every_seed_covers_motions_verbs_lengths_and_sizes() {
        for seed in 0..20 {
            let all = recipes(seed, 40);
            assert_eq!(all.len(), 40);
            let names: HashSet<String> = all.iter().map(|r| motion_and_size(r).0).collect();
            let motions =
                pair::Motion::ALL.len() + cloth::Motion::ALL.len() + crowd::Motion::ALL.len();
            assert_eq!(names.len(), motions, "seed {seed}");
            let count =
                |is_meant: &dyn Fn(&Recipe) -> bool| all.iter().filter(|r| is_meant(r)).count();
            for verb in VERBS {
                assert!(count(&|r| r.verb == verb) >= 8, "seed {seed}: {verb:?}");
            }
            for length in LENGTHS {
                assert!(count(&|r| r.frames == length) >= 5, "seed {seed}: {length:?}");
            }
            for tenth in 0..10 {
                let inside = count(&|r| (motion_and_size(r).1 * 10.0) as usize == tenth);
                assert!((3..=5).contains(&inside), "seed {seed}: {inside} of tenth {tenth}");
            }
        }
    }

    fn motion_and_size(recipe: &Recipe) -> (String, f64) {
        match recipe.actors {
            Actors::Pair(pair) => (format!("pair {:?}", pair.motion), pair.size),
            Actors::Cloth(cloth) => (format!("cloth {:?}", cloth.motion), cloth.size),
            Actors::Crowd(crowd) => (format!("crowd {:?}", crowd.motion), crowd.size),
        }
    }

    #[test]
    fn every_part_is_met_once_and_values_and_factors_are_even() {
        for n in [1, 2, 7, 40] {
            let mut all = spread(n, &mut seeded(n as u64));
            all.sort_by(f64::total_cmp);
            assert!(all.iter().enumerate().all(|(part, x)| (x * n as f64) as usize == part));
        }
        let dealt = deal(&[1, 2, 3], 8, &mut seeded(3));
        let mut counts = [1, 2, 3].map(|value| dealt.iter().filter(|x| **x == value).count());
        counts.sort_unstable();
        assert_eq!(counts, [2, 3, 3]);
        assert_eq!([0.0, 0.5, 1.0].map(|share| by_factors(1, 10_000, share)), [1, 100, 10_000]);
        assert_eq!(by_factors(20, 4, 0.7), 20);
    }
}
