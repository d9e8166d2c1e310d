//! Signs of determinants of f32 points: the only arithmetic an answer depends on.
//!
//! Each predicate runs through up to four stages, and the first that is sure of the sign ends it. Exact
//! tests of triangles that share no vertex go through f32 before (`sure`), which knows nearly all.
//!
//! 1. a determinant in f64 with a semi-static error bound (below), which settles almost everything; not on
//!    bare ARM, which would compute f64 by integers too;
//! 2. zero where two points are equal or all have a coordinate in common;
//! 3. the determinant in `i128`, over the integers that the coordinates are on their common
//!    power-of-two lattice, when it fits;
//! 4. the same in 896-bit integers, which hold every determinant of finite f32 coordinates.
//!
//! Stages 2 to 4 are exact, use a few hundred bytes of stack and never fail. Scaling one axis by a
//! power of two does not change a sign, so every axis has a lattice of its own; real meshes then
//! need 22 bits a coordinate difference in the median (`accuracy.md`), far inside `i128`.
//!
//! # The bound of the filter
//! Let u = 2^-53. A difference of two f32 is rounded once in f64, so each of the six products of
//! three differences carries at most 1 rounding for each difference, 2 for its multiplications, 1
//! for the subtraction in the cross product and 2 for the final sum: its relative error is below
//! (1+u)^8 − 1 < 8.01u. A product is at most mx·my·mz, the largest absolute differences an axis, so
//! the determinant is off by less than 6 · 8.01u · mx·my·mz < 5.34e-15 · mx·my·mz. The constant
//! below adds room for the roundings of the bound itself. Finite f32 can neither overflow nor
//! underflow f64 here (2^-447 … 2^390). The bound has the form of Shewchuk's (Adaptive Precision
//! Floating-Point Arithmetic, 1997) with the maxima of Devillers & Pion in place of the permanent.
//! Likewise in 2D: 2 products, each within (1+u)^4 − 1 < 4.01u, give 8.9e-16 · mx·my.

pub(crate) mod environment;
pub(crate) mod filter32;
mod int896;
mod integer;
mod kernel;

pub(crate) use integer::determinants;
pub(crate) use kernel::{Exact, Fast, Filtered, Kernel, Undecided};

use crate::Triangle;
use glam::DVec3;

/// A point, in f32.
pub(crate) type Point = [f32; 3];

/// Two of the three coordinates: a projection along the third axis.
pub(crate) type Axes = [usize; 2];

/// The three projections.
pub(crate) const PROJECTIONS: [Axes; 3] = [[1, 2], [2, 0], [0, 1]];

/// Whether f64 comes before integers. Where it has to be computed by those anyway, it saves no time and takes
/// 2 KiB of machine code.
const FILTERS: bool = !cfg!(all(target_arch = "arm", target_os = "none"));

const BOUND_3D: f64 = 5.4e-15;
const BOUND_2D: f64 = 9.0e-16;

/// On which side of the plane through `a`, `b`, `c` the point `d` lies: the exact sign of
/// det(b − a, c − a, d − a).
///
/// 1 when a, b, c turn counter-clockwise seen from `d`'s side, −1 on the other side, 0 when the four points are
/// coplanar. Coordinates must be finite.
///
/// # Complexity
/// O(1); about 5 ns when the f64 filter decides, 50 ns in `i128`, 1 µs in wide integers.
///
/// # Examples
/// ```
/// use pfront_core::exact::orient3d;
/// let [o, x, y] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// assert_eq!(orient3d(&o, &x, &y, &[0.3, 0.3, 1e-45]), 1);
/// assert_eq!(orient3d(&o, &x, &y, &[9.0, 9.0, 0.0]), 0);
/// ```
#[inline]
#[must_use]
pub fn orient3d(a: &[f32; 3], b: &[f32; 3], c: &[f32; 3], d: &[f32; 3]) -> i32 {
    if !FILTERS {
        return integer::orient3d(a, b, c, d);
    }
    match filter_orient3d(a, b, c, d) {
        0 => integer::orient3d(a, b, c, d),
        sign => sign,
    }
}

/// The exact turn of `a`, `b`, `c` seen along the axis that `axes` leaves out: the sign of
/// det(b − a, c − a) in the coordinates `axes`. 1 is counter-clockwise, 0 collinear in projection.
///
/// An element of `axes` above 2 counts as 2.
///
/// # Examples
/// ```
/// use pfront_core::exact::orient2d;
/// assert_eq!(orient2d([0, 1], &[0.0; 3], &[1.0, 0.0, 7.0], &[0.0, 1.0, -3.0]), 1);
/// ```
#[inline]
#[must_use]
pub fn orient2d(axes: [usize; 2], a: &[f32; 3], b: &[f32; 3], c: &[f32; 3]) -> i32 {
    if !FILTERS {
        return integer::orient2d(axes, a, b, c);
    }
    match filter_orient2d(axes, a, b, c) {
        0 => integer::orient2d(axes, a, b, c),
        sign => sign,
    }
}

