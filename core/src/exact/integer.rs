//! Determinants in integers: exact for any coordinates that are in range.
//!
//! The coordinates of a few points along one axis are multiples of a power of two, so they are integers times that power.
//! Scaling an axis changes no sign of a determinant, hence each axis has a power of its own. Where all fit in 60 bits, as
//! those of real meshes nearly always do, minors are computed in `i128`; what does not fit goes through [`Wide`].
//!
//! Expansions as Shewchuk's need exponents from −142 on in f64 and fail silently below; integers have no such limit.

use super::wide::Wide;
use crate::scalar::Scalar;
use glam::DVec3;

/// As many limbs as determinants of finite f32 need: in units of the smallest, a difference is below 2^278 (24 bits of
/// significand, exponents 253 apart, one bit for the difference), and a sum of six products of three below 2^837.
const LIMBS: usize = 14;

/// The same for f64 up to the limit, whose differences are below 2^1201 and determinants below 2^3606.
const LIMBS_IN_F64: usize = 57;

/// The sign of det(b − a, c − a, d − a).
#[cold]
#[inline(never)]
pub(super) fn orient3d<C: Scalar>([a, b, c]: [&[C; 3]; 3], d: &[C; 3]) -> i32 {
    let coordinates = by_axis([a, b, c, d]);
    if is_degenerate(&coordinates) {
        return 0;
    }
    let axes = coordinates.map(Axis::new);
    if let [Some(x), Some(y), Some(z)] = axes.each_ref().map(Axis::narrow) {
        return narrow_sign([x, y, z]);
    }
    if fit::<C, _>(&axes) { wide_sign::<LIMBS>(&axes) } else { wide_sign::<LIMBS_IN_F64>(&axes) }
}

/// The sign of det(b − a, c − a): in space, of the corners and of a point above the first.
#[inline]
pub(super) fn orient2d<C: Scalar>(a: &[C; 2], b: &[C; 2], c: &[C; 2]) -> i32 {
    let lift = |[x, y]: [C; 2], z: f32| [x, y, C::from(z)];
    orient3d([&lift(*a, 0.0), &lift(*b, 0.0), &lift(*c, 0.0)], &lift(*a, 1.0))
}

/// d / (d − e) for the determinants d = det(b − a, c − a, p − a) and e, the same with `q`, of different signs: the parameter
/// at which p–q cuts the plane. Within a relative 2^-48, however close to 0 both are; in f64 down to 2^-768.
#[cold]
#[inline(never)]
pub(crate) fn orient3d_ratio<C: Scalar>([a, b, c]: [&[C; 3]; 3], p: &[C; 3], q: &[C; 3]) -> f64 {
    fn ratio<const L: usize>(axes: &[Axis<5>; 3]) -> f64 {
        let axes = differences(axes);
        let (d, e) = (determinant::<L, 5, 3>(&axes), determinant::<L, 5, 4>(&axes));
        let limbs = d.len().max(e.len());
        let (d, e) = (d.as_f64(limbs), e.as_f64(limbs));
        d / (d - e)
    }
    let axes = by_axis([a, b, c, p, q]).map(Axis::new);
    if fit::<C, _>(&axes) { ratio::<LIMBS>(&axes) } else { ratio::<LIMBS_IN_F64>(&axes) }
}

