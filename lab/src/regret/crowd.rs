//! Cases of many rigid bodies in a box.

use super::case::{Built, Moved};
use super::scale::{Scale, by_factors};
use super::shapes::{Shape, direction, gears, model, pose, turn};
use crate::player::Objects;
use anyhow::Result;
use glam::{DQuat, DVec3};
use pfront::Pose;
use pfront_testkit::rng::{ChaCha8Rng, RngExt};
use pfront_testkit::scenes::Kind;
use std::f64::consts::PI;

/// How they move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// Not at all.
    Still,
    /// One of a hundred, at least one.
    Few,
    /// One of ten.
    Some,
    /// All of them, a little.
    All,
    /// Together for some frames, then spread out for as many, and so on.
    Meeting,
    /// Anywhere, each frame anew.
    Anywhere,
    /// A large one of as many triangles as all others goes through them, which do not move.
    Sweeping,
    /// A train of 17 gears.
    Meshing,
}

impl Motion {
    pub(super) const ALL: [Self; 8] = {
        use Motion::*;
        [Still, Few, Some, All, Meeting, Anywhere, Sweeping, Meshing]
    };
}

/// The parameters of a case, drawn at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crowd {
    pub(super) motion: Motion,
    /// How many: 0 to 1, by factors.
    pub(super) count: f64,
    /// How many triangles each has: likewise.
    pub(super) size: f64,
    /// How close they lie: likewise.
    pub(super) density: f64,
}

/// Mean number of bodies whose bounding spheres overlap that of one: from, to.
const NEIGHBOURS: [f64; 2] = [0.1, 8.0];
/// Different models, of which the largest is four times the smallest.
const MODELS: usize = 3;

impl Crowd {
    fn bodies(&self, scale: &Scale) -> usize {
        by_factors(2, scale.bodies, self.count)
    }

    /// Triangles of the body in the middle.
    fn triangles(&self, scale: &Scale) -> usize {
        // A body that sweeps has as many again as all others.
        let most = (scale.triangles / 2 / self.bodies(scale)).min(scale.triangles / 30);
        by_factors(1, most.max(1), self.size)
    }

    fn neighbours(&self) -> f64 {
        let [least, most] = NEIGHBOURS;
        least * (most / least).powf(self.density)
    }

    /// Seconds that a frame takes one thread, at a guess that is seldom too low.
    pub(super) fn seconds(&self, scale: &Scale) -> f64 {
        if self.motion == Motion::Meshing {
            return 20e-9 * scale.triangles.min(GEARS) as f64;
        }
        let bodies = self.bodies(scale) as f64;
        let pairs = 0.5 * bodies * self.neighbours();
        let all = 0.5e-6 * bodies + pairs * (1e-6 + 10e-9 * self.triangles(scale) as f64);
        let moving = match self.motion {
            Motion::Still | Motion::Few => 0.02,
            Motion::Some => 0.2,
            Motion::Sweeping => 0.3,
            _ => 1.0,
        };
        moving * all
    }

    pub(super) fn build(
        &self,
        scale: &Scale,
        frames: usize,
        random: &mut ChaCha8Rng,
    ) -> Result<Built> {
        if self.motion == Motion::Meshing {
            return gears("epicyclic", scale.triangles.min(GEARS), frames, random);
        }
        let (bodies, triangles) = (self.bodies(scale), self.triangles(scale));
        let mut shapes = Vec::new();
        let mut made = |triangles: usize, radius: f64, random: &mut ChaCha8Rng| {
            let shape = Shape::for_size(triangles, random);
            shapes.push(shape);
            model(shape.mesh(triangles, radius, random)?)
        };
        let mut kinds = Vec::new();
        for k in 0..MODELS {
            let share = 2_f64.powi(k as i32 - 1);
            let triangles = (share * triangles as f64).round().max(1.0) as usize;
            kinds.push(made(triangles, share.powf(0.3), random)?);
        }
        let mut models: Vec<_> =
            (0..bodies).map(|_| kinds[random.random_range(0..MODELS)].clone()).collect();
        let side = (bodies as f64 * 8.0 * 4.0 / 3.0 * PI / self.neighbours()).cbrt();
        if self.motion == Motion::Sweeping {
            let large = (bodies * triangles).min(scale.triangles / 2).max(1);
            models[0] = made(large, (0.25 * side).max(1.0), random)?;
        }
        let mut places = Places::new(bodies, side, random);
        let frames =
            (0..frames).map(|frame| Moved::Poses(self.moves(frame, frames, &mut places, random)));
        Ok(Built {
            frames: frames.collect(),
            class: format!("{:?}: {shapes:?}", self.motion),
            objects: Objects { kind: Kind::Many, models },
        })
    }

    /// The bodies that move in a frame, with their poses; in the first frame all bodies are placed.
    fn moves(
        &self,
        frame: usize,
        frames: usize,
        places: &mut Places,
        random: &mut ChaCha8Rng,
    ) -> Vec<(usize, Pose)> {
        let bodies = places.all.len();
        let sweep = |frame: usize| {
            let share = (frame as f64 + 0.5) / frames as f64;
            pose(
                DQuat::from_rotation_z(0.02 * frame as f64),
                DVec3::X * places.side * (share - 0.5),
            )
        };
        let moving = match self.motion {
            _ if frame == 0 => bodies,
            Motion::Still | Motion::Meshing => 0,
            Motion::Sweeping => 1,
            Motion::Few => bodies.div_ceil(100),
            Motion::Some => bodies.div_ceil(10),
            Motion::All | Motion::Meeting | Motion::Anywhere => bodies,
        };
        let spread = match self.motion {
            Motion::Meeting if frame / places.period % 2 == 1 => 3.0,
            _ => 1.0,
        };
        let mut moves: Vec<_> = (0..moving)
            .map(|body| {
                if self.motion == Motion::Anywhere {
                    places.all[body] = Place::new(places.side, random);
                }
                (body, places.all[body].pose(frame, spread))
            })
            .collect();
        if self.motion == Motion::Sweeping {
            moves[0] = (0, sweep(frame));
        }
        moves
    }
}

/// Triangles of the train of gears, which it does not go below by much.
const GEARS: usize = 149_000;

/// Where bodies are, and how they sway about it.
struct Places {
    all: Vec<Place>,
    /// The edge of the box.
    side: f64,
    /// Frames of a meeting.
    period: usize,
}

struct Place {
    middle: DVec3,
    sway: DVec3,
    phase: f64,
    turned: DQuat,
    axis: DVec3,
}

impl Places {
    fn new(bodies: usize, side: f64, random: &mut ChaCha8Rng) -> Self {
        let all = (0..bodies).map(|_| Place::new(side, random)).collect();
        Self { all, side, period: random.random_range(3..12) }
    }
}

impl Place {
    fn new(side: f64, random: &mut ChaCha8Rng) -> Self {
        let mut along = || side * random.random_range(-0.5..0.5);
        let middle = DVec3::new(along(), along(), along());
        Self {
            middle,
            sway: 0.3 * direction(random),
            phase: random.random_range(-PI..PI),
            turned: turn(random),
            axis: direction(random),
        }
    }

    fn pose(&self, frame: usize, spread: f64) -> Pose {
        let time = frame as f64;
        let turn = DQuat::from_axis_angle(self.axis, 0.01 * time) * self.turned;
        pose(turn, spread * self.middle + self.sway * (self.phase + 0.05 * time).sin())
    }
}
