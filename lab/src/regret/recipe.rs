//! Which cases there are: drawn from a seed, spread evenly over kinds, motions, sizes and lengths.

use super::case::{Case, Frame, Verb};
use super::cloth::{self, Cloth};
use super::crowd::{self, Crowd};
use super::latin::{deal, spread};
use super::two::{self, Two};
use crate::player::Objects;
use anyhow::Result;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};

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

/// A case to be: little, unlike the case itself, which is built, run and dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    number: usize,
    actors: Actors,
    length: Length,
    verb: Verb,
    seed: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Actors {
    Two(Two),
    Cloth(Cloth),
    Crowd(Crowd),
}

/// How many frames there are, as long as they are not too dear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Length {
    /// 1 to 4: what is learned pays no more.
    Once,
    /// 8 to 24.
    Short,
    /// 48 to 64.
    Usual,
    /// 150 to 250.
    Long,
}

const VERBS: [Verb; 4] = [Verb::All, Verb::Any, Verb::All, Verb::Count];
const LENGTHS: [Length; 6] =
    [Length::Usual, Length::Once, Length::Usual, Length::Long, Length::Usual, Length::Short];

/// Draws cases: of eight, three are of two bodies, two of cloth, three of many bodies.
#[must_use]
pub fn recipes(seed: u64, cases: usize) -> Vec<Recipe> {
    let random = &mut seeded(seed);
    let cloths = cases / 4;
    let crowds = (cases - cloths) / 2;
    let twos = cases - cloths - crowds;
    let mut actors = Vec::new();
    let [sizes, mixtures] = [(); 2].map(|()| spread(twos, random));
    let motions = deal(&two::Motion::ALL, twos, random);
    for ((size, mixture), motion) in sizes.into_iter().zip(mixtures).zip(motions) {
        actors.push(Actors::Two(Two { motion, size, mixture }));
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
    for part in [twos, cloths, crowds] {
        let (verbs, lengths) = (deal(&VERBS, part, random), deal(&LENGTHS, part, random));
        rest.extend(verbs.into_iter().zip(lengths));
    }
    let all = actors.into_iter().zip(rest).enumerate();
    let recipe = |(number, (actors, (verb, length)))| Recipe {
        number,
        actors,
        length,
        verb,
        seed: random.random(),
    };
    all.map(recipe).collect()
}

/// A little of each kind, for whoever has to get ready.
pub(super) fn samples() -> [Recipe; 3] {
    let actors = [
        Actors::Two(Two { motion: two::Motion::Passing, size: 0.8, mixture: 0.0 }),
        Actors::Cloth(Cloth { motion: cloth::Motion::Folding, size: 0.8 }),
        Actors::Crowd(Crowd { motion: crowd::Motion::All, count: 0.5, size: 0.8, density: 0.5 }),
    ];
    actors.map(|actors| Recipe {
        number: 0,
        actors,
        length: Length::Once,
        verb: Verb::All,
        seed: 0,
    })
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
        let kind = match self.actors {
            Actors::Two(_) => "pair",
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
            Actors::Two(two) => two.seconds(scale),
            Actors::Cloth(cloth) => cloth.seconds(scale),
            Actors::Crowd(crowd) => crowd.seconds(scale),
        };
        let frames = self.length.frames(random).min((scale.seconds / seconds) as usize).max(1);
        let Built { class, objects, frames } = match self.actors {
            Actors::Two(two) => two.build(scale, frames, random),
            Actors::Cloth(cloth) => cloth.build(scale, frames, random),
            Actors::Crowd(crowd) => crowd.build(scale, frames, random),
        }?;
        Ok(Case { name: self.name(), class, objects, frames, verb: self.verb })
    }
}

impl Length {
    fn frames(self, random: &mut ChaCha8Rng) -> usize {
        random.random_range(match self {
            Self::Once => 1..=4,
            Self::Short => 8..=24,
            Self::Usual => 48..=64,
            Self::Long => 150..=250,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn a_seed_gives_the_same_cases_each_time() {
        assert_eq!(recipes(7, 48), recipes(7, 48));
        assert_ne!(recipes(7, 48), recipes(8, 48));
        for recipe in recipes(7, 8) {
            let [one, other] = [(); 2].map(|()| recipe.build(&Scale::QUICK).unwrap());
            assert!(one.frames == other.frames && one.class == other.class, "{}", one.name);
            let meshes = |case: &Case| -> Vec<_> {
                case.objects.models.iter().map(|model| model.mesh().positions().to_vec()).collect()
            };
            assert!(meshes(&one) == meshes(&other), "{}", one.name);
        }
    }

    #[test]
    fn every_seed_covers_motions_verbs_lengths_and_sizes() {
        for seed in 0..20 {
            let all = recipes(seed, 40);
            assert_eq!(all.len(), 40);
            let names: HashSet<String> = all.iter().map(motion).collect();
            let kinds =
                two::Motion::ALL.len() + cloth::Motion::ALL.len() + crowd::Motion::ALL.len();
            assert_eq!(names.len(), kinds, "seed {seed}");
            for verb in [Verb::All, Verb::Any, Verb::Count] {
                assert!(
                    all.iter().filter(|r| r.verb == verb).count() >= 8,
                    "seed {seed}: {verb:?}"
                );
            }
            for length in LENGTHS {
                assert!(
                    all.iter().filter(|r| r.length == length).count() >= 5,
                    "seed {seed}: {length:?}"
                );
            }
            let sizes: Vec<f64> = all.iter().map(size).collect();
            for tenth in 0..10 {
                let inside = sizes.iter().filter(|size| (**size * 10.0) as usize == tenth).count();
                assert!((3..=5).contains(&inside), "seed {seed}: {inside} of tenth {tenth}");
            }
        }
    }

    fn motion(recipe: &Recipe) -> String {
        match recipe.actors {
            Actors::Two(two) => format!("two {:?}", two.motion),
            Actors::Cloth(cloth) => format!("cloth {:?}", cloth.motion),
            Actors::Crowd(crowd) => format!("crowd {:?}", crowd.motion),
        }
    }

    fn size(recipe: &Recipe) -> f64 {
        match recipe.actors {
            Actors::Two(two) => two.size,
            Actors::Cloth(cloth) => cloth.size,
            Actors::Crowd(crowd) => crowd.size,
        }
    }
}