/// How a parameter compares with another, exactly: each is d / (d − e), for determinants d and e as [`orient3d_ratio`] has them, d ≠ e.
#[cfg(feature = "relation")]
#[cold]
#[inline(never)]
pub(crate) fn compare_orient3d_ratios(
    first: [&[f64; 3]; 5],
    second: [&[f64; 3]; 5],
) -> core::cmp::Ordering {
    /// A call of its own, so that differences do not stay on the stack.
    #[inline(never)]
    fn determinants<const L: usize>(axes: &[Axis<5>; 3]) -> [Wide<L>; 2] {
        let axes = differences(axes);
        [determinant::<L, 5, 3>(&axes), determinant::<L, 5, 4>(&axes)]
    }
    /// d0 / (d0 − e0) < d1 / (d1 − e1) where d1 · e0 < d0 · e1, if both denominators are positive.
    #[inline(never)]
    fn compare<const L: usize, const PRODUCT: usize>(axes: &[[Axis<5>; 3]; 2]) -> i32 {
        let [[d0, e0], [d1, e1]] = axes.each_ref().map(determinants::<L>);
        let signs = (d0 - e0).sign() * (d1 - e1).sign();
        difference_of_products::<L, PRODUCT>([d1, e0], [d0, e1]) * signs
    }
    #[inline(never)]
    fn difference_of_products<const L: usize, const PRODUCT: usize>(
        [p, q]: [Wide<L>; 2],
        [r, s]: [Wide<L>; 2],
    ) -> i32 {
        let product = |x: Wide<L>, y: Wide<L>| x.widened::<PRODUCT>() * y.widened();
        (product(p, q) - product(r, s)).sign()
    }
    let axes = [first, second].map(|points| by_axis(points).map(Axis::new));
    let sign = match axes.iter().all(fit::<f64, 5>) {
        true => compare::<LIMBS, { 2 * LIMBS }>(&axes),
        false => compare::<LIMBS_IN_F64, { 2 * LIMBS_IN_F64 }>(&axes),
    };
    sign.cmp(&0)
}

/// The direction of (b − a) × (c − a), each component within 2^-48 of the largest; zero if and only if the triangle is
/// degenerate.
#[cold]
#[inline(never)]
pub(crate) fn direction_of_normal<C: Scalar>(t: [&[C; 3]; 3]) -> DVec3 {
    fn direction<const L: usize>(axes: &[Axis<3>; 3]) -> DVec3 {
        let minors = normal::<L, 3>(&differences(axes));
        let limbs = minors.each_ref().map(Wide::len).into_iter().max().unwrap_or(0);
        DVec3::from_array(minors.map(|minor| minor.as_f64(limbs)))
    }
    // In one unit, so that components compare.
    let axes = by_axis(t);
    let finest = axes.as_flattened().iter().filter_map(finest_bit).min().unwrap_or(0);
    let axes = axes.map(|coordinates| Axis::in_units(coordinates, finest));
    if fit::<C, _>(&axes) { direction::<LIMBS>(&axes) } else { direction::<LIMBS_IN_F64>(&axes) }
}

/// Whether the determinants fit in [`LIMBS`], as those of f32 always do.
fn fit<C: Scalar, const N: usize>(axes: &[Axis<N>; 3]) -> bool {
    // A product of one difference of each axis, and 3 bits for the sum of six.
    let bits = axes.iter().fold(3, |bits, axis| bits + axis.bits() + 1);
    size_of::<C>() == size_of::<f32>() || bits <= LIMBS as u32 * u64::BITS
}

/// The coordinates of points along each axis.
fn by_axis<C: Scalar, const N: usize>(points: [&[C; 3]; N]) -> [[C; N]; 3] {
    [points.map(|p| p[0]), points.map(|p| p[1]), points.map(|p| p[2])]
}

/// Whether two points are equal, or all agree in one coordinate: nearly every zero of bodies that lie
/// flush or share corners, for which integers would take ten times as long.
#[inline]
fn is_degenerate<C: Scalar, const N: usize>(axes: &[[C; N]; 3]) -> bool {
    let equal = |i: usize, j: usize| axes.iter().all(|axis| axis[i] == axis[j]);
    axes.iter().any(|axis| axis.iter().all(|x| *x == axis[0]))
        || (1..N).any(|i| (0..i).any(|j| equal(i, j)))
}

