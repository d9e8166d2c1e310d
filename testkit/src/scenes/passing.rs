//! Two equal bodies of which the second turns and passes through the first: coherent motion with
//! contact that begins, grows and ends, as the paper's pair of Buddhas (Fig. 7); and many bodies that
//! circle through each other, or turn and sway side by side.

use std::f64::consts::TAU;

use glam::DVec3;

use super::course::random_rotation;
use super::knot::torus_knot;
use super::pose::{about_y, about_z, round, shift};
use super::scene::{FRAMES, Motion, Scene};
use super::sphere::icosphere;
use crate::{MeshData, Rows};

/// Two bumpy torus knots, about `triangles` triangles together.
pub(crate) fn torus_knots(triangles: usize) -> Scene {
    passing("torus-knots", torus_knot(triangles / 2))
}

/// Two icospheres, about `triangles` triangles together.
pub(crate) fn spheres(triangles: usize) -> Scene {
    passing("spheres", icosphere(triangles / 2))
}

/// Bodies of a swarm.
const BODIES: usize = 17;

/// Icospheres and torus knots in turn on three rings, of which the middle one turns the other way:
/// about `triangles` triangles of all.
pub(crate) fn swarm(triangles: usize) -> Scene {
    let each = triangles / BODIES;
    let poses = |frame: usize, out: &mut Vec<Rows>| {
        let time = frame as f64 / FRAMES as f64;
        out.clear();
        out.extend((0..BODIES).map(|body| {
            let (share, ring) = (body as f64 / BODIES as f64, (body % 3) as f64);
            let turned = if body % 3 == 1 { -time } else { time };
            let wave = 0.4 * libm::sin(TAU * (3.0 * share + time));
            let place = shift(DVec3::new(4.0 + 1.2 * ring, 0.0, wave));
            round(about_z(TAU * (share + turned)) * place * about_y(TAU * time * (1.0 + ring)))
        }));
    };
    Scene {
        name: "swarm",
        meshes: vec![icosphere(each), torus_knot(each)],
        objects: (0..BODIES).map(|body| body % 2).collect(),
        frames: FRAMES,
        motion: Motion::Many(Box::new(poses)),
    }
}

/// Triangles of a body of a crowd, about.
const OF_A_BODY: usize = 1600;
/// Distance of neighbours in a crowd, whose radii are 1.4 and 1.
const GAP: f64 = 2.03;

/// Bodies in layers of 8 × 8, torus knots and icospheres in turn, each with a mesh and a random orientation of its own, that turn and
/// sway among their neighbours: about `triangles` triangles of all.
pub(crate) fn crowd(triangles: usize) -> Scene {
    let bodies = triangles.div_ceil(OF_A_BODY).max(1);
    let shapes = [torus_knot(OF_A_BODY), icosphere(OF_A_BODY)];
    let poses = move |frame: usize, out: &mut Vec<Rows>| {
        out.clear();
        out.extend((0..bodies).map(|body| {
            let time = 0.03 * frame as f64 + body as f64;
            let place = DVec3::new((body % 8) as f64, (body / 8 % 8) as f64, (body / 64) as f64);
            let sway = DVec3::new(0.0, 1.0, 2.0).map(|k| 0.1 * libm::sin(2.0 * time + k));
            round(shift(GAP * place + sway) * about_z(time) * random_rotation(body as u64))
        }));
    };
    Scene {
        name: "crowd",
        meshes: (0..bodies).map(|body| shapes[body % 2].clone()).collect(),
        objects: (0..bodies).collect(),
        frames: FRAMES,
        motion: Motion::Many(Box::new(poses)),
    }
}

/// The second copy of `mesh` travels along x, past the first a little off centre.
fn passing(name: &'static str, mesh: MeshData) -> Scene {
    let (_, radius) = mesh.bounding_sphere();
    let a_from_b = move |frame: usize| {
        let time = (frame as f64 + 0.5) / FRAMES as f64;
        let offset = DVec3::new(4.0 * time - 2.0, 0.11, 0.07) * radius;
        shift(offset) * about_z(0.3 * TAU * time + 0.4) * about_y(0.2 * TAU * time + 0.2)
    };
    Scene {
        name,
        meshes: vec![mesh],
        objects: vec![0, 0],
        frames: FRAMES,
        motion: Motion::Pair(Box::new(a_from_b)),
    }
}
