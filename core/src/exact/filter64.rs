//! Signs that f64 certifies, of points in f32 or f64.
//!
//! # The bound
//! Let u = 2^-53. Each of the six products of three differences carries at most 1 rounding for each
//! difference, 2 for its multiplications, 1 for the subtraction in the cross product and 2 for the final
//! sum: its relative error is below (1+u)^8 − 1 < 8.01u. A product is at most mx·my·mz, the largest absolute
//! differences per axis, so the determinant is off by less than 6 · 8.01u · mx·my·mz < 5.34e-15 · mx·my·mz.
//! Likewise in the plane: 2 products, each within (1+u)^4 − 1 < 4.01u, give 8.91e-16 · mx·my. The constants
//! have room for the roundings of the bounds themselves.
//!
//! Coordinates are at most 2^128, so that nothing overflows. Products of differences of f32, 2^-149 and more, do not
//! underflow either; for those of f64, at most 2^126, [`UNDERFLOW_3D`] and [`UNDERFLOW_2D`] bound what it costs. The extents
//! are multiplied first: a small one times the constant could underflow, and the bound with it, beside a large one.

use crate::scalar::Scalar;
use glam::DVec3;

/// Bound of the error of a determinant of three differences, for extents of 1.
pub(crate) const ERROR_3D: f64 = 5.4e-15;
/// The same for two differences.
pub(crate) const ERROR_2D: f64 = 9.0e-16;

/// 2^-940: the underflow of six products of two differences costs a determinant 6 · 2^-1075 · 2^126 < 2^-946 at most; the
/// bound loses as much by its own, and the last products less.
pub(crate) const UNDERFLOW_3D: f64 = f64::from_bits((1023 - 940) << 52);
/// 2^-1070: two products lose 2^-1075 each, and the bound as much.
pub(crate) const UNDERFLOW_2D: f64 = f64::from_bits(1 << 4);

/// Signs of several points over one plane, 0 where f64 certifies none.
#[inline]
pub(super) fn orient3d<C: Scalar, const N: usize>(
    [a, b, c]: [&[C; 3]; 3],
    points: [&[C; 3]; N],
) -> [i32; N] {
    let (u, v) = (difference(b, a), difference(c, a));
    let normal = u.cross(v);
    let mut extent = larger(u.abs(), v.abs());
    // Loops over indices, since `map` of an array goes through memory.
    let mut w = [DVec3::ZERO; N];
    for i in 0..N {
        w[i] = difference(points[i], a);
        extent = larger(extent, w[i].abs());
    }
    let bound = extent.x * extent.y * extent.z * ERROR_3D + UNDERFLOW_3D;
    let mut signs = [0; N];
    for i in 0..N {
        signs[i] = certified_sign(normal.dot(w[i]), bound);
    }
    signs
}

/// The sign of the turn of three points, 0 where f64 does not certify it.
#[inline]
pub(super) fn orient2d<C: Scalar>(a: &[C; 2], b: &[C; 2], c: &[C; 2]) -> i32 {
    let edge = |p: &[C; 2], k: usize| p[k].into() - a[k].into();
    let (ux, uy, vx, vy) = (edge(b, 0), edge(b, 1), edge(c, 0), edge(c, 1));
    let larger = |u: f64, v: f64| if u > v { u } else { v };
    let extents = larger(ux.abs(), vx.abs()) * larger(uy.abs(), vy.abs());
    certified_sign(ux * vy - uy * vx, extents * ERROR_2D + UNDERFLOW_2D)
}

#[inline]
fn certified_sign(determinant: f64, bound: f64) -> i32 {
    i32::from(determinant > bound) - i32::from(determinant < -bound)
}

/// p − q, rounded at most once.
#[inline(always)]
pub(crate) fn difference<C: Scalar>(p: &[C; 3], q: &[C; 3]) -> DVec3 {
    DVec3::new(p[0].into() - q[0].into(), p[1].into() - q[1].into(), p[2].into() - q[2].into())
}

/// The larger of each coordinate, without `f64::max`'s care for NaN, which cannot occur here: one
/// instruction each.
#[inline]
pub(crate) fn larger(u: DVec3, v: DVec3) -> DVec3 {
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
