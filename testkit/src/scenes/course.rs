//! Random collision courses (section 5.2.4 of the paper): each frame a new pose, nothing to
//! remember from the last.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::pose::shift;
use super::scene::{Motion, Scene};
use crate::MeshData;

impl Scene {
    /// A course of `frames` random poses of `b` about `a`: every rotation equally likely, and a
    /// distance at which they overlap in part or just miss. The same `seed` gives the same course
    /// on every machine.
    pub fn course(a: MeshData, b: MeshData, frames: usize, seed: u64) -> Self {
        let (center_a, radius_a) = a.bounding_sphere();
        let (center_b, radius_b) = b.bounding_sphere();
        let a_from_b = move |frame: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            // A stream for each frame, so that any frame can be had without those before it.
            random.set_stream(frame as u64);
            let distance = random.random_range(NEAREST..FARTHEST) * (radius_a + radius_b);
            let center = center_a + direction(&mut random) * distance;
            shift(center) * rotation(&mut random) * shift(-center_b)
        };
        let motion = Motion::Pair(Box::new(a_from_b));
        Self { name: "course", meshes: vec![a, b], objects: vec![0, 1], frames, motion }
    }
}

/// Range of the distance of the centres in sums of the bounding spheres' radii.
const NEAREST: f64 = 0.15;
const FARTHEST: f64 = 0.85;

/// A direction, uniform on the sphere.
fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    let z = random.random_range(-1.0..1.0);
    let (sin, cos) = libm::sincos(random.random_range(-PI..PI));
    let r = f64::sqrt(1.0 - z * z);
    DVec3::new(r * cos, r * sin, z)
}

/// A uniform rotation, the same for the same `number` on every machine.
pub(crate) fn random_rotation(number: u64) -> DAffine3 {
    rotation(&mut ChaCha8Rng::seed_from_u64(number))
}

/// A uniform rotation (Shoemake, Graphics Gems III, 1992).
fn rotation(random: &mut ChaCha8Rng) -> DAffine3 {
    let share: f64 = random.random();
    let (sin1, cos1) = libm::sincos(TAU * random.random::<f64>());
    let (sin2, cos2) = libm::sincos(TAU * random.random::<f64>());
    let (r1, r2) = ((1.0 - share).sqrt(), share.sqrt());
    let turn = DQuat::from_xyzw(r1 * sin1, r1 * cos1, r2 * sin2, r2 * cos2);
    DAffine3::from_mat3(DMat3::from_quat(turn))
}
