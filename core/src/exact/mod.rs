//! Exact signs of orientation determinants: the only arithmetic that an answer depends on.
//!
//! A determinant is computed with a bound on its rounding error; a sign that the bound certifies is
//! exact, and only the others cost more (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates*, 1997). An `Orientation` is one way to decide:
//!
//! - `CertifiedF32`: f32, certified signs only. Nearly all triangle pairs end here;
//! - `ExactF64`: f64, exact for points whose coordinates are small multiples of a power of two;
//! - `Exact`, of points in f32 or f64: what f64 does not certify is computed in integers, of as many bits as it takes.
//!
//! Two departures from Shewchuk: the bounds take the largest difference per axis in place of the permanent,
//! as Devillers and Pion do (*Efficient Exact Geometric Predicates for Delaunay Triangulations*, 2003), and
//! the exact stages are integers instead of expansions. They need no branches on exponents and cannot overflow.

mod distance;
mod exact64;
pub(crate) mod filter32;
pub(crate) mod filter64;
pub(crate) mod integer;
#[cfg(feature = "motion")]
pub(crate) mod motion;
pub(crate) mod orientation;
mod wide;

pub(crate) use distance::features_are_within;
pub(crate) use exact64::{ExactF64, are_exact_in_f64};
pub(crate) use filter32::CertifiedF32;
pub(crate) use filter64::difference;
pub(crate) use orientation::{Exact, HAS_F64, Orientation};

/// A point in space.
pub(crate) type Point = [f32; 3];

/// A point in a plane.
pub(crate) type Point2 = [f32; 2];

#[cfg(test)]
mod tests {
    use super::orientation::{orient2d, sides};
    use super::*;

    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> i32 {
        let [side] = sides([a, b, c], [d]);
        side
    }

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
        assert_eq!(orient2d(&[0.0, 0.0], &[big, tiny], &[-big, tiny]), 1);
        // (big, big) and a third point on its line or one lattice step off.
        assert_eq!(orient2d(&[0.0, 0.0], &[big, big], &[tiny, tiny]), 0);
        assert_eq!(orient2d(&[0.0, 0.0], &[big, big], &[tiny, 2.0 * tiny]), 1);
        assert_eq!(orient2d(&[0.0, 0.0], &[big, big], &[2.0 * tiny, tiny]), -1);
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
