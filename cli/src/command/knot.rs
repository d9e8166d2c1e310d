//! The body of the demonstration: a torus knot, which is curved and tangled and meets another one all over.

use glam::DVec3;
use pfront::{Error, Model};
use std::f64::consts::TAU;

/// Vertices along the knot and around its tube: twice their product are triangles.
const GRID: [usize; 2] = [600, 54];
const TUBE: f64 = 0.24;

/// A (2, 3) torus knot within radius 1.4 of `x` on the x axis.
pub(crate) fn torus_knot(x: f64) -> Result<Model, Error> {
    let [along, around] = GRID;
    let vertex = |i: usize, j: usize| (i % along * around + j % around) as u32;
    let point = |i: usize, j: usize| {
        let turn = |k: usize, count: usize| TAU * k as f64 / count as f64;
        let point = surface(turn(i, along), turn(j, around)) + DVec3::X * x;
        point.to_array().map(|x| x as f32)
    };
    let quads = (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
    let triangles = quads.clone().flat_map(|(i, j)| {
        let (near, far) = (vertex(i, j), vertex(i + 1, j + 1));
        [[near, vertex(i, j + 1), far], [near, far, vertex(i + 1, j)]]
    });
    Model::new(quads.map(|(i, j)| point(i, j)).collect(), triangles.collect())
}

/// The point at angle `u` along the knot and `v` around its tube.
fn surface(u: f64, v: f64) -> DVec3 {
    let ((sin2, cos2), (sin3, cos3)) = ((2.0 * u).sin_cos(), (3.0 * u).sin_cos());
    let (r, dr) = (0.75 + 0.35 * cos3, -1.05 * sin3);
    let middle = DVec3::new(r * cos2, r * sin2, 0.45 * sin3);
    let tangent = [dr * cos2 - 2.0 * r * sin2, dr * sin2 + 2.0 * r * cos2, 1.35 * cos3];
    // The tangent is never along the axis of the torus.
    let normal = DVec3::from_array(tangent).cross(DVec3::Z).normalize();
    let binormal = DVec3::from_array(tangent).normalize().cross(normal);
    middle + (normal * v.cos() + binormal * v.sin()) * TUBE
}
