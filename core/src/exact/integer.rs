//! Determinants over the integers that f32 coordinates are.

use super::{Axes, Point, coordinate, int896::Wide};

/// Exact sign of det(b − a, c − a, d − a).
#[cold]
#[inline(never)]
pub(super) fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> i32 {
    if is_flat([a, b, c, d], [0, 1, 2]) {
        return 0;
    }
    let axes = Axis::all([a, b, c, d]);
    match small(&axes) {
        // 3 bits for the sum of six products, 1 for the sign.
        Some(([x, y, z], bits)) if bits + 4 <= 128 => det3(x, y, z).signum() as i32,
        _ => wide_det3(&axes).sign(),
    }
}

/// Whether two points are equal, or all have one coordinate in common: nearly every zero of bodies that lie
/// flush or share corners, for which integers would take ten times as long.
#[inline]
fn is_flat<const D: usize, const N: usize>(points: [&Point; N], axes: [usize; D]) -> bool {
    let [first, ..] = points.as_slice() else { return true };
    let level = |k: usize| points.iter().all(|p| coordinate(p, k) == coordinate(first, k));
    if axes.iter().any(|&k| level(k)) {
        return true;
    }
    let equal = |p: &Point, q: &Point| axes.iter().all(|&k| coordinate(p, k) == coordinate(q, k));
    let mut rest = points.as_slice();
    while let [first, others @ ..] = rest {
        if others.iter().any(|p| equal(p, first)) {
            return true;
        }
        rest = others;
    }
    false
}

/// Exact sign of det(b − a, c − a) in two of the coordinates.
#[cold]
#[inline(never)]
pub(super) fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> i32 {
    if is_flat([a, b, c], axes) {
        return 0;
    }
    let axes = axes.map(|k| Axis::new([a, b, c].map(|p| coordinate(p, k))));
    match small(&axes) {
        Some(([x, y], bits)) if bits + 2 <= 128 => {
            let [x, y] = [x, y].map(|d| d.map(i128::from));
            (x[1] * y[2] - x[2] * y[1]).signum() as i32
        }
        _ => {
            let [x, y] = axes.map(|axis| axis.wide_differences());
            x[1].mul(y[2]).sub(x[2].mul(y[1])).sign()
        }
    }
}

/// det(b − a, c − a, p − a) for two points `p`, divided by one common power of two: each within a
/// relative 2^-52, zero only if it is zero. Their ratio is then good to 2^-51 however nearly
/// parallel the planes are.
#[cold]
#[inline(never)]
pub(crate) fn determinants(t: &crate::Triangle, points: [&Point; 2]) -> [f64; 2] {
    let [p, q] = points;
    let axes = Axis::all([&t[0], &t[1], &t[2], p, q]);
    let [x, y, z] = axes.map(|axis| axis.wide_differences());
    let first = |[a, b, c, p, _]: [Wide; 5]| [a, b, c, p];
    let second = |[a, b, c, _, q]: [Wide; 5]| [a, b, c, q];
    let both = [
        wide_terms(&first(x), &first(y), &first(z)),
        wide_terms(&second(x), &second(y), &second(z)),
    ];
    let scale = both[0].bits().max(both[1].bits()) as i32;
    both.map(|d| d.to_f64(scale))
}

/// One coordinate of N points on its lattice: point i is at `significand[i] · 2^shift[i]` steps.
struct Axis<const N: usize> {
    significand: [i64; N],
    shift: [u32; N],
}

impl<const N: usize> Axis<N> {
    fn all(points: [&Point; N]) -> [Self; 3] {
        [
            Self::new(points.map(|p| p[0])),
            Self::new(points.map(|p| p[1])),
            Self::new(points.map(|p| p[2])),
        ]
    }

    fn new(values: [f32; N]) -> Self {
        let parts = values.map(odd_significand);
        let finest = parts.iter().filter(|p| p.0 != 0).map(|p| p.1).min().unwrap_or(0);
        Self {
            significand: parts.map(|p| p.0),
            shift: parts.map(|p| if p.0 == 0 { 0 } else { (p.1 - finest) as u32 }),
        }
    }

    /// Differences from point 0, if the positions fit in 62 bits.
    fn differences(&self) -> Option<[i64; N]> {
        // A significand has at most 24 bits.
        if self.shift.iter().any(|&s| s > 38) {
            return None;
        }
        let mut out = self.significand;
        for (position, shift) in out.iter_mut().zip(self.shift) {
            *position <<= shift & 63;
        }
        let first = out[0];
        Some(out.map(|position| position - first))
    }

    fn wide_differences(&self) -> [Wide; N] {
        let first = Wide::new(self.significand[0], self.shift[0]);
        let mut out = [first; N];
        for ((out, significand), shift) in out.iter_mut().zip(self.significand).zip(self.shift) {
            *out = Wide::new(significand, shift).sub(first);
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

/// Differences of every axis, and the bits of a product of one from each.
fn small<const D: usize, const N: usize>(axes: &[Axis<N>; D]) -> Option<([[i64; N]; D], u32)> {
    let mut out = [[0; N]; D];
    let mut bits = 0;
    for (out, axis) in out.iter_mut().zip(axes) {
        *out = axis.differences()?;
        let largest = out.iter().fold(0, |m, d| m | d.unsigned_abs());
        bits += 64 - largest.leading_zeros();
    }
    Some((out, bits))
}

fn det3(x: [i64; 4], y: [i64; 4], z: [i64; 4]) -> i128 {
    let [x, y, z] = [x, y, z].map(|d| d.map(i128::from));
    x[3] * (y[1] * z[2] - y[2] * z[1])
        + y[3] * (z[1] * x[2] - z[2] * x[1])
        + z[3] * (x[1] * y[2] - x[2] * y[1])
}

fn wide_det3(axes: &[Axis<4>; 3]) -> Wide {
    let [x, y, z] = axes;
    wide_terms(&x.wide_differences(), &y.wide_differences(), &z.wide_differences())
}

fn wide_terms(x: &[Wide; 4], y: &[Wide; 4], z: &[Wide; 4]) -> Wide {
    let minor = |p: &[Wide; 4], q: &[Wide; 4]| p[1].mul(q[2]).sub(p[2].mul(q[1]));
    let terms = [(x[3], minor(y, z)), (y[3], minor(z, x)), (z[3], minor(x, y))];
    terms.map(|(w, minor)| w.mul(minor)).into_iter().fold(x[0], Wide::add)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((state >> 20) as f32 - 2048.0) / [1.0, 3.0, 1024.0][(state >> 8) as usize % 3]
        };
        for _ in 0..if cfg!(miri) { 5 } else { 20_000 } {
            let p: [Point; 4] = core::array::from_fn(|_| core::array::from_fn(|_| next()));
            let axes = [0, 1, 2].map(|k| Axis::new(p.map(|p| p[k])));
            let sign = orient3d(&p[0], &p[1], &p[2], &p[3]);
            assert_eq!(wide_det3(&axes).sign(), sign);
            let t = [p[0], p[1], p[2]];
            let [d, e] = determinants(&t, [&p[3], &p[0]]);
            assert_eq!((d > 0.0) as i32 - (d < 0.0) as i32, sign);
            assert_eq!(e, 0.0);
        }
    }
}
