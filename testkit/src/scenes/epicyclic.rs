//! The epicyclic train (Fig. 6b of the paper): three planetary stages in a row, 17 gears.
//!
//! Each stage has a driven sun, three or four planets and a fixed ring; its carrier, which is not
//! modelled, drives the next sun. The train gears down 60 to 1.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3};

use super::gear::{SpurSteps, Teeth, spur, width_steps};
use super::mesh::scaled;
use crate::Rows;

use super::pose::{about_z, round, shift};
use super::scene::{FRAMES, Motion, Scene};
use super::tooth::Steps;

/// Triangles of all gears at the default size.
pub(crate) const TRIANGLES: usize = 149_000;

/// The train in about `triangles` triangles (at least 61,248); the first sun makes one turn in
/// [`FRAMES`] frames. Objects are, stage by stage, the sun, its planets, the ring.
pub(crate) fn scene(triangles: usize) -> Scene {
    let steps = steps(triangles);
    let mut meshes = vec![spur(RING, Teeth::Inner, HALF_WIDTH, steps)];
    let mut objects = Vec::new();
    for stage in &STAGES {
        let sun = meshes.len();
        meshes.push(spur(stage.sun, Teeth::Outer, HALF_WIDTH, steps));
        meshes.push(spur(stage.planet(), Teeth::Outer, HALF_WIDTH, steps));
        objects.push(sun);
        objects.extend((0..stage.planets).map(|_| sun + 1));
        objects.push(0);
    }
    let poses = |frame: usize, out: &mut Vec<Rows>| {
        out.clear();
        let mut sun_angle = TAU * frame as f64 / FRAMES as f64;
        for (k, stage) in STAGES.iter().enumerate() {
            let along = shift(DVec3::Z * (STAGE_DISTANCE * k as f64));
            out.extend(stage.poses(sun_angle).into_iter().map(|pose| round(along * pose)));
            sun_angle = stage.carrier_angle(sun_angle);
        }
    };
    Scene {
        name: "epicyclic",
        meshes,
        objects,
        frames: FRAMES,
        motion: Motion::Many(Box::new(poses)),
    }
}

// Lengths are in modules.
const RING: usize = 84;
const HALF_WIDTH: f64 = 2.5;
const STAGE_DISTANCE: f64 = 7.0;

/// (sun + RING) ÷ planets is whole in each, else evenly spaced planets could not all mesh; no gear
/// has fewer than 22 teeth, else they would be undercut.
const STAGES: [Stage; 3] =
    [Stage { sun: 24, planets: 3 }, Stage { sun: 36, planets: 4 }, Stage { sun: 28, planets: 4 }];

/// Teeth of the sun, and number of planets.
struct Stage {
    sun: usize,
    planets: usize,
}

impl Stage {
    /// Teeth of each planet: it spans the space between sun and ring.
    const fn planet(&self) -> usize {
        (RING - self.sun) / 2
    }

    fn teeth(&self) -> usize {
        self.sun + self.planets * self.planet() + RING
    }

    /// The carrier's angle, by which the planets travel round the sun.
    fn carrier_angle(&self, sun_angle: f64) -> f64 {
        sun_angle * self.sun as f64 / (self.sun + RING) as f64
    }

    /// World from each gear: the sun, the planets, the ring.
    fn poses(&self, sun_angle: f64) -> Vec<DAffine3> {
        let [sun, planet, ring] = [self.sun, self.planet(), RING].map(|teeth| teeth as f64);
        let orbit = (sun + planet) / 2.0;
        let carrier = self.carrier_angle(sun_angle);
        let planets = (0..self.planets).map(|k| {
            let place = carrier + TAU * k as f64 / self.planets as f64;
            // A planet's tooth stands where the sun has a gap: half a tooth on, and then both roll.
            let angle = place + PI - PI / planet + (place - sun_angle) * sun / planet;
            let (sin, cos) = libm::sincos(place);
            shift(DVec3::new(orbit * cos, orbit * sin, 0.0)) * about_z(angle)
        });
        let ring_angle = PI * (planet - 1.0) / ring;
        let mut poses = vec![about_z(sun_angle)];
        poses.extend(planets);
        poses.push(about_z(ring_angle));
        poses
    }
}

/// Steps that make about `triangles` triangles of the whole train.
fn steps(triangles: usize) -> SpurSteps {
    let density = (triangles as f64 / TRIANGLES as f64).sqrt();
    let pitch = Steps {
        floor: scaled(2, density, 1),
        flank: scaled(3, density, 2),
        top: scaled(1, density, 1),
    };
    let teeth: usize = STAGES.iter().map(Stage::teeth).sum();
    SpurSteps { pitch, width: width_steps(triangles / teeth, pitch) }
}
