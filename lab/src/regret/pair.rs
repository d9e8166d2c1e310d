//! Cases of two rigid bodies.

use super::case::{Built, Moved};
use super::scale::{Scale, by_factors};
use super::shapes::{Shape, direction, gears, model, pose, turn};
use crate::player::Objects;
use anyhow::Result;
use glam::{DQuat, DVec3};
use pfront::Pose;
use pfront_testkit::rng::{ChaCha8Rng, RngExt};
use pfront_testkit::scenes::Kind;

/// How the second body moves about the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// Their boxes hardly overlap, if at all.
    Apart,
    /// Bounding spheres touch and part.
    Grazing,
    /// One turns inside the other.
    Nested,
    /// Twins that lie in nearly the same place: next to every triangle meets some.
    Deep,
    /// In contact, without motion.
    Still,
    /// By a ten-thousandth of its radius a frame.
    Slow,
    /// Through the first and out on the other side.
    Passing,
    /// Apart for some frames, then deep in each other for as many, and so on.
    Meeting,
    /// Anywhere, each frame anew.
    Anywhere,
    /// A worm drive.
    Meshing,
}

impl Motion {
    pub(super) const ALL: [Self; 10] = {
        use Motion::*;
        [Apart, Grazing, Nested, Deep, Still, Slow, Passing, Meeting, Anywhere, Meshing]
    };
}

/// The parameters of a case, drawn at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) motion: Motion,
    /// How large: 0 to 1, by factors.
    pub(super) size: f64,
    /// How unequal: up to one half not at all, from there to a thousandth.
    pub(super) mixture: f64,
}

impl Pair {
    /// Triangles of both.
    fn triangles(&self, scale: &Scale) -> usize {
        by_factors(2, scale.triangles, self.size)
    }

    /// Seconds that a frame takes one thread, at a guess that is seldom too low.
    pub(super) fn seconds(&self, scale: &Scale) -> f64 {
        match self.motion {
            Motion::Apart => 1e-7,
            _ => 40e-9 * self.triangles(scale) as f64,
        }
    }

    pub(super) fn build(
        &self,
        scale: &Scale,
        frames: usize,
        random: &mut ChaCha8Rng,
    ) -> Result<Built> {
        let triangles = self.triangles(scale);
        if self.motion == Motion::Meshing {
            return gears("worm-gear", triangles, frames, random);
        }
        let (share, is_small) = match self.mixture {
            ..0.5 => (0.5, false),
            mixture => (0.5 * 1e-3_f64.powf(2.0 * mixture - 1.0), random.random()),
        };
        let second = ((triangles as f64 * share).round() as usize).max(1);
        let first = (triangles - second).max(1);
        let radius = match self.motion {
            Motion::Nested => 0.9,
            _ if is_small => share.sqrt().max(0.05),
            _ => 1.0,
        };
        let shape = Shape::for_size(first, random);
        let a = model(shape.mesh(first, 1.0, random)?)?;
        let (b, other) = match self.motion {
            Motion::Deep => (a.clone(), shape),
            _ => {
                let other = Shape::for_size(second, random);
                (model(other.mesh(second, radius, random)?)?, other)
            }
        };
        let path = Path::new(self.motion, 1.0 + radius, random);
        let placed = |frame| Moved::Poses(vec![(1, path.pose(frame, frames, random))]);
        Ok(Built {
            class: format!("{:?}: {shape:?} and {other:?}", self.motion),
            objects: Objects { kind: Kind::Pair, models: vec![a, b] },
            frames: (0..frames).map(placed).collect(),
        })
    }
}

/// Where the second body is, in radii of the first.
struct Path {
    motion: Motion,
    /// Distance of the centres at which bounding spheres touch.
    touch: f64,
    direction: DVec3,
    turned: DQuat,
    axis: DVec3,
    /// Frames of a meeting.
    period: usize,
}

impl Path {
    fn new(motion: Motion, touch: f64, random: &mut ChaCha8Rng) -> Self {
        Self {
            motion,
            touch,
            direction: direction(random),
            turned: turn(random),
            axis: direction(random),
            period: random.random_range(3..12),
        }
    }

    fn pose(&self, frame: usize, frames: usize, random: &mut ChaCha8Rng) -> Pose {
        let time = frame as f64;
        let along = |distance: f64| self.direction * distance;
        let turning = |rate: f64| DQuat::from_axis_angle(self.axis, rate * time) * self.turned;
        match self.motion {
            Motion::Apart => pose(turning(0.02), along(1.2 * self.touch)),
            Motion::Grazing => {
                let distance = self.touch * (0.985 + 0.02 * (0.3 * time).sin());
                pose(turning(0.01), along(distance))
            }
            Motion::Nested => pose(turning(0.02), along(0.03)),
            Motion::Deep => pose(DQuat::IDENTITY, along(0.02 + 2e-4 * time)),
            Motion::Still => pose(self.turned, along(1.0)),
            Motion::Slow => pose(turning(1e-4), along(1.0 - 1e-4 * time)),
            Motion::Passing | Motion::Meshing => {
                let share = (time + 0.5) / frames as f64;
                let aside = self.direction.any_orthonormal_vector() * 0.1;
                pose(turning(0.02), along(self.touch * (2.0 * share - 1.0)) + aside)
            }
            Motion::Meeting => {
                let meet = frame / self.period % 2 == 1;
                let distance = if meet { 0.3 } else { 1.1 * self.touch };
                pose(turning(0.01), along(distance))
            }
            Motion::Anywhere => {
                let distance = self.touch * random.random_range(0.15..0.85);
                pose(turn(random), direction(random) * distance)
            }
        }
    }
}
