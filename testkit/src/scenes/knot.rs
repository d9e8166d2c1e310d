//! The bumpy torus knot: a curved, tangled body with contact all over, for lack of a free bunny.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::MeshData;

use super::mesh::closed_grid;

/// A (2, 3) torus knot within radius 1.4 whose tube is covered with bumps, in about `triangles`
/// triangles (at least 384).
pub fn torus_knot(triangles: usize) -> MeshData {
    let around = ((triangles as f64 / (2.0 * LENGTH_TO_GIRTH)).sqrt().round() as usize).max(6);
    let along = (triangles / (2 * around)).max(32);
    closed_grid(along, around, |i, j| {
        surface(TAU * i as f64 / along as f64, TAU * j as f64 / around as f64)
    })
}

/// Vertices along the knot for one around it, which makes the triangles about equilateral.
const LENGTH_TO_GIRTH: f64 = 10.0;
/// Tube radius, and what share of it the bumps add or take away.
const TUBE: f64 = 0.24;
const BUMP: f64 = 0.12;

/// The point at angle `u` along the knot and `v` around the tube.
fn surface(u: f64, v: f64) -> DVec3 {
    let (center, tangent) = curve(u);
    // The frame comes from the axis of the torus, which the tangent never meets, so it closes.
    let normal = tangent.cross(DVec3::Z).normalize();
    let binormal = tangent.cross(normal);
    let bump = libm::sin(36.0 * u + 2.0 * v) * libm::cos(4.0 * v - 6.0 * u);
    let (sin, cos) = libm::sincos(v);
    center + (normal * cos + binormal * sin) * (TUBE * (1.0 + BUMP * bump))
}

/// A point of the knot's centre line and the unit tangent there.
fn curve(u: f64) -> (DVec3, DVec3) {
    let (sin2, cos2) = libm::sincos(2.0 * u);
    let (sin3, cos3) = libm::sincos(3.0 * u);
    let (r, dr) = (0.75 + 0.35 * cos3, -1.05 * sin3);
    let tangent = DVec3::new(dr * cos2 - 2.0 * r * sin2, dr * sin2 + 2.0 * r * cos2, 1.35 * cos3);
    (DVec3::new(r * cos2, r * sin2, 0.45 * sin3), tangent.normalize())
}
