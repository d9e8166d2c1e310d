//! Winding numbers, by rays.
//!
//! A ray starts at a point p = v + ε(w − v) + ε²(u − v) of a triangle vwu, for ε towards 0: in its interior, close to the corner v, and
//! as near to generic as its plane allows. A determinant that is linear in p has at p the first sign other than zero of those
//! at v, w and u (Edelsbrunner & Mücke, *Simulation of Simplicity*, 1990, with perturbations within the plane). The ray
//! runs along an axis in whose projection the triangle has an area, so that it is parallel to no triangle that it meets.

use crate::bvtt::{PairBvtt, PosedBvh};
use crate::exact::Exact;
use crate::exact::orientation::{orient2d, sides};
use crate::scalar::Scalar;
use crate::triangle::{flat, projection, turn};
use core::cmp::Ordering;
use core::ops::ControlFlow;

/// Coordinates in which a side of a query is posed.
pub(super) trait Posed: Scalar {
    /// The posed corners of a triangle.
    fn corners(side: &PosedBvh<'_>, triangle: u32) -> [[Self; 3]; 3];
}

impl Posed for f32 {
    fn corners(side: &PosedBvh<'_>, triangle: u32) -> [[Self; 3]; 3] {
        side.triangle(triangle)
    }
}

impl Posed for f64 {
    fn corners(side: &PosedBvh<'_>, triangle: u32) -> [[Self; 3]; 3] {
        side.triangle_f64(triangle)
    }
}

/// A triangle lies on the point of a triangle from which a ray starts, or rounding has left that one no area.
#[derive(Debug)]
pub(super) struct OnSurface;

/// The winding number of a side of a query at a point in the interior of a triangle of `from`: that in front of the triangle if it
/// belongs to the same side.
///
/// # Errors
/// [`OnSurface`] if another triangle of the side lies there, or the triangle has no area.
pub(super) fn winding<C: Posed>(
    query: &PairBvtt<'_>,
    [from, of]: [usize; 2],
    triangle: u32,
) -> Result<i32, OnSurface> {
    let sides_of = query.sides();
    let own = C::corners(sides_of[from], triangle);
    let Some(Some(seen)) = projection::<Exact<C>>(&own) else { return Err(OnSurface) };
    let axis = seen.axis;
    let vertex = sides_of[from].bvh.mesh().triangles()[triangle as usize][0];
    let start = flat(&own, axis);
    let mut winding = 0;
    let ray = query.box_of_ray(from, vertex, axis);
    let end = query.visit_overlapping(of, &ray, |other| {
        if from == of && other == triangle {
            return ControlFlow::Continue(());
        }
        let corners = C::corners(sides_of[of], other);
        let below = flat(&corners, axis);
        if !surrounds(&below, &start[0]) {
            return ControlFlow::Continue(());
        }
        let Some(turned) = turn::<Exact<C>>(&corners, axis) else {
            return ControlFlow::Continue(());
        };
        let ends = [(0, 1), (1, 2), (2, 0)];
        let is_within = |&(p, q): &(usize, usize)| {
            let side = |point: &[C; 2]| orient2d(&below[p], &below[q], point);
            first_other_than_0(&start, side) == turned
        };
        if turned == 0 || !ends.iter().all(is_within) {
            return ControlFlow::Continue(());
        }
        let side = first_other_than_0(&own, |point| {
            let [side] = sides(corners.each_ref(), [point]);
            side
        });
        if side == 0 {
            return ControlFlow::Break(());
        }
        if side != turned {
            winding += turned;
        }
        ControlFlow::Continue(())
    });
    if end.is_break() {
        return Err(OnSurface);
    }
    // A ray along the normal starts in front, any other behind, where the number is one more.
    Ok(if from == of && seen.turn < 0 { winding - 1 } else { winding })
}

/// The winding number in front of a triangle of a side of a query.
///
/// # Errors
/// [`OnSurface`]; never for an unmarked triangle that is not posed.
pub(super) fn own_winding(
    query: &PairBvtt<'_>,
    side: usize,
    triangle: u32,
) -> Result<i32, OnSurface> {
    let of = [side; 2];
    match query.is_f64() {
        false => winding::<f32>(query, of, triangle),
        true => winding::<f64>(query, of, triangle),
    }
}

/// The first sign other than 0.
fn first_other_than_0<P>(points: &[P; 3], sign: impl FnMut(&P) -> i32) -> i32 {
    points.iter().map(sign).find(|&sign| sign != 0).unwrap_or(0)
}

/// Whether the box of a projected triangle contains a point.
#[inline]
pub(super) fn surrounds<C: Scalar>([p, q, r]: &[[C; 2]; 3], point: &[C; 2]) -> bool {
    (0..2).all(|k| !is_beside([p[k], q[k], r[k]], point[k]))
}

/// Whether all are on one side of a coordinate.
#[inline]
pub(super) fn is_beside<C: Scalar>([x, y, z]: [C; 3], at: C) -> bool {
    (x < at && y < at && z < at) || (x > at && y > at && z > at)
}

/// The side of a line on which a point lies that is shifted by (ε, ε²), or the other way by −1; 0 only if both points of the line are
/// the same.
pub(super) fn side_of_shifted<C: Scalar>([u, v]: [&[C; 2]; 2], point: &[C; 2], shift: i32) -> i32 {
    let sign = |x: &C, y: &C| x.partial_cmp(y).unwrap_or(Ordering::Equal) as i32;
    match orient2d(u, v, point) {
        0 if u[1] != v[1] => shift * sign(&u[1], &v[1]),
        0 => shift * sign(&v[0], &u[0]),
        side => side,
    }
}
