//! Which cases there are: drawn from a seed, spread evenly over kinds, motions, sizes and lengths.
//!
//! They are a Latin hypercube (McKay, Beckman & Conover, *A Comparison of Three Methods for Selecting Values of Input
//! Variables*, Technometrics 1979): of n cases, one lies in each of n equal parts of every variable's range, so that a
//! few dozen cover all of them evenly, whatever the seed.

use super::case::{Case, Frame, Verb};
use super::{bodies, cloth};
use crate::player::Objects;
use anyhow::Result;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded, seq::SliceRandom};
use pfront_testkit::scenes::Kind;

/// How large cases may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Triangles of all bodies, more or less.
    pub triangles: usize,
    /// Bodies of a scene.
    pub bodies: usize,
    /// What all frames may take one thread, at a guess; one frame may take more. It bounds what frames take of
    /// memory, too: 2 seconds are some 200 MB.
    pub seconds: f64,
}

impl Scale {
    /// For the record: up to 3 million triangles and 10,000 bodies.
    pub const FULL: Self = Self { triangles: 3_000_000, bodies: 10_000, seconds: 2.0 };
    /// To see that it works.
    pub const QUICK: Self = Self { triangles: 10_000, bodies: 100, seconds: 0.01 };
}

/// How bodies move, or the vertices of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// Without contact.
    Apart,
    /// Not at all.
    Still,
    /// All, a little.
    Slow,
    /// One body of a hundred, or a fiftieth of the vertices.
    Few,
    /// Through each other, or folding.
    Passing,
    /// Together for some frames, then apart for as many, and so on.
    Meeting,
    /// Anywhere, each frame anew.
    Teleporting,
    /// Gears that mesh.
    Gears,
}

impl Motion {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Apart => "apart",
            Self::Still => "still",
            Self::Slow => "slow",
            Self::Few => "few move",
            Self::Passing => "passing",
            Self::Meeting => "meeting and parting",
            Self::Teleporting => "teleporting",
            Self::Gears => "gears",
        }
    }

    /// The motions of a kind of case.
    fn of(kind: Kind) -> &'static [Self] {
        use Motion::{Apart, Few, Gears, Meeting, Passing, Slow, Still, Teleporting};
        match kind {
            Kind::Pair => &[Apart, Still, Slow, Passing, Meeting, Teleporting, Gears],
            Kind::SelfMesh => &[Apart, Still, Slow, Few, Passing, Meeting, Teleporting],
            Kind::Many => &[Still, Slow, Few, Meeting, Teleporting, Gears],
        }
    }
}

/// A case to be: little, unlike the case itself, which is built, run and dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    number: usize,
    pub(super) kind: Kind,
    pub(super) motion: Motion,
    /// Triangles, from the fewest to the most, by factors.
    pub(super) size: f64,
    /// Bodies likewise; of two bodies, how unequal they are.
    pub(super) bodies: f64,
    /// How close bodies lie, likewise.
    pub(super) density: f64,
    frames: [usize; 2],
    verb: Verb,
    seed: u64,
}

const VERBS: [Verb; 4] = [Verb::All, Verb::Any, Verb::All, Verb::Count];
/// Fewest and most frames, as long as they are not too expensive: so few that nothing learned pays, up to many.
const LENGTHS: [[usize; 2]; 6] = [[48, 64], [1, 4], [48, 64], [150, 250], [48, 64], [8, 24]];

