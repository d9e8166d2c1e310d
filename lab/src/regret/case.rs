//! Cases: a built-in scene at some size, its frames in some order, and what is asked of each.
//!
//! They are drawn from a seed, spread evenly over scenes, orders, sizes, lengths and verbs.

use crate::player::{Objects, Player};
use crate::recording::header;
use crate::workload::Frame;
use anyhow::Result;
use pfront::{Model, Pose};
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded, seq::SliceRandom};
use pfront_testkit::scenes::{Kind, Scene};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// What is asked of each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verb {
    /// All pairs, sorted.
    All,
    /// Whether anything meets.
    Any,
    /// How many pairs meet.
    Count,
}

/// The order of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// As the scene has them.
    Coherent,
    /// One frame again and again.
    Still,
    /// Some frames from the first on, as many from the middle on, and so on.
    Alternating,
    /// Any frame, each time anew.
    Teleporting,
}

/// A case to be: little, unlike the case itself, which is built, run and dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    number: usize,
    scene: &'static str,
    order: Order,
    /// Triangles.
    size: usize,
    frames: usize,
    of_all_frames: usize,
    verb: Verb,
    seed: u64,
}

const ORDERS: [Order; 5] =
    [Order::Coherent, Order::Still, Order::Coherent, Order::Alternating, Order::Teleporting];
const VERBS: [Verb; 4] = [Verb::All, Verb::Any, Verb::All, Verb::Count];
/// From so few frames that nothing learned pays, up to many.
const LENGTHS: [usize; 6] = [56, 3, 56, 200, 56, 16];
/// The fewest triangles asked for; gears take more.
const FEWEST: f64 = 100.0;

/// How large cases may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The most triangles asked for.
    pub triangles: f64,
    /// The most triangles of all frames together, which bounds the time of a case.
    pub of_all_frames: usize,
}

impl Scale {
    /// For the record: up to 3 million triangles, some seconds on one thread.
    pub const FULL: Self = Self { triangles: 3e6, of_all_frames: 20_000_000 };
    /// To see that it works.
    pub const QUICK: Self = Self { triangles: 2_000.0, of_all_frames: 200_000 };
}

/// Draws cases.
#[must_use]
pub fn recipes(seed: u64, cases: usize, scale: Scale) -> Vec<Recipe> {
    let random = &mut seeded(seed);
    let scenes = deal(&Scene::NAMES, cases, random);
    let (orders, verbs) = (deal(&ORDERS, cases, random), deal(&VERBS, cases, random));
    let lengths = deal(&LENGTHS, cases, random);
    let mut sizes: Vec<f64> = (0..cases).map(|part| part as f64 + random.random::<f64>()).collect();
    sizes.shuffle(random);
    let recipe = |number: usize| Recipe {
        number,
        scene: scenes[number],
        order: orders[number],
        size: (FEWEST * (scale.triangles / FEWEST).powf(sizes[number] / cases as f64)) as usize,
        frames: lengths[number],
        of_all_frames: scale.of_all_frames,
        verb: verbs[number],
        seed: random.random(),
    };
    (0..cases).map(recipe).collect()
}

/// `n` of some values, each as often as the others or once more, in random order.
fn deal<T: Copy>(values: &[T], n: usize, random: &mut ChaCha8Rng) -> Vec<T> {
    let mut all: Vec<T> = values.iter().copied().cycle().take(n).collect();
    all.shuffle(random);
    all
}

/// Where objects are in a frame, or vertices.
#[derive(Clone, Debug, PartialEq)]
enum Moved {
    Poses(Vec<Pose>),
    Positions(Vec<[f32; 3]>),
}

/// Objects over some frames.
#[derive(Debug)]
pub struct Case {
    /// Its number, scene and order.
    pub name: String,
    /// What is asked about.
    pub objects: Objects,
    /// What is asked.
    pub verb: Verb,
    frames: Vec<Moved>,
}

impl Recipe {
    /// What tables call the case.
    #[must_use]
    pub fn name(&self) -> String {
        let order = match self.order {
            Order::Coherent => "",
            Order::Still => ", still",
            Order::Alternating => ", alternating",
            Order::Teleporting => ", teleporting",
        };
        format!("{} {}{order}", self.number + 1, self.scene)
    }

