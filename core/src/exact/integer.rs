//! Determinants in integers: exact for any finite f32.
//!
//! The coordinates of a few points along one axis are multiples of a power of two, so they are integers
//! times that power. Scaling an axis changes no sign of a determinant, hence each axis has a power of its
//! own. Differences of real meshes have 22 bits in the median, far inside `i128`; what does not fit goes
//! through [`Int896`].

use super::int896::Int896;
use super::{Point, Point2};
use core::ops::{Add, Mul, Sub};

/// The sign of det(b − a, c − a, d − a).
#[cold]
#[inline(never)]
pub(super) fn orient3d([a, b, c]: [&Point; 3], d: &Point) -> i32 {
    sign(by_axis([a, b, c, d]), det3, det3)
}

/// The sign of det(b − a, c − a).
#[cold]
#[inline(never)]
pub(super) fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> i32 {
    let points = [a, b, c];
    sign([points.map(|p| p[0]), points.map(|p| p[1])], |[x, y]| det2(&x, &y), |[x, y]| det2(&x, &y))
}

/// d/(d − e) for the determinants d = det(b − a, c − a, p − a) and e, the same with `q`, of different signs:
/// the parameter at which p–q cuts the plane. Within a relative 2^-48, however close to 0 both are.
#[cold]
#[inline(never)]
pub(crate) fn orient3d_ratio([a, b, c]: [&Point; 3], p: &Point, q: &Point) -> f64 {
    let axes = by_axis([a, b, c, p, q]).map(|axis| Axis::new(axis).differences896());
    let d = det3(axes.map(|[a, b, c, p, _]| [a, b, c, p])).to_f64();
    let e = det3(axes.map(|[a, b, c, _, q]| [a, b, c, q])).to_f64();
    d / (d - e)
}

/// (b − a) × (c − a), each component within a relative 2^-48.
#[cold]
#[inline(never)]
pub(crate) fn normal([a, b, c]: [&Point; 3]) -> [f64; 3] {
    let axes = by_axis([a, b, c]).map(Axis::new);
    let [x, y, z] = axes.map(|axis| (axis.differences896(), axis.unit()));
    [(&y, &z), (&z, &x), (&x, &y)].map(|(p, q)| det2(&p.0, &q.0).to_f64() * p.1 * q.1)
}

/// The coordinates of points along each axis.
fn by_axis<const N: usize>(points: [&Point; N]) -> [[f32; N]; 3] {
    [points.map(|p| p[0]), points.map(|p| p[1]), points.map(|p| p[2])]
}

/// The sign of a determinant by the coordinates of its points along each axis.
#[inline]
fn sign<const D: usize, const N: usize>(
    coordinates: [[f32; N]; D],
    narrow: impl Fn([[i128; N]; D]) -> i128,
    wide: impl Fn([[Int896; N]; D]) -> Int896,
) -> i32 {
    if is_degenerate(&coordinates) {
        return 0;
    }
    let axes = coordinates.map(Axis::new);
    match differences(&axes) {
        // 3 bits for the sum of six products, 1 for the sign.
        Some((d, bits)) if bits + 4 <= i128::BITS => {
            narrow(d.map(|d| d.map(i128::from))).signum() as i32
        }
        _ => wide(axes.map(|axis| axis.differences896())).sign(),
    }
}

/// Whether two points are equal, or all agree in one coordinate: nearly every zero of bodies that lie
/// flush or share corners, for which integers would take ten times as long.
#[inline]
fn is_degenerate<const D: usize, const N: usize>(coordinates: &[[f32; N]; D]) -> bool {
    let equal = |i: usize, j: usize| coordinates.iter().all(|axis| axis[i] == axis[j]);
    coordinates.iter().any(|axis| axis.iter().all(|x| *x == axis[0]))
        || (1..N).any(|i| (0..i).any(|j| equal(i, j)))
}

/// Coordinates of some points along one axis, in units of a power of two: coordinate i is
/// `significand[i] · 2^shift[i]`.
struct Axis<const N: usize> {
    significand: [i64; N],
    shift: [u32; N],
    /// The power of two is 2^exponent.
    exponent: i32,
}

impl<const N: usize> Axis<N> {
    fn new(coordinates: [f32; N]) -> Self {
        let parts = coordinates.map(odd_significand);
        let finest = parts.iter().filter(|p| p.0 != 0).map(|p| p.1).min().unwrap_or(0);
        Self {
            significand: parts.map(|p| p.0),
            shift: parts.map(|p| if p.0 == 0 { 0 } else { (p.1 - finest) as u32 }),
            exponent: finest,
        }
    }

    /// The power of two.
    fn unit(&self) -> f64 {
        f64::from_bits(((1023 + self.exponent) as u64) << 52)
    }

