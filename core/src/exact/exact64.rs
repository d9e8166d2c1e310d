//! Signs for points on a grid, which f64 computes without any rounding error.
//!
//! Where faces lie flush, many determinants are zero, which no filter certifies. But that is the everyday case of voxels, of
//! CAD and of welded parts, whose coordinates are mostly small multiples of a power of two. A query about flush solids of voxels
//! takes a fifth to a quarter fewer instructions so, and a tenth more where their coordinates are on no grid
//! (`benches/record/kept.md`).
//!
//! # The proof
//! Let the differences of some points from the first, along one axis, be multiples of u and at most 2^15 u; u differs from
//! axis to axis. Scaling an axis changes no sign of a determinant, so let u be 1. The difference of any two is then an
//! integer of at most 2^16, a product of three of them at most 2^48, and the sum of six such products at most 2^51: every
//! intermediate result is an integer below 2^53, which f64 holds. With scaling it neither overflows nor underflows f64, as in
//! `filter64`.

use super::{Orientation, Point, Point2, difference};
use crate::Triangle;
use glam::Vec3A;

/// Exact signs of points that [`are_exact_in_f64`].
pub(crate) enum ExactF64 {}

/// The largest difference from the first point is less than 2^BITS units.
const BITS: u32 = 15;

/// A float whose neighbours are 1 apart: to add it and to take it away again rounds to a whole number.
const ROUNDING: f32 = 12_582_912.0;

/// Whether the corners of two triangles, along each axis, are multiples of a power of two away from each other, and at most
/// 2^15 of it from the first.
#[inline]
pub(crate) fn are_exact_in_f64(a: &Triangle, b: &Triangle) -> bool {
    let first = Vec3A::from_array(a[0]);
    let others = [&a[1], &a[2], &b[0], &b[1], &b[2]].map(|p| Vec3A::from_array(*p));
    let differences = others.map(|p| p - first);
    let extent = differences.iter().fold(Vec3A::ZERO, |extent, d| extent.max(d.abs()));
    // The extent is below 2^(exponent - 126). A power of two is made from its exponent.
    let power = |exponent: u32| f32::from_bits(exponent << 23);
    let units = extent.to_array().map(|x| ((x.to_bits() >> 23) + 1).saturating_sub(BITS).max(1));
    let unit = Vec3A::from_array(units.map(power));
    let inverse = Vec3A::from_array(units.map(|unit| power(254 - unit)));
    let rounding = Vec3A::splat(ROUNDING);
    let mut are_multiples = first.cmpeq(first);
    for (p, d) in others.into_iter().zip(differences) {
        // A difference of floats is exact if it leads from each to the other (Dekker 1971). A difference that overflows or
        // underflows does not lead back to the same.
        let rounded = ((d * inverse + rounding) - rounding) * unit;
        are_multiples &= (d + first).cmpeq(p) & (p - d).cmpeq(first) & rounded.cmpeq(d);
    }
    are_multiples.all()
}

impl Orientation for ExactF64 {
    type C = f32;

    #[inline]
    fn orient3d<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]> {
        let normal = difference(b, a).cross(difference(c, a));
        Some(points.map(|p| sign(normal.dot(difference(p, a)))))
    }

    #[inline]
    fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> Option<i32> {
        let edge = |p: &Point2, k: usize| f64::from(p[k]) - f64::from(a[k]);
        Some(sign(edge(b, 0) * edge(c, 1) - edge(b, 1) * edge(c, 0)))
    }
}

#[inline]
fn sign(x: f64) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Exact;
    use crate::exact::orientation::sides;
    use pfront_testkit::rng::{RngExt, seeded};

    #[test]
    fn signs_on_grids_are_exact() {
        let mut rng = seeded(5);
        let (mut on_grid, mut zeros) = (0, 0);
        for _ in 0..200_000 {
            let scale = [1.0, 0.25, 1e-20, 1e-38, 1e-44, 3.0, 1e30][rng.random_range(0..7)];
            let reach = [2, 5, 300, 32_768][rng.random_range(0..4)];
            let offset = [0.0, 0.0, 1e6, -3e38][rng.random_range(0..4)];
            let mut coordinate = |_: f32| rng.random_range(-reach..=reach) as f32 * scale + offset;
            let [p, q]: [Triangle; 2] =
                [[[0.0; 3]; 3]; 2].map(|t| t.map(|p| p.map(&mut coordinate)));
            if !are_exact_in_f64(&p, &q) {
                continue;
            }
            on_grid += 1;
            let truth = sides(p.each_ref(), q.each_ref());
            assert_eq!(ExactF64::orient3d(p.each_ref(), q.each_ref()), Some(truth), "{p:?} {q:?}");
            zeros += truth.iter().filter(|&&side| side == 0).count();
            let [a, b, c] = [p[0], p[1], q[2]].map(|[x, y, _]| [x, y]);
            assert_eq!(ExactF64::orient2d(&a, &b, &c), Exact::orient2d(&a, &b, &c));
        }
        assert!(on_grid > 50_000 && zeros > 5_000, "{on_grid} {zeros}");
    }

    /// The grid is as fine as the proof allows and no finer.
    #[test]
    fn coordinates_beside_the_grid_are_noticed() {
        let floor: Triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for scale in [1.0, 2f32.powi(-100), 2f32.powi(100)] {
            let at = |x: f32| floor.map(|p| p.map(|y| scale * (x + y)));
            let apart = |x: f32| are_exact_in_f64(&at(0.0), &at(x));
            assert!(apart(0.0) && apart(1.0) && apart(0.5 + 2f32.powi(-14)));
            assert!(!apart(0.5 + 2f32.powi(-15)) && !apart(0.1));
            assert!(apart(16_384.0) && apart(32_766.0) && !apart(32_766.5));
        }
        // A coordinate that vanishes beside the extent is no multiple of the unit.
        for tiny in [f32::from_bits(1), 1e-38, 1e-30] {
            let mut other = floor;
            other[0][0] = tiny;
            assert!(!are_exact_in_f64(&floor, &other));
        }
        let huge = floor.map(|p| p.map(|x| (2.0 * x - 1.0) * f32::MAX));
        assert!(!are_exact_in_f64(&huge, &floor));
    }
}