    /// Builds the models and all frames.
    ///
    /// # Errors
    /// If the scene cannot be made.
    pub fn build(&self) -> Result<Case> {
        let random = &mut seeded(self.seed);
        let scene = Scene::by_name(self.scene, Some(self.size))?;
        let frames = self.frames.min(self.of_all_frames / scene.triangles()).max(1);
        let (start, period) = (random.random_range(0..scene.frames()), random.random_range(3..12));
        let frame = |number: usize| match self.order {
            Order::Coherent => start + number,
            Order::Still => start,
            Order::Alternating if number / period % 2 == 1 => number,
            Order::Alternating => scene.frames() / 2 + number,
            Order::Teleporting => random.random_range(0..scene.frames()),
        };
        let moved = |frame: usize| {
            let (mut rows, mut positions) = (Vec::new(), Vec::new());
            if scene.kind() == Kind::SelfMesh {
                scene.positions(frame, &mut positions);
                return Moved::Positions(positions);
            }
            scene.poses(frame, &mut rows);
            Moved::Poses(rows.into_iter().map(Pose::new).collect())
        };
        Ok(Case {
            name: self.name(),
            frames: (0..frames).map(frame).map(moved).collect(),
            objects: Objects::new(header(&scene, 0))?,
            verb: self.verb,
        })
    }
}

impl Case {
    /// Its objects for one play, with a model of its own where that deforms: whoever refits a shared one
    /// copies it first.
    #[must_use]
    pub fn fresh(&self) -> Objects {
        let mut objects = self.objects.clone();
        if let (Kind::SelfMesh, [model]) = (objects.kind, &mut objects.models[..]) {
            *model = Arc::new(Model::clone(model));
        }
        objects
    }

    /// The frames, in order.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = Frame<'_>> {
        self.frames.iter().map(|moved| match moved {
            Moved::Poses(poses) => Frame::Poses(poses),
            Moved::Positions(positions) => Frame::Positions(positions),
        })
    }
}

impl Verb {
    /// What tables call it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Any => "any",
            Self::Count => "count",
        }
    }

    /// Asks, and drops the answer but for its size.
    ///
    /// # Errors
    /// Those of the player.
    pub fn ask(self, player: &mut Player) -> Result<u64> {
        match self {
            Self::All => Ok(player.find()? as u64),
            Self::Any => Ok(u64::from(player.any()?)),
            Self::Count => player.count(),
        }
    }

    /// Asks for what every executor must answer alike: all pairs, as a hash, or a number. Which pair `any`
    /// finds is anyone's choice.
    ///
    /// # Errors
    /// Those of the player.
    pub fn digest(self, player: &mut Player) -> Result<u64> {
        if self != Self::All {
            return self.ask(player);
        }
        let mut hasher = DefaultHasher::new();
        player.all()?.hash(&mut hasher);
        Ok(hasher.finish())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_cases_and_covers_everything() {
        assert_eq!(recipes(7, 48, Scale::FULL), recipes(7, 48, Scale::FULL));
        assert_ne!(recipes(7, 48, Scale::FULL), recipes(8, 48, Scale::FULL));
        for recipe in recipes(7, 6, Scale::QUICK) {
            let [one, other] = [(); 2].map(|()| recipe.build().unwrap());
            assert!(one.frames == other.frames && one.frames().len() <= recipe.frames);
        }
        for seed in 0..20 {
            let all = recipes(seed, 40, Scale::FULL);
            let count =
                |is_meant: &dyn Fn(&Recipe) -> bool| all.iter().filter(|r| is_meant(r)).count();
            assert!(Scene::NAMES.iter().all(|name| count(&|r| r.scene == *name) >= 6));
            assert!(ORDERS.iter().all(|order| count(&|r| r.order == *order) >= 8));
            assert!(VERBS.iter().all(|verb| count(&|r| r.verb == *verb) >= 10));
            for decade in [3e2, 3e3, 3e4, 3e5] {
                let near = |r: &Recipe| (r.size as f64 / decade).log10().abs() < 0.5;
                assert!(count(&near) >= 7, "seed {seed}, {decade} triangles");
            }
        }
    }
}