/// The sign if the f64 filter is sure of it, else 0.
#[inline]
pub(crate) fn filter_orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> i32 {
    filter_sides(&[*a, *b, *c], [d])[0]
}

/// [`filter_orient3d`] of one triangle against several points, which share its normal and bound.
#[inline]
pub(crate) fn filter_sides<const N: usize>(t: &Triangle, points: [&Point; N]) -> [i32; N] {
    let (u, v) = (difference(&t[1], &t[0]), difference(&t[2], &t[0]));
    let normal = u.cross(v);
    let mut extent = larger(u.abs(), v.abs());
    let mut w = [DVec3::ZERO; N];
    for i in 0..N {
        w[i] = difference(points[i], &t[0]);
        extent = larger(extent, w[i].abs());
    }
    let bound = BOUND_3D * extent.x * extent.y * extent.z;
    let mut sides = [0; N];
    for i in 0..N {
        sides[i] = certain(normal.dot(w[i]), bound);
    }
    sides
}

/// Likewise for [`orient2d`].
#[inline]
pub(crate) fn filter_orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> i32 {
    let edge = |p: &Point, k: usize| f64::from(coordinate(p, k)) - f64::from(coordinate(a, k));
    let [x, y] = axes;
    let ([ux, uy], [vx, vy]) = ([edge(b, x), edge(b, y)], [edge(c, x), edge(c, y)]);
    let larger = |u: f64, v: f64| if u > v { u } else { v };
    let extents = [larger(ux.abs(), vx.abs()), larger(uy.abs(), vy.abs())];
    certain(ux * vy - uy * vx, BOUND_2D * extents[0] * extents[1])
}

#[inline]
fn certain(determinant: f64, bound: f64) -> i32 {
    i32::from(determinant > bound) - i32::from(determinant < -bound)
}

/// One of the coordinates.
#[inline]
pub(crate) fn coordinate(p: &Point, axis: usize) -> f32 {
    p[axis.min(2)]
}

#[inline]
pub(crate) fn difference(p: &Point, q: &Point) -> DVec3 {
    let [x, y, z] = *p;
    let [u, v, w] = *q;
    DVec3::new(
        f64::from(x) - f64::from(u),
        f64::from(y) - f64::from(v),
        f64::from(z) - f64::from(w),
    )
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

    /// Points whose determinant is known, in f32 that no f64 filter can decide.
    #[test]
    fn decides_where_f64_cannot() {
        let far = 16_777_216.0_f32;
        let a = [far, far, 0.0];
        let b = [far + 2.0, far, 0.0];
        let c = [far, far + 2.0, 0.0];
        for (z, sign) in [(f32::from_bits(1), 1), (0.0, 0), (-f32::from_bits(1), -1)] {
            assert_eq!(orient3d(&a, &b, &c, &[1.0, 1.0, z]), sign);
        }
    }

    #[test]
    fn extreme_exponents_are_exact() {
        let (big, tiny) = (f32::MAX, f32::from_bits(1));
        let a = [0.0, 0.0, 0.0];
        let b = [big, tiny, 0.0];
        let c = [-big, tiny, 0.0];
        assert_eq!(orient3d(&a, &b, &c, &[0.0, 0.0, tiny]), 1);
        assert_eq!(orient2d([0, 1], &a, &b, &c), 1);
        // (big, tiny) and (2 tiny, 0) against a third point one lattice step off their line.
        assert_eq!(orient2d([0, 1], &a, &[big, big, 0.0], &[tiny, tiny, 0.0]), 0);
        assert_eq!(orient2d([0, 1], &a, &[big, big, 0.0], &[tiny, 2.0 * tiny, 0.0]), 1);
    }

    #[test]
    fn odd_permutations_flip_the_sign() {
        let p = [[0.1, 0.2, 0.3], [0.7, 0.11, 0.13], [0.17, 0.9, 0.23], [0.29, 0.31, 0.8_f32]];
        let sign = orient3d(&p[0], &p[1], &p[2], &p[3]);
        assert_ne!(sign, 0);
        assert_eq!(orient3d(&p[1], &p[0], &p[2], &p[3]), -sign);
        assert_eq!(orient3d(&p[1], &p[2], &p[0], &p[3]), sign);
        assert_eq!(orient3d(&p[3], &p[1], &p[2], &p[0]), -sign);
    }
}