    /// Differences from coordinate 0, if coordinates fit in 62 bits.
    fn differences(&self) -> Option<[i64; N]> {
        // A significand has at most 24 bits.
        if self.shift.iter().any(|&shift| shift > 38) {
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
    fn differences896(&self) -> [Int896; N] {
        let first = Int896::new(self.significand[0], self.shift[0]);
        let mut out = [first; N];
        for ((out, significand), shift) in out.iter_mut().zip(self.significand).zip(self.shift) {
            *out = Int896::new(significand, shift) - first;
        }
        out
    }
}

/// `value = m · 2^e` with `m` odd, or (0, 0).
fn odd_significand(value: f32) -> (i64, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32;
    let fraction = i64::from(bits & 0x7f_ffff);
    let magnitude = if exponent == 0 { fraction } else { fraction | 1 << 23 };
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = magnitude.trailing_zeros();
    let odd = magnitude >> zeros;
    (if bits >> 31 == 0 { odd } else { -odd }, exponent.max(1) - 150 + zeros as i32)
}

/// Differences along every axis, and the bits of a product of one from each; `None` if one is too long.
fn differences<const D: usize, const N: usize>(
    axes: &[Axis<N>; D],
) -> Option<([[i64; N]; D], u32)> {
    let mut out = [[0; N]; D];
    let mut bits = 0;
    for (out, axis) in out.iter_mut().zip(axes) {
        *out = axis.differences()?;
        let largest = out.iter().fold(0, |m, d| m | d.unsigned_abs());
        bits += u64::BITS - largest.leading_zeros();
    }
    Some((out, bits))
}

/// The determinant of differences 1, 2 and 3.
fn det3<T>([x, y, z]: [[T; 4]; 3]) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    x[3] * det2(&y, &z) + y[3] * det2(&z, &x) + z[3] * det2(&x, &y)
}

/// The determinant of differences 1 and 2 along two axes.
fn det2<T, const N: usize>(x: &[T; N], y: &[T; N]) -> T
where
    T: Copy + Sub<Output = T> + Mul<Output = T>,
{
    x[1] * y[2] - x[2] * y[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::{RngExt, seeded};

    #[test]
    fn significands_rebuild_every_kind_of_f32() {
        for bits in [0, 1, 0x007f_ffff, 0x0080_0000, 0x3f80_0000, 0x7f7f_ffff, 0xc2f6_e979] {
            let value = f32::from_bits(bits);
            let (m, e) = odd_significand(value);
            let power = f64::from_bits(((1023 + e) as u64) << 52);
            assert_eq!(m as f64 * power, f64::from(value));
            assert!(m == 0 || m % 2 != 0);
        }
    }

    /// The wide stage must give what `i128` gives wherever both apply.
    #[test]
    fn stages_agree() {
        let mut rng = seeded(1);
        let mut next =
            || rng.random_range(-2048..2048) as f32 / [1.0, 3.0, 1024.0][rng.random_range(0..3)];
        for _ in 0..20_000 {
            let [a, b, c, d]: [Point; 4] = [[0.0; 3]; 4].map(|p| p.map(|_| next()));
            let axes = [0, 1, 2].map(|k| Axis::new([a[k], b[k], c[k], d[k]]).differences896());
            let sign = orient3d([&a, &b, &c], &d);
            assert_eq!(det3(axes).sign(), sign);
        }
    }

    /// 7 MAX³ in units of the least f32 fills the bits of the topmost limb below its sign.
    #[test]
    fn the_largest_determinants_keep_their_sign() {
        let (max, least) = (f32::MAX, f32::from_bits(1));
        let (a, b) = ([-max; 3], [max, least, -max]);
        let (c, d) = ([-max, max, least], [least, least, max]);
        assert_eq!([orient3d([&a, &b, &c], &d), orient3d([&a, &c, &b], &d)], [1, -1]);
    }

    #[test]
    fn ratios_and_normals_of_any_size() {
        let least = f32::from_bits(2);
        for size in [least, 2f32.powi(-100), 2f32.powi(-20), 1.0, 2f32.powi(60), 2f32.powi(120)] {
            let (o, x, y) = ([0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]);
            for (p, q) in [(1.0, -3.0), (-0.5, 1.5), (2.0, -6.0)] {
                let [p, q] = [p, q].map(|z: f32| [size, size, z * size]);
                assert_eq!(orient3d_ratio([&o, &x, &y], &p, &q), 0.25);
            }
            let area = f64::from(size) * f64::from(size);
            assert_eq!(normal([&o, &x, &y]), [0.0, 0.0, area]);
            assert_eq!(normal([&x, &[size, 0.0, size], &[size, size, size]]), [-area, 0.0, 0.0]);
            assert_eq!(normal([&x, &[-size, 0.0, 0.0], &[0.0, 0.0, size]]), [0.0, 2.0 * area, 0.0]);
        }
    }
}
