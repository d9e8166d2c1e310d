//! Exact signs of orientation determinants of f64 points.
//!
//! # Stages
//! 1. f64 with an error bound, as in `filter64`. Differences of f64 are rounded, which that bound counts, and products
//!    may underflow, which it has to add.
//! 2. Equal coordinates and equal points.
//! 3. Where the coordinates along each axis are multiples of a power of two and below 2^60 of it: minors in `i128`, and
//!    the sum of their products with the third axis in two words.
//! 4. Integers of as many limbs as the coordinates need, up to those of any f64 below [`LIMIT`].
//!
//! Expansions as Shewchuk's would need exponents from −142 on and fail silently below; integers have no such limit.

use super::wide::Wide;
use glam::DVec3;

/// A point in space, in f64.
pub(crate) type Point64 = [f64; 3];

/// A point in a plane, in f64.
pub(crate) type Point2In64 = [f64; 2];

/// The largest coordinate that is decided: 2^125, the limit of poses.
pub(crate) const LIMIT: f64 = 42_535_295_865_117_307_932_921_825_928_971_026_432.0;

/// 2^-940: differences are below 2^126, so that the underflow of the six products costs a determinant
/// 6 · 2^-1075 · 2^126 < 2^-946 at most; the bound loses as much by its own, and the last products less.
pub(crate) const UNDERFLOW_3D: f64 = f64::from_bits((1023 - 940) << 52);

/// 2^-1070: two products lose 2^-1075 each, and the bound as much.
pub(crate) const UNDERFLOW_2D: f64 = f64::from_bits(1 << 4);

/// The exact sides of the plane through three points on which several points lie: the signs of
/// det(b − a, c − a, d − a). Coordinates must be at most [`LIMIT`].
#[inline]
pub(crate) fn sides64<const N: usize>(plane: [&Point64; 3], points: [&Point64; N]) -> [i32; N] {
    let mut sides = filtered_sides(plane, points);
    for (side, point) in sides.iter_mut().zip(points) {
        if *side == 0 {
            *side = exact_side(plane, point);
        }
    }
    sides
}

/// The exact turn of three points. Coordinates must be at most [`LIMIT`].
#[inline]
pub(crate) fn turn64(a: &Point2In64, b: &Point2In64, c: &Point2In64) -> i32 {
    let turn = filtered_turn(a, b, c);
    if turn == 0 { exact_turn([a, b, c]) } else { turn }
}

/// Signs that f64 certifies, and 0 for the rest.
#[inline]
pub(super) fn filtered_sides<const N: usize>(
    [a, b, c]: [&Point64; 3],
    points: [&Point64; N],
) -> [i32; N] {
    let first = DVec3::from_array(*a);
    let (u, v) = (DVec3::from_array(*b) - first, DVec3::from_array(*c) - first);
    let normal = u.cross(v);
    let mut extent = u.abs().max(v.abs());
    let mut w = [DVec3::ZERO; N];
    for i in 0..N {
        w[i] = DVec3::from_array(*points[i]) - first;
        extent = extent.max(w[i].abs());
    }
    // The extents first: the constant times a small extent could underflow, and the bound with it, beside a large one.
    let bound = extent.x * extent.y * extent.z * super::filter64::ERROR_3D + UNDERFLOW_3D;
    let mut signs = [0; N];
    for i in 0..N {
        signs[i] = certified_sign(normal.dot(w[i]), bound);
    }
    signs
}