/// Draws cases: of eight, three are of two bodies, two of cloth, three of many bodies.
#[must_use]
pub fn recipes(seed: u64, cases: usize) -> Vec<Recipe> {
    let random = &mut seeded(seed);
    let cloths = cases / 4;
    let crowds = (cases - cloths) / 2;
    let kinds =
        [(Kind::Pair, cases - cloths - crowds), (Kind::SelfMesh, cloths), (Kind::Many, crowds)];
    let mut all = Vec::new();
    for (kind, n) in kinds {
        let [sizes, bodies, densities] = [(); 3].map(|()| spread(n, random));
        let motions = deal(Motion::of(kind), n, random);
        let (verbs, lengths) = (deal(&VERBS, n, random), deal(&LENGTHS, n, random));
        for i in 0..n {
            all.push(Recipe {
                number: all.len(),
                kind,
                motion: motions[i],
                size: sizes[i],
                bodies: bodies[i],
                density: densities[i],
                frames: lengths[i],
                verb: verbs[i],
                seed: random.random(),
            });
        }
    }
    all
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

/// From `least` to `most` as `share` goes from 0 to 1, by equal factors for equal steps.
pub(super) fn by_factors(least: usize, most: usize, share: f64) -> usize {
    let [low, high] = [least, most.max(least)].map(|n| (n as f64).ln());
    ((low + (high - low) * share).exp().round() as usize).clamp(least, most.max(least))
}

/// A little of each kind, for whoever has to get ready.
pub(super) fn samples() -> Vec<Recipe> {
    let all = recipes(0, 8).into_iter();
    all.map(|recipe| Recipe { frames: [4, 4], verb: Verb::All, ..recipe }).collect()
}

/// What the makers of cases return.
pub(super) struct Built {
    pub(super) class: String,
    pub(super) objects: Objects,
    pub(super) frames: Vec<Frame>,
}

impl Recipe {
    /// What tables call the case.
    #[must_use]
    pub fn name(&self) -> String {
        let kind = match self.kind {
            Kind::Pair => "pair",
            Kind::SelfMesh => "self",
            Kind::Many => "scene",
        };
        format!("{kind} {}", self.number + 1)
    }

    /// Builds the models and all frames.
    ///
    /// # Errors
    /// If a scene cannot be made.
    pub fn build(&self, scale: &Scale) -> Result<Case> {
        let random = &mut seeded(self.seed);
        let seconds = match self.kind {
            Kind::SelfMesh => cloth::seconds(self, scale),
            _ => bodies::seconds(self, scale),
        };
        let [fewest, most] = self.frames;
        let frames = random.random_range(fewest..=most).min((scale.seconds / seconds) as usize);
        let Built { class, objects, frames } = match self.kind {
            Kind::Pair => bodies::pair(self, scale, frames.max(1), random),
            Kind::SelfMesh => cloth::build(self, scale, frames.max(1), random),
            Kind::Many => bodies::scene(self, scale, frames.max(1), random),
        }?;
        Ok(Case { name: self.name(), class, objects, frames, verb: self.verb })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_cases_each_time() {
        assert_eq!(recipes(7, 48), recipes(7, 48));
        assert_ne!(recipes(7, 48), recipes(8, 48));
        for recipe in recipes(7, 8) {
            let [one, other] = [(); 2].map(|()| recipe.build(&Scale::QUICK).unwrap());
            assert!(one.frames == other.frames && one.class == other.class, "{}", one.name);
        }
    }

    #[test]
    fn every_seed_covers_motions_verbs_lengths_and_sizes() {
        for seed in 0..20 {
            let all = recipes(seed, 40);
            assert_eq!(all.len(), 40);
            let count =
                |is_meant: &dyn Fn(&Recipe) -> bool| all.iter().filter(|r| is_meant(r)).count();
            for kind in [Kind::Pair, Kind::SelfMesh, Kind::Many] {
                for motion in Motion::of(kind) {
                    assert!(count(&|r| r.kind == kind && r.motion == *motion) > 0, "seed {seed}");
                }
            }
            for verb in VERBS {
                assert!(count(&|r| r.verb == verb) >= 8, "seed {seed}: {verb:?}");
            }
            for length in LENGTHS {
                assert!(count(&|r| r.frames == length) >= 5, "seed {seed}: {length:?}");
            }
            for tenth in 0..10 {
                let inside = count(&|r| (r.size * 10.0) as usize == tenth);
                assert!((3..=5).contains(&inside), "seed {seed}: {inside} of tenth {tenth}");
            }
        }
        assert_eq!([0.0, 0.5, 1.0].map(|share| by_factors(1, 10_000, share)), [1, 100, 10_000]);
        assert_eq!(by_factors(20, 4, 0.7), 20);
    }
}
