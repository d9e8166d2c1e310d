//! Two equal bodies of which the second turns and passes through the first: coherent motion with
//! contact that begins, grows and ends, as the paper's pair of Buddhas (Fig. 7).

use std::f64::consts::TAU;

use glam::DVec3;

use super::knot::torus_knot;
use super::pose::{about_y, about_z, shift};
use super::scene::{FRAMES, Motion, Scene};
use super::sphere::icosphere;
use crate::MeshData;

/// Two bumpy torus knots, about `triangles` triangles together.
pub(crate) fn torus_knots(triangles: usize) -> Scene {
    passing("torus-knots", torus_knot(triangles / 2))
}

/// Two icospheres, about `triangles` triangles together.
pub(crate) fn spheres(triangles: usize) -> Scene {
    passing("spheres", icosphere(triangles / 2))
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