/// The turn of three points as far as f64 certifies it, else 0.
#[inline]
pub(super) fn filtered_turn(a: &Point2In64, b: &Point2In64, c: &Point2In64) -> i32 {
    let (ux, uy, vx, vy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let extents = ux.abs().max(vx.abs()) * uy.abs().max(vy.abs());
    certified_sign(ux * vy - uy * vx, extents * super::filter64::ERROR_2D + UNDERFLOW_2D)
}

#[inline]
fn certified_sign(determinant: f64, bound: f64) -> i32 {
    i32::from(determinant > bound) - i32::from(determinant < -bound)
}

#[cold]
#[inline(never)]
fn exact_side([a, b, c]: [&Point64; 3], d: &Point64) -> i32 {
    let points = [a, b, c, d];
    let axes = by_axis(points);
    if is_degenerate(&axes) {
        return 0;
    }
    let axes = axes.map(Axis::new);
    if let [Some(x), Some(y), Some(z)] = axes.each_ref().map(Axis::narrow) {
        return narrow_side([x, y, z]);
    }
    // A product of one difference of each axis, and 3 bits for the sum of six.
    let bits: u32 = axes.iter().map(Axis::difference_bits).sum();
    if bits + 3 <= 8 * u64::BITS { wide_side::<8>(&axes) } else { wide_side::<57>(&axes) }
}

#[cold]
#[inline(never)]
fn exact_turn(points: [&Point2In64; 3]) -> i32 {
    let axes = [points.map(|p| p[0]), points.map(|p| p[1])];
    if is_degenerate(&axes) {
        return 0;
    }
    let axes = axes.map(Axis::new);
    if let [Some(x), Some(y)] = axes.each_ref().map(Axis::narrow) {
        // Below 2^122 each.
        return (product(x[1], y[2]) - product(x[2], y[1])).signum() as i32;
    }
    let bits: u32 = axes.iter().map(Axis::difference_bits).sum();
    if bits + 3 <= 8 * u64::BITS { wide_turn::<8>(&axes) } else { wide_turn::<38>(&axes) }
}

/// The normal of a triangle up to a positive factor, each component within 2^-49 of the largest; zero if and only if the
/// triangle is degenerate.
#[cold]
#[inline(never)]
pub(super) fn normal([a, b, c]: [&Point64; 3]) -> DVec3 {
    // In one unit, so that components compare.
    let finest = [a, b, c].into_iter().flatten().filter_map(finest_bit).min().unwrap_or(0);
    let axis = |coordinates| Axis::in_units(coordinates, finest).differences::<38>();
    let [x, y, z] = by_axis([a, b, c]).map(axis);
    let minor = |p: &[Wide<38>; 3], q: &[Wide<38>; 3]| p[1] * q[2] - p[2] * q[1];
    let minors = [minor(&y, &z), minor(&z, &x), minor(&x, &y)];
    let limbs = minors.each_ref().map(Wide::len).into_iter().max().unwrap_or(0);
    DVec3::from_array(minors.map(|minor| minor.as_f64(limbs)))
}

/// d / (d − e) with d and e the determinants of `p` and `q` over a plane, which are not equal: within 2^-48.
#[cold]
#[inline(never)]
pub(super) fn orient3d_ratio([a, b, c]: [&Point64; 3], p: &Point64, q: &Point64) -> f64 {
    let axes = by_axis([a, b, c, p, q]).map(Axis::new);
    let [x, y, z] = axes.each_ref().map(Axis::differences::<57>);
    let minor = |p: &[Wide<57>; 5], q: &[Wide<57>; 5]| p[1] * q[2] - p[2] * q[1];
    let [u, v, w] = [minor(&y, &z), minor(&z, &x), minor(&x, &y)];
    let (d, e) = (x[3] * u + y[3] * v + z[3] * w, x[4] * u + y[4] * v + z[4] * w);
    let limbs = d.len().max(e.len());
    let (d, e) = (d.as_f64(limbs), e.as_f64(limbs));
    d / (d - e)
}

/// The coordinates of points along each axis.
fn by_axis<const N: usize>(points: [&Point64; N]) -> [[f64; N]; 3] {
    [points.map(|p| p[0]), points.map(|p| p[1]), points.map(|p| p[2])]
}

/// Whether two points are equal, or all agree in one coordinate: nearly every zero.
#[inline]
fn is_degenerate<const D: usize, const N: usize>(axes: &[[f64; N]; D]) -> bool {
    let equal = |i: usize, j: usize| axes.iter().all(|axis| axis[i] == axis[j]);
    axes.iter().any(|axis| axis.iter().all(|x| *x == axis[0]))
        || (1..N).any(|i| (0..i).any(|j| equal(i, j)))
}

fn product(x: i64, y: i64) -> i128 {
    i128::from(x) * i128::from(y)
}

/// The sign of a determinant of differences below 2^61.
///
/// Minors are below 2^123. With a minor as h · 2^64 + l, |h| ≤ 2^59 and 0 ≤ l < 2^64, the sum of three h · d is below
/// 2^122 and that of three l · d below 2^127.
fn narrow_side([x, y, z]: [[i64; 4]; 3]) -> i32 {
    let minor = |p: &[i64; 4], q: &[i64; 4]| product(p[1], q[2]) - product(p[2], q[1]);
    let terms = [(x[3], minor(&y, &z)), (y[3], minor(&z, &x)), (z[3], minor(&x, &y))];
    let (mut high, mut low) = (0, 0);
    for (difference, minor) in terms {
        high += (minor >> 64) * i128::from(difference);
        low += i128::from(minor as u64) * i128::from(difference);
    }
    let high = high + (low >> 64);
    if high == 0 { i32::from(low as u64 != 0) } else { high.signum() as i32 }
}

#[inline(never)]
fn wide_side<const N: usize>(axes: &[Axis<4>; 3]) -> i32 {
    let [x, y, z] = axes.each_ref().map(Axis::differences::<N>);
    let minor = |p: &[Wide<N>; 4], q: &[Wide<N>; 4]| p[1] * q[2] - p[2] * q[1];
    (x[3] * minor(&y, &z) + y[3] * minor(&z, &x) + z[3] * minor(&x, &y)).sign()
}

#[inline(never)]
fn wide_turn<const N: usize>(axes: &[Axis<3>; 2]) -> i32 {
    let [x, y] = axes.each_ref().map(Axis::differences::<N>);
    (x[1] * y[2] - x[2] * y[1]).sign()
}

/// Coordinates of some points along one axis, in units of a power of two: coordinate i is
/// `significand[i] · 2^shift[i]`. For coordinates up to [`LIMIT`] it is below 2^1201, since the smallest unit is 2^-1074.
struct Axis<const N: usize> {
    significand: [i64; N],
    shift: [u32; N],
}

impl<const N: usize> Axis<N> {
    fn new(coordinates: [f64; N]) -> Self {
        debug_assert!(coordinates.iter().all(|x| x.abs() <= LIMIT), "{coordinates:?}");
        let finest = coordinates.iter().filter_map(finest_bit).min().unwrap_or(0);
        Self::in_units(coordinates, finest)
    }

    /// In units of 2^finest, of which all coordinates are multiples.
    fn in_units(coordinates: [f64; N], finest: i32) -> Self {
        let parts = coordinates.map(odd_significand);
        Self {
            significand: parts.map(|p| p.0),
            shift: parts.map(|p| if p.0 == 0 { 0 } else { (p.1 - finest) as u32 }),
        }
    }

    /// The bits of the largest magnitude.
    fn bits(&self) -> u32 {
        let bits = |(m, shift): (&i64, &u32)| u64::BITS - m.unsigned_abs().leading_zeros() + shift;
        self.significand.iter().zip(&self.shift).map(bits).max().unwrap_or(0)
    }

    /// The bits of the largest difference of two.
    fn difference_bits(&self) -> u32 {
        self.bits() + 1
    }

    /// Differences from coordinate 0, if all coordinates are below 2^60.
    fn narrow(&self) -> Option<[i64; N]> {
        if self.bits() > 60 {
            return None;
        }
        let mut out = self.significand;
        for (out, shift) in out.iter_mut().zip(self.shift) {
            *out <<= shift & 63;
        }
        let first = out[0];
        Some(out.map(|coordinate| coordinate - first))
    }

    /// Differences from coordinate 0.
    fn differences<const L: usize>(&self) -> [Wide<L>; N] {
        let first = Wide::new(self.significand[0], self.shift[0]);
        let mut out = [first; N];
        for ((out, significand), shift) in out.iter_mut().zip(self.significand).zip(self.shift) {
            *out = Wide::new(significand, shift) - first;
        }
        out
    }
}

/// The exponent of the lowest bit that is set; none in zero.
fn finest_bit(value: &f64) -> Option<i32> {
    let (significand, exponent) = odd_significand(*value);
    (significand != 0).then_some(exponent)
}

/// `value = m · 2^e` with `m` odd, or (0, 0).
fn odd_significand(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    let fraction = (bits & 0xf_ffff_ffff_ffff) as i64;
    let magnitude = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = magnitude.trailing_zeros();
    let odd = magnitude >> zeros;
    (if bits >> 63 == 0 { odd } else { -odd }, exponent.max(1) - 1075 + zeros as i32)
}

#[cfg(test)]
mod tests;
