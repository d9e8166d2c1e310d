//! Signs that f32 certifies: nearly all that are asked for, at the price of plain f32.
//!
//! # The bound
//! Let u = 2^-24, and mx, my, mz the extents: the largest absolute difference along each axis that goes into a
//! determinant. As in `filter64`, each of its six products carries a relative error below (1+u)^8 − 1, so it is off by
//! less than 48.06u · mx·my·mz, in whatever order it is summed. [`ERROR`] is that factor, with room for the roundings of
//! the bound itself.
//!
//! In f32, unlike f64, products may underflow or overflow. Where no extent exceeds [`MAX_EXTENT`], 2^40, none overflows.
//! Underflow then costs the determinant less than 6 · 2^-150 · 2^40 before the last product and 4 · 2^-150 after it, and
//! the bound 2^-110. [`UNDERFLOW`], 2^-100, is far above their sum.
//!
//! So a sign is certified where no extent exceeds `MAX_EXTENT` and the determinant exceeds
//! `mx·my·mz · ERROR + UNDERFLOW` in magnitude.

use super::{Orientation, Point};
use glam::{Vec3A, Vec4};

/// Bound of the relative error of a determinant.
pub(crate) const ERROR: f32 = 2.9e-6;
/// Bound of what underflow adds to it: 2^-100.
pub(crate) const UNDERFLOW: f32 = 7.888_609e-31;
/// The largest difference for which the bound holds: 2^40.
pub(crate) const MAX_EXTENT: f32 = 1.099_511_6e12;

/// Signs that f32 certifies, and `None` for the rest.
pub(crate) enum CertifiedF32 {}

impl Orientation for CertifiedF32 {
    type C = f32;

    /// Up to four points side by side.
    #[inline]
    fn orient3d<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]> {
        const { assert!(0 < N && N <= 4) };
        let base = Vec3A::from_array(*a);
        let (u, v) = (Vec3A::from_array(*b) - base, Vec3A::from_array(*c) - base);
        let (normal, edges) = (u.cross(v), u.abs().max(v.abs()));
        if let [p] = points.as_slice() {
            let w = Vec3A::from_array(**p) - base;
            let (determinant, extent) = (normal.dot(w), edges.max(w.abs()));
            let bound = extent.x * extent.y * extent.z * ERROR + UNDERFLOW;
            if determinant.abs() > bound && extent.max_element() <= MAX_EXTENT {
                return Some([if determinant > 0.0 { 1 } else { -1 }; N]);
            }
            return None;
        }
        let [p, q, r, s] = [0, 1, 2, 3].map(|lane: usize| points[lane.min(N - 1)]);
        let w = |k: usize| Vec4::new(p[k], q[k], r[k], s[k]) - Vec4::splat(a[k]);
        let (x, y, z) = (w(0), w(1), w(2));
        let determinant = normal.x * x + normal.y * y + normal.z * z;
        let extent = |edges: f32, w: Vec4| Vec4::splat(edges).max(w.abs());
        let (x, y, z) = (extent(edges.x, x), extent(edges.y, y), extent(edges.z, z));
        let bound = x * y * z * ERROR + Vec4::splat(UNDERFLOW);
        let holds = x.max(y).max(z).cmple(Vec4::splat(MAX_EXTENT));
        let positive = (determinant.cmpgt(bound) & holds).bitmask();
        let negative = (determinant.cmplt(-bound) & holds).bitmask();
        if positive | negative != 0xf {
            return None;
        }
        Some(core::array::from_fn(|lane| 2 * (positive >> lane & 1) as i32 - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::orientation::sides;
    use pfront_testkit::rng::{RngExt, seeded};

    #[test]
    fn certified_signs_are_exact() {
        let mut rng = seeded(3);
        let mut next = move |below: u32| rng.random_range(0..below);
        let (mut certified, mut uncertain) = ([0; 2], 0);
        for _ in 0..100_000 {
            let scale = [1.0, 0.1, 1e-12, 1e-36, 1e11, 1e13, 1e37][next(7) as usize];
            let offset = [0.0, 0.0, 1e3, 3e7][next(4) as usize] * f32::min(scale, 1e20);
            // Small whole coordinates, on which planes and corners coincide, and not quite.
            let mut coordinate = |_: f32| {
                let nudge = [0.0, 1e-7, 1e-6, 1e-3][next(4) as usize] * next(3) as f32;
                (next(5) as f32 + nudge) * scale + offset
            };
            let [a, b, c, p, q, r]: [Point; 6] = [[0.0; 3]; 6].map(|p| p.map(&mut coordinate));
            let truth = sides([&a, &b, &c], [&p, &q, &r]);
            match CertifiedF32::orient3d([&a, &b, &c], [&p, &q, &r]) {
                Some(signs) => {
                    assert_eq!(signs, truth, "{a:?} {b:?} {c:?} {p:?} {q:?} {r:?}");
                    signs.iter().for_each(|sign| certified[usize::from(*sign > 0)] += 1);
                }
                None => uncertain += 1,
            }
        }
        let enough = certified.iter().all(|count| *count > 5_000) && uncertain > 5_000;
        assert!(enough, "{certified:?} {uncertain}");
    }

    /// Each term of the bound is needed: beyond it f32 gets a sign wrong, or might.
    #[test]
    fn nothing_is_certified_beyond_the_bound() {
        let corner = |size: f32| [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
        let certified = |size: f32, height: f32| {
            let [a, b, c] = corner(size);
            CertifiedF32::orient3d([&a, &b, &c], [&[0.0, 0.0, height]])
        };
        assert_eq!(certified(1.0, 1.0), Some([1]));
        assert_eq!(certified(1.0, -1e-20), Some([-1]), "the bound shrinks with each extent");
        assert_eq!(certified(1.0, 1.1 * UNDERFLOW), Some([1]));
        assert_eq!(certified(1.0, 0.9 * UNDERFLOW), None);
        assert_eq!(certified(MAX_EXTENT, -1.0), Some([-1]));
        assert_eq!(certified(MAX_EXTENT.next_up(), -1.0), None);
        let lifted = |z: f32| {
            let [a, mut b, c] = corner(1.0);
            b[2] = 1.0;
            CertifiedF32::orient3d([&a, &b, &c], [&[0.0, 0.0, z], &[0.0, 0.0, -z]])
        };
        assert_eq!(lifted(1.1 * ERROR), Some([1, -1]));
        assert_eq!(lifted(0.9 * ERROR), None);
        for size in [1.0 / 1024.0, 1.0, 1024.0] {
            let [a, mut b, c] = corner(size);
            b[2] = size;
            let one = |z: f32| CertifiedF32::orient3d([&a, &b, &c], [&[0.0, 0.0, z * size]]);
            assert_eq!([one(1.1 * ERROR), one(0.9 * ERROR)], [Some([1]), None], "{size}");
        }
    }
}
