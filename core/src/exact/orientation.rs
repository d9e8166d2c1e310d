//! Ways to decide the signs of orientation determinants.
//!
//! The triangle tests are written once over [`Orientation`]: what they promise is what its signs promise.

use super::{filter64, integer};
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Decides the orientation of points in space and in a plane. A sign that is not known is `None`.
pub(crate) trait Orientation {
    /// The coordinates of the points.
    type C: Scalar;

    /// The sides of one plane, through three points, on which several points lie; `None` if one of them is not known.
    fn orient3d<const N: usize>(
        plane: [&[Self::C; 3]; 3],
        points: [&[Self::C; 3]; N],
    ) -> Option<[i32; N]>;

    /// The turn of three points. Only sides that are known to be zero lead from space to a plane, and a filter never
    /// knows that: it is not asked.
    fn orient2d(_: &[Self::C; 2], _: &[Self::C; 2], _: &[Self::C; 2]) -> Option<i32> {
        None
    }
}

/// Every sign is exact.
pub(crate) struct Exact<C = f32>(PhantomData<C>);

/// Whether f64 comes before integers. Bare ARM computes f64 by integers too, so that it saves no time there and
/// takes 2 KiB of machine code.
pub(crate) const HAS_F64: bool = !cfg!(all(target_arch = "arm", target_os = "none"));

/// The exact sides of the plane through three points on which several points lie: the signs of det(b − a, c − a, d − a). One
/// is 1 when a, b, c turn counter-clockwise seen from the side of d, −1 on the other side, 0 when the four points are
/// coplanar.
#[inline]
pub(crate) fn sides<C: Scalar, const N: usize>(
    plane: [&[C; 3]; 3],
    points: [&[C; 3]; N],
) -> [i32; N] {
    let mut sides = if HAS_F64 { filter64::orient3d(plane, points) } else { [0; N] };
    for (side, point) in sides.iter_mut().zip(points) {
        if *side == 0 {
            *side = integer::orient3d(plane, point);
        }
    }
    sides
}

/// The exact turn of three points, the sign of det(b − a, c − a): 1 is counter-clockwise, −1 clockwise, 0 collinear.
#[inline]
pub(crate) fn orient2d<C: Scalar>(a: &[C; 2], b: &[C; 2], c: &[C; 2]) -> i32 {
    let turn = if HAS_F64 { filter64::orient2d(a, b, c) } else { 0 };
    if turn == 0 { integer::orient2d(a, b, c) } else { turn }
}

impl<C: Scalar> Orientation for Exact<C> {
    type C = C;

    #[inline(always)]
    fn orient3d<const N: usize>(plane: [&[C; 3]; 3], points: [&[C; 3]; N]) -> Option<[i32; N]> {
        Some(sides(plane, points))
    }

    #[inline(always)]
    fn orient2d(a: &[C; 2], b: &[C; 2], c: &[C; 2]) -> Option<i32> {
        Some(orient2d(a, b, c))
    }
}
