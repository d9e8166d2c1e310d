//! Signs that f64 certifies.
//!
//! # The bound
//! Let u = 2^-53. Each of the six products of three differences carries at most 1 rounding for each
//! difference, 2 for its multiplications, 1 for the subtraction in the cross product and 2 for the final
//! sum: its relative error is below (1+u)^8 − 1 < 8.01u. A product is at most mx·my·mz, the largest absolute
//! differences per axis, so the determinant is off by less than 6 · 8.01u · mx·my·mz < 5.34e-15 · mx·my·mz.
//! Likewise in the plane: 2 products, each within (1+u)^4 − 1 < 4.01u, give 8.91e-16 · mx·my. The constants
//! have room for the roundings of the bounds themselves. Differences of finite f32 can neither overflow nor
//! underflow f64 here (2^-447 … 2^387).

use super::{Orientation, Point, Point2};
use glam::{DVec3, Vec3};

/// Bound of the error of a determinant of three differences, for extents of 1.
pub(crate) const ERROR_3D: f64 = 5.4e-15;
/// The same for two differences.
pub(crate) const ERROR_2D: f64 = 9.0e-16;

/// Signs that f64 certifies, and `None` for the rest.
pub(crate) enum CertifiedF64 {}

impl Orientation for CertifiedF64 {
    #[inline]
    fn orient3d<const N: usize>(plane: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]> {
        let signs = orient3d(plane, points);
        if signs.contains(&0) { None } else { Some(signs) }
    }
}

/// Signs of several points over one plane, 0 where f64 certifies none.
#[inline]
pub(super) fn orient3d<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> [i32; N] {
    let (u, v) = (difference(b, a), difference(c, a));
    let normal = u.cross(v);
    let mut extent = larger(u.abs(), v.abs());
    // Loops over indices, since `map` of an array goes through memory.
    let mut w = [DVec3::ZERO; N];
    for i in 0..N {
        w[i] = difference(points[i], a);
        extent = larger(extent, w[i].abs());
    }
    let bound = ERROR_3D * extent.x * extent.y * extent.z;
    let mut signs = [0; N];
    for i in 0..N {
        signs[i] = certified_sign(normal.dot(w[i]), bound);
    }
    signs
}

/// The sign of the turn of three points, 0 where f64 does not certify it.
#[inline]
pub(super) fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> i32 {
    let edge = |p: &Point2, k: usize| f64::from(p[k]) - f64::from(a[k]);
    let (ux, uy, vx, vy) = (edge(b, 0), edge(b, 1), edge(c, 0), edge(c, 1));
    let larger = |u: f64, v: f64| if u > v { u } else { v };
    let bound = ERROR_2D * larger(ux.abs(), vx.abs()) * larger(uy.abs(), vy.abs());
    certified_sign(ux * vy - uy * vx, bound)
}

#[inline]
fn certified_sign(determinant: f64, bound: f64) -> i32 {
    i32::from(determinant > bound) - i32::from(determinant < -bound)
}

/// p − q.
#[inline]
pub(crate) fn difference(p: &Point, q: &Point) -> DVec3 {
    Vec3::from_array(*p).as_dvec3() - Vec3::from_array(*q).as_dvec3()
}

/// The larger of each coordinate, without `f64::max`'s care for NaN, which cannot occur here: one
/// instruction each.
#[inline]
fn larger(u: DVec3, v: DVec3) -> DVec3 {
    let pick = |x, y| if x > y { x } else { y };
    DVec3::new(pick(u.x, v.x), pick(u.y, v.y), pick(u.z, v.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collinear points with differences of more than 53 bits: f64 makes areas of rounding errors.
    #[test]
    fn rounding_errors_are_not_certified() {
        for exponent in 20..60 {
            let scales = [-2f32.powi(-exponent), 2f32.powi(20), 1.5 * 2f32.powi(20)];
            let [a, b, c] = scales.map(|s| [s, 3.0 * s, 7.0 * s]);
            assert_eq!(orient3d([&a, &b, &c], [&[1e6, 1.0, -1e6]]), [0], "{exponent}");
            for [x, y] in [[0, 1], [1, 2], [2, 0]] {
                let [a, b, c] = [a, b, c].map(|p| [p[x], p[y]]);
                assert_eq!(orient2d(&a, &b, &c), 0, "{exponent}");
            }
        }
        // One edge much longer than the other: the bound takes the longer one.
        for exponent in 20..60 {
            let scales = [-2f32.powi(-exponent), 2f32.powi(20), 1.5 * 2f32.powi(30)];
            let [a, b, c] = scales.map(|s| [11.0 * s, 7.0 * s]);
            assert_eq!([orient2d(&a, &b, &c), orient2d(&a, &c, &b)], [0; 2], "{exponent}");
        }
        assert_eq!(orient2d(&[0.0, 0.0], &[1e-30, 0.0], &[0.0, 1e-30]), 1);
        assert_eq!(orient2d(&[0.0, 0.0], &[0.0, 1e30], &[1e30, 0.0]), -1);
    }
}
