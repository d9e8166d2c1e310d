//! The three accuracies, as three ways to decide the same signs.

use super::{Axes, Point, filter_orient2d, filter_orient3d, filter_sides};
use crate::Triangle;
use core::convert::Infallible;
use glam::Vec3;

/// How signs are decided. The logic of the triangle test is written once, over this trait.
pub(crate) trait Kernel {
    /// What a predicate returns when it cannot decide; [`Infallible`] costs nothing.
    type Undecided;

    /// Sides of the plane of `t` on which three points lie.
    fn sides(t: &Triangle, points: &Triangle) -> Result<[i32; 3], Self::Undecided>;

    /// See [`super::orient3d`].
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Self::Undecided>;

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

    #[inline]
    fn sides(t: &Triangle, points: &Triangle) -> Result<[i32; 3], Infallible> {
        let [p, q, r] = points;
        let sides = filter_sides(t, [p, q, r]);
        Ok([0, 1, 2].map(|i| match sides[i] {
            Some(sign) => sign,
            None => super::exact::orient3d(&t[0], &t[1], &t[2], &points[i]),
        }))
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

/// The filter left a sign open.
pub(crate) struct Undecided;

impl Kernel for Filtered {
    type Undecided = Undecided;

    #[inline]
    fn sides(t: &Triangle, points: &Triangle) -> Result<[i32; 3], Undecided> {
        let [p, q, r] = points;
        match filter_sides(t, [p, q, r]) {
            [Some(p), Some(q), Some(r)] => Ok([p, q, r]),
            _ => Err(Undecided),
        }
    }

    #[inline]
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Undecided> {
        filter_orient3d(a, b, c, d).ok_or(Undecided)
    }

    #[inline]
    fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> Result<i32, Undecided> {
        filter_orient2d(axes, a, b, c).ok_or(Undecided)
    }
}

impl Kernel for Fast {
    type Undecided = Infallible;

    #[inline]
    fn sides(t: &Triangle, points: &Triangle) -> Result<[i32; 3], Infallible> {
        let [a, b, c] = t.map(Vec3::from_array);
        let normal = (b - a).cross(c - a);
        Ok(points.map(|p| sign(normal.dot(Vec3::from_array(p) - a))))
    }

    #[inline]
    fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Result<i32, Infallible> {
        let [a, b, c, d] = [a, b, c, d].map(|p| Vec3::from_array(*p));
        Ok(sign((b - a).cross(c - a).dot(d - a)))
    }

    #[inline]
    fn orient2d(axes: Axes, a: &Point, b: &Point, c: &Point) -> Result<i32, Infallible> {
        let [u, v] = [b, c].map(|p| axes.map(|k| p[k] - a[k]));
        Ok(sign(u[0] * v[1] - u[1] * v[0]))
    }
}

/// Zero for zero and for NaN.
fn sign(x: f32) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}
