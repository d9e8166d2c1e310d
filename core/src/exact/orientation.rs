//! Ways to decide the signs of orientation determinants.
//!
//! The triangle tests are written once over [`Orientation`]: what they promise is what its signs promise.

use super::{Point, Point2, filter64, integer};
use core::convert::Infallible;
use glam::Vec3;

/// Decides [`orient3d`](super::orient3d) and [`orient2d`](super::orient2d).
pub(crate) trait Orientation {
    /// Why a sign is not known; [`Infallible`] where every sign is.
    type Uncertain;

    /// The sides of one plane, through three points, on which several points lie.
    fn orient3d<const N: usize>(
        plane: [&Point; 3],
        points: [&Point; N],
    ) -> Result<[i32; N], Self::Uncertain>;

    /// The turn of three points.
    fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> Result<i32, Self::Uncertain>;
}

/// A sign that an error bound does not certify.
pub(crate) struct Uncertain;

/// Every sign is exact.
pub(crate) enum Exact {}

/// Plain f32: any sign may be wrong.
pub(crate) enum Fast {}

/// Whether f64 comes before integers. Bare ARM computes f64 by integers too, so that it saves no time there and
/// takes 2 KiB of machine code.
const HAS_F64: bool = !cfg!(all(target_arch = "arm", target_os = "none"));

impl Orientation for Exact {
    type Uncertain = Infallible;

    #[inline]
    fn orient3d<const N: usize>(
        plane: [&Point; 3],
        points: [&Point; N],
    ) -> Result<[i32; N], Infallible> {
        let mut signs = if HAS_F64 { filter64::orient3d(plane, points) } else { [0; N] };
        for (sign, point) in signs.iter_mut().zip(points) {
            if *sign == 0 {
                *sign = integer::orient3d(plane, point);
            }
        }
        Ok(signs)
    }

    #[inline]
    fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> Result<i32, Infallible> {
        let sign = if HAS_F64 { filter64::orient2d(a, b, c) } else { 0 };
        Ok(if sign == 0 { integer::orient2d(a, b, c) } else { sign })
    }
}

impl Orientation for Fast {
    type Uncertain = Infallible;

    #[inline]
    fn orient3d<const N: usize>(
        [a, b, c]: [&Point; 3],
        points: [&Point; N],
    ) -> Result<[i32; N], Infallible> {
        let edge = |p: &Point| Vec3::from_array(*p) - Vec3::from_array(*a);
        let normal = edge(b).cross(edge(c));
        Ok(points.map(|p| sign(normal.dot(edge(p)))))
    }

    #[inline]
    fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> Result<i32, Infallible> {
        Ok(sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])))
    }
}

/// Zero for zero and for NaN.
fn sign(x: f32) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}
