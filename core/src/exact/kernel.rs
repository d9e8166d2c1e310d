//! The three accuracies, as three ways to decide the same signs.

use super::{Axes, FILTERS, Point, coordinate, filter_orient2d, filter_orient3d, filter_sides};
use crate::Triangle;
use core::convert::Infallible;
use glam::Vec3;

/// How signs are decided. The logic of the triangle test is written once, over this trait.
pub(crate) trait Kernel {
    /// What a predicate returns when it cannot decide; [`Infallible`] costs nothing.
    type Undecided;

    /// Sides of the plane of `t` on which points lie.
    fn sides<const N: usize>(
        t: &Triangle,
        points: [&Point; N],
    ) -> Result<[i32; N], Self::Undecided>;

    /// See [`super::orient3d`].
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Self::Undecided>;

    /// Whether the sign of det(p − a, b − a, q − a) is neither of two, each with its p and q.
    #[inline]
    fn neither(
        [a, b]: [&Point; 2],
        [(p, q, sign), (r, s, other)]: [(&Point, &Point, i32); 2],
    ) -> Result<bool, Self::Undecided> {
        Ok(Self::orient3d(a, p, b, q)? != sign && Self::orient3d(a, r, b, s)? != other)
    }

    /// See [`super::orient2d`].
    fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> Result<i32, Self::Undecided>;
}

/// Every sign exact: the filter first, integers for what it leaves.
pub(crate) enum Exact {}

/// Signs the f64 filter is sure of, and an error for the rest.
pub(crate) enum Filtered {}

/// Plain f32: any sign may be wrong.
pub(crate) enum Fast {}

impl Kernel for Exact {
    type Undecided = Infallible;

    #[inline(always)]
    fn sides<const N: usize>(t: &Triangle, points: [&Point; N]) -> Result<[i32; N], Infallible> {
        if !FILTERS {
            return Ok(settle(t, points, [0; N]));
        }
        let sides = filter_sides(t, points);
        Ok(if sides.contains(&0) { settle(t, points, sides) } else { sides })
    }

    #[inline]
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Infallible> {
        Ok(super::orient3d(a, b, c, d))
    }

    #[inline]
    fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> Result<i32, Infallible> {
        Ok(super::orient2d(axes, a, b, c))
    }
}

/// Decides exactly what the filter left open.
#[cold]
fn settle<const N: usize>(t: &Triangle, points: [&Point; N], mut sides: [i32; N]) -> [i32; N] {
    for (side, point) in sides.iter_mut().zip(points) {
        if *side == 0 {
            *side = super::integer::orient3d(&t[0], &t[1], &t[2], point);
        }
    }
    sides
}

/// The filter left a sign open.
pub(crate) struct Undecided;

#[inline]
fn known<const N: usize>(signs: [i32; N]) -> Result<[i32; N], Undecided> {
    if signs.contains(&0) { Err(Undecided) } else { Ok(signs) }
}

impl Kernel for Filtered {
    type Undecided = Undecided;

    #[inline]
    fn sides<const N: usize>(t: &Triangle, points: [&Point; N]) -> Result<[i32; N], Undecided> {
        known(filter_sides(t, points))
    }

    #[inline]
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Undecided> {
        known([filter_orient3d(a, b, c, d)]).map(|[sign]| sign)
    }

    #[inline]
    fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> Result<i32, Undecided> {
        known([filter_orient2d(axes, a, b, c)]).map(|[sign]| sign)
    }
}

impl Kernel for Fast {
    type Undecided = Infallible;

    #[inline]
    fn sides<const N: usize>(t: &Triangle, points: [&Point; N]) -> Result<[i32; N], Infallible> {
        let a = Vec3::from_array(t[0]);
        let normal = (Vec3::from_array(t[1]) - a).cross(Vec3::from_array(t[2]) - a);
        let mut sides = [0; N];
        for i in 0..N {
            sides[i] = sign(normal.dot(Vec3::from_array(*points[i]) - a));
        }
        Ok(sides)
    }

    #[inline]
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Infallible> {
        Ok(Self::sides(&[*a, *b, *c], [d])?[0])
    }

    #[inline]
    fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> Result<i32, Infallible> {
        let [u, v] = [b, c].map(|p| axes.map(|k| coordinate(p, k) - coordinate(a, k)));
        Ok(sign(u[0] * v[1] - u[1] * v[0]))
    }
}

/// Zero for zero and for NaN.
fn sign(x: f32) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}
