//! Möller 1997: the two intervals in which the triangles cut the line common to their planes.
//!
//! Distances to the other's plane that are smaller than ε count as zero, as the paper advises; they are
//! not normalised, so ε has the unit of a volume. Coplanar triangles are projected to the axis plane
//! in which they are largest, and their edges and corners are tried there.

use glam::{Vec2, Vec3};
use pfront::pfront_core::Triangle;

pub(super) fn meet(v: &Triangle, u: &Triangle, epsilon: f32) -> bool {
    let [v, u] = [v, u].map(|t| t.map(Vec3::from_array));
    // The plane n · x + d = 0, and distances to it.
    let normal = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]);
    let distances = |t: &[Vec3; 3], normal: Vec3, on: Vec3| {
        let d = -normal.dot(on);
        t.map(|p| Some(normal.dot(p) + d).filter(|x| x.abs() >= epsilon).unwrap_or(0.0))
    };
    let apart = |d: &[f32; 3]| d[0] * d[1] > 0.0 && d[0] * d[2] > 0.0;
    let normal_v = normal(&v);
    let du = distances(&u, normal_v, v[0]);
    if apart(&du) {
        return false;
    }
    let normal_u = normal(&u);
    let dv = distances(&v, normal_u, u[0]);
    if apart(&dv) {
        return false;
    }
    // The common line along its largest coordinate.
    let axis = largest(normal_v.cross(normal_u));
    let along = |t: &[Vec3; 3]| t.map(|p| p[axis]);
    match (interval(along(&v), dv), interval(along(&u), du)) {
        (Some(p), Some(q)) => p[0] <= q[1] && q[0] <= p[1],
        _ => coplanar(&v, &u, normal_v),
    }
}

fn largest(v: Vec3) -> usize {
    let [x, y, z] = v.abs().to_array();
    if x >= y && x >= z { 0 } else { if y >= z { 1 } else { 2 } }
}

/// The interval of the line that a triangle covers, by the places of its corners along it and their distances
/// from the other plane; `None` if all these are zero.
fn interval(p: [f32; 3], d: [f32; 3]) -> Option<[f32; 2]> {
    // The corner that is alone on its side.
    let alone = if d[0] * d[1] > 0.0 {
        2
    } else if d[0] * d[2] > 0.0 {
        1
    } else if d[1] * d[2] > 0.0 || d[0] != 0.0 {
        0
    } else if d[1] != 0.0 {
        1
    } else if d[2] != 0.0 {
        2
    } else {
        return None;
    };
    let cut = |other: usize| p[alone] + (p[other] - p[alone]) * d[alone] / (d[alone] - d[other]);
    let [s, t] = [cut((alone + 1) % 3), cut((alone + 2) % 3)];
    Some([s.min(t), s.max(t)])
}

fn coplanar(v: &[Vec3; 3], u: &[Vec3; 3], normal: Vec3) -> bool {
    let axis = largest(normal);
    let flat = |p: Vec3| Vec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    let [v, u] = [v, u].map(|t| t.map(flat));
    let edges = |t: &[Vec2; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(&v).iter().any(|e| edges(&u).iter().any(|f| edges_meet(*e, *f)))
        || contains(&u, v[0])
        || contains(&v, u[0])
}

/// Whether two segments in the plane meet, if they are not parallel (after Antonio, *Graphics Gems III*).
fn edges_meet([p, q]: [Vec2; 2], [r, s]: [Vec2; 2]) -> bool {
    let (along, across, between) = (q - p, r - s, p - r);
    let f = along.y * across.x - along.x * across.y;
    let d = across.y * between.x - across.x * between.y;
    let e = along.x * between.y - along.y * between.x;
    let within = |x: f32| if f > 0.0 { (0.0..=f).contains(&x) } else { (f..=0.0).contains(&x) };
    f != 0.0 && within(d) && within(e)
}

fn contains(t: &[Vec2; 3], p: Vec2) -> bool {
    let side = |i: usize| (t[(i + 1) % 3] - t[i]).perp_dot(p - t[i]);
    let sides = [side(0), side(1), side(2)];
    sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0)
}