/// The sign of a determinant of differences below 2^61.
///
/// Minors are below 2^123. With a minor as h · 2^64 + l, |h| ≤ 2^59 and 0 ≤ l < 2^64, the sum of three h · d is below
/// 2^122 and that of three l · d below 2^127.
fn narrow_sign([x, y, z]: [[i64; 4]; 3]) -> i32 {
    let product = |x: i64, y: i64| i128::from(x) * i128::from(y);
    let minor = |p: &[i64; 4], q: &[i64; 4]| product(p[1], q[2]) - product(p[2], q[1]);
    let terms = [(x[3], minor(&y, &z)), (y[3], minor(&z, &x)), (z[3], minor(&x, &y))];
    let (mut high, mut low) = (0, 0);
    for (difference, minor) in terms {
        high += product((minor >> 64) as i64, difference);
        low += i128::from(minor as u64) * i128::from(difference);
    }
    let high = high + (low >> 64);
    if high == 0 { i32::from(low as u64 != 0) } else { high.signum() as i32 }
}

#[inline(never)]
fn wide_sign<const L: usize>(axes: &[Axis<4>; 3]) -> i32 {
    determinant::<L, 4, 3>(&differences(axes)).sign()
}

/// Differences from coordinate 0 along each axis.
#[inline(never)]
fn differences<const L: usize, const N: usize>(axes: &[Axis<N>; 3]) -> [[Wide<L>; N]; 3] {
    let mut out = [[Wide::new(0, 0); N]; 3];
    for (out, Axis { significand, shift: shifts }) in out.iter_mut().zip(axes) {
        for (out, (&value, &shift)) in out.iter_mut().zip(significand.iter().zip(shifts)) {
            *out = Wide::new(value, shift) - Wide::new(significand[0], shifts[0]);
        }
    }
    out
}

/// The determinant of differences 1, 2 and P.
fn determinant<const L: usize, const N: usize, const P: usize>(
    differences: &[[Wide<L>; N]; 3],
) -> Wide<L> {
    let ([u, v, w], [x, y, z]) = (normal(differences), differences);
    x[P] * u + y[P] * v + z[P] * w
}

/// The components of (b − a) × (c − a), by the differences along each axis.
fn normal<const L: usize, const N: usize>([x, y, z]: &[[Wide<L>; N]; 3]) -> [Wide<L>; 3] {
    [(y, z), (z, x), (x, y)].map(|(p, q)| p[1] * q[2] - p[2] * q[1])
}

/// Coordinates of some points along one axis, in units of a power of two: coordinate i is
/// `significand[i] · 2^shift[i]`.
pub(super) struct Axis<const N: usize> {
    significand: [i64; N],
    shift: [u32; N],
}

impl<const N: usize> Axis<N> {
    pub(super) fn new<C: Scalar>(coordinates: [C; N]) -> Self {
        let finest = coordinates.iter().filter_map(finest_bit).min().unwrap_or(0);
        Self::in_units(coordinates, finest)
    }

    /// In units of 2^finest, of which all coordinates are multiples.
    pub(super) fn in_units<C: Scalar>(coordinates: [C; N], finest: i32) -> Self {
        let parts = coordinates.map(odd_significand);
        Self {
            significand: parts.map(|p| p.0),
            shift: parts.map(|p| if p.0 == 0 { 0 } else { (p.1 - finest) as u32 }),
        }
    }

    /// The bits of the largest magnitude.
    pub(super) fn bits(&self) -> u32 {
        let bits = |(m, shift): (&i64, &u32)| u64::BITS - m.unsigned_abs().leading_zeros() + shift;
        self.significand.iter().zip(&self.shift).map(bits).max().unwrap_or(0)
    }

    /// One coordinate minus another.
    pub(super) fn difference<const L: usize>(&self, from: usize, to: usize) -> Wide<L> {
        self.wide(to) - self.wide(from)
    }

    /// A coordinate.
    pub(super) fn wide<const L: usize>(&self, index: usize) -> Wide<L> {
        Wide::new(self.significand[index], self.shift[index])
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
}

/// The exponent of the lowest bit that is set; none in zero.
pub(super) fn finest_bit<C: Scalar>(value: &C) -> Option<i32> {
    let (significand, exponent) = odd_significand(*value);
    (significand != 0).then_some(exponent)
}

/// `value = m · 2^e` with `m` odd, or (0, 0).
fn odd_significand<C: Scalar>(value: C) -> (i64, i32) {
    let bits = value.into().to_bits();
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
