//! Signs that f32 is sure of: what decides nearly every triangle pair, at the price of plain f32.
//!
//! # The bound
//! As that of the f64 filter, with u = 2^-24: each of the six products of three differences carries a
//! relative error below (1+u)^8 − 1, so that the determinant is off by less than 48.06u · mx·my·mz, the
//! largest absolute differences an axis. The constant has room for the roundings of the bound. Unlike
//! there, products may underflow or overflow. With no difference above 2^40 none overflows, and underflow
//! costs less than 6 · 2^-150 · 2^40 before the last product and 4 · 2^-150 after; the bound may lose
//! 2^-110. `SLACK`, 2^-100, is far above their sum.

use super::{Axes, Kernel, Point, Undecided};
use crate::Triangle;
use glam::{Vec3A, Vec4};

pub(crate) const BOUND: f32 = 2.9e-6;
pub(crate) const SLACK: f32 = 7.888_609e-31;
/// 2^40.
pub(crate) const MOST: f32 = 1.099_511_6e12;

/// The signs f32 is sure of, and an error for the rest.
pub(crate) enum Sure {}

impl Kernel for Sure {
    type Undecided = Undecided;

    #[inline]
    fn sides<const N: usize>(t: &Triangle, points: [&Point; N]) -> Result<[i32; N], Undecided> {
        const { assert!(0 < N && N <= 4) };
        let base = Vec3A::from_array(t[0]);
        let (u, v) = (Vec3A::from_array(t[1]) - base, Vec3A::from_array(t[2]) - base);
        let (normal, extent) = (u.cross(v), u.abs().max(v.abs()));
        let w = from(&t[0], core::array::from_fn(|i| points[i.min(N - 1)]));
        let all = |v: Vec3A| [Vec4::splat(v.x), Vec4::splat(v.y), Vec4::splat(v.z)];
        let (above, below) = signs(&all(normal), &w, &all(extent));
        if above | below != 0xf {
            return Err(Undecided);
        }
        Ok(core::array::from_fn(|i| 2 * (above >> i & 1) as i32 - 1))
    }

    #[inline]
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Undecided> {
        Ok(Self::sides(&[*a, *b, *c], [d])?[0])
    }

    /// Both determinants side by side.
    #[inline]
    fn neither(
        [a, b]: [&Point; 2],
        [(p, q, sign), (r, s, other)]: [(&Point, &Point, i32); 2],
    ) -> Result<bool, Undecided> {
        let (u, v, w) = (from(a, [p, r, p, r]), from(a, [b; 4]), from(a, [q, s, q, s]));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let extent = |k: usize| u[k].abs().max(v[k].abs());
        let (above, below) = signs(&normal, &w, &[extent(0), extent(1), extent(2)]);
        if above | below != 0xf {
            return Err(Undecided);
        }
        let found = |lane: u32| 2 * (above >> lane & 1) as i32 - 1;
        Ok(found(0) != sign && found(1) != other)
    }

    #[inline]
    fn orient2d(_: Axes, _: &Point, _: &Point, _: &Point) -> Result<i32, Undecided> {
        // Nothing comes to this: it takes sides that are surely zero.
        Err(Undecided)
    }
}

/// Four points less one, by coordinates.
#[inline]
fn from(base: &Point, [p, q, r, s]: [&Point; 4]) -> [Vec4; 3] {
    let across = |k: usize| Vec4::new(p[k], q[k], r[k], s[k]) - Vec4::splat(base[k]);
    [across(0), across(1), across(2)]
}

/// Bits for the lanes in which the product of a normal and `w` is surely positive, and surely negative.
/// `extent` is that of the edges that the normal was made of.
#[inline]
fn signs(normal: &[Vec4; 3], w: &[Vec4; 3], extent: &[Vec4; 3]) -> (u32, u32) {
    let determinant = normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2];
    let larger = |k: usize| extent[k].max(w[k].abs());
    let [x, y, z] = [larger(0), larger(1), larger(2)];
    let bound = x * y * z * BOUND + Vec4::splat(SLACK);
    let sure = x.max(y).max(z).cmple(Vec4::splat(MOST));
    ((determinant.cmpgt(bound) & sure).bitmask(), (determinant.cmplt(-bound) & sure).bitmask())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Exact;
    use crate::triangle::{certain, meet};

    #[test]
    fn what_is_sure_is_true() {
        let mut state = 3_u64;
        let mut next = move |below: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) as u32) % below
        };
        let (mut hits, mut misses) = (0, 0);
        for _ in 0..if cfg!(miri) { 40 } else { 100_000 } {
            let scale = [1.0, 0.1, 1e-12, 1e-36, 1e11, 1e13, 1e37][next(7) as usize];
            let offset = [0.0, 0.0, 1e3, 3e7][next(4) as usize] * f32::min(scale, 1e20);
            // Small whole coordinates, on which planes and corners coincide, and not quite.
            let mut coordinate = |_: f32| {
                let nudge = [0.0, 1e-7, 1e-6, 1e-3][next(4) as usize] * next(3) as f32;
                (next(5) as f32 + nudge) * scale + offset
            };
            let [a, b] = [[[0.0; 3]; 3]; 2].map(|t| t.map(|p| p.map(&mut coordinate)));
            if let Ok(found) = meet::<Sure>(&a, &b) {
                assert_eq!(found, certain(meet::<Exact>(&a, &b)), "{a:?} {b:?}");
                *if found { &mut hits } else { &mut misses } += 1;
            }
        }
        assert!(cfg!(miri) || hits > 5_000 && misses > 5_000, "{hits} {misses}");
    }
}
