//! Coplanar triangles, and degenerate ones.
//!
//! Convex polygons in a plane are disjoint exactly if a line along an edge of one of them separates them,
//! which takes only the turns of points in a projection that keeps areas. A degenerate triangle is its
//! segment or point, and a segment is a polygon of two edges, there and back.

use crate::exact::{Orientation, difference};
use crate::scalar::Scalar;

/// Whether two triangles intersect that are coplanar or of which at least one is degenerate.
#[cold]
pub(super) fn coplanar_triangles_intersect<K: Orientation>(
    a: &[[K::C; 3]; 3],
    b: &[[K::C; 3]; 3],
) -> Option<bool> {
    match (projection::<K>(a)?, projection::<K>(b)?) {
        (Some(p), Some(q)) => {
            let turn = q.turn_along::<K>(b, p.axis)?;
            polygons_intersect::<K>(&flat(a, p.axis), p.turn, &flat(b, p.axis), turn)
        }
        (_, None) => segment_intersects::<K>(extremes(b), a),
        (None, Some(_)) => segment_intersects::<K>(extremes(a), b),
    }
}

/// Whether the closed segment `s` meets the closed triangle `t`; either may be degenerate.
pub(super) fn segment_intersects<K: Orientation>(
    s: [[K::C; 3]; 2],
    t: &[[K::C; 3]; 3],
) -> Option<bool> {
    match K::orient3d(t.each_ref(), s.each_ref())? {
        [x, y] if x * y > 0 => Some(false),
        [0, 0] => match projection::<K>(t)? {
            Some(Projection { axis, turn }) => {
                polygons_intersect::<K>(&flat(&s, axis), 1, &flat(t, axis), turn)
            }
            None => segments_intersect::<K>(s, extremes(t)),
        },
        _ => pierces::<K>(&s, t),
    }
}

/// A projection in which a triangle has an area.
pub(crate) struct Projection {
    /// The axis along which points are projected.
    pub(crate) axis: usize,
    /// The turn of the corners there.
    pub(crate) turn: i32,
}

impl Projection {
    /// The turn of the same corners in the projection along an axis.
    pub(super) fn turn_along<K: Orientation>(
        &self,
        t: &[[K::C; 3]; 3],
        axis: usize,
    ) -> Option<i32> {
        if self.axis == axis { Some(self.turn) } else { turn::<K>(t, axis) }
    }
}

/// The projection in which the triangle has about the largest area; `Some(None)` if it is degenerate.
pub(crate) fn projection<K: Orientation>(t: &[[K::C; 3]; 3]) -> Option<Option<Projection>> {
    let normal = difference(&t[1], &t[0]).cross(difference(&t[2], &t[0]));
    // The largest area first: it nearly always decides.
    let largest = normal.abs().max_position();
    for axis in [largest, (largest + 1) % 3, (largest + 2) % 3] {
        let turn = turn::<K>(t, axis)?;
        if turn != 0 {
            return Some(Some(Projection { axis, turn }));
        }
    }
    Some(None)
}

/// The turn of the corners in the projection along an axis.
pub(crate) fn turn<K: Orientation>(t: &[[K::C; 3]; 3], axis: usize) -> Option<i32> {
    let [p, q, r] = flat(t, axis);
    K::orient2d(&p, &q, &r)
}

/// Points projected along an axis.
pub(crate) fn flat<C: Copy, const N: usize>(points: &[[C; 3]; N], axis: usize) -> [[C; 2]; N] {
    points.map(|[x, y, z]| match axis {
        0 => [y, z],
        1 => [z, x],
        _ => [x, y],
    })
}

/// The ends of a degenerate triangle: lexicographic order is monotone along a line.
pub(super) fn extremes<C: Scalar>(t: &[[C; 3]; 3]) -> [[C; 3]; 2] {
    t.iter().fold([t[0]; 2], |[low, high], &p| {
        [if p < low { p } else { low }, if p > high { p } else { high }]
    })
}

/// Whether a segment that reaches the plane of `t` in one point does so within `t`: its line passes
/// all three edges on the same side, or through one.
fn pierces<K: Orientation>([p, q]: &[[K::C; 3]; 2], t: &[[K::C; 3]; 3]) -> Option<bool> {
    let (mut left, mut right) = (false, false);
    let [a, b, c] = t;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let [side] = K::orient3d([p, q, from], [to])?;
        left |= side < 0;
        right |= side > 0;
        if left && right {
            return Some(false);
        }
    }
    Some(true)
}

fn segments_intersect<K: Orientation>(s: [[K::C; 3]; 2], r: [[K::C; 3]; 2]) -> Option<bool> {
    // A common point is between the ends of both in lexicographic order.
    let [[p, q], [u, v]] = [s, r].map(|[p, q]| if p < q { [p, q] } else { [q, p] });
    if q < u || v < p || K::orient3d([&p, &q, &u], [&v])? != [0] {
        return Some(false);
    }
    // In a projection of all four onto one line nothing separates them; in every other the answer is the true one.
    for axis in 0..3 {
        if !polygons_intersect::<K>(&flat(&s, axis), 1, &flat(&r, axis), 1)? {
            return Some(false);
        }
    }
    Some(true)
}

/// Whether two polygons in one plane intersect, by their corners and turns.
fn polygons_intersect<K: Orientation>(
    p: &[[K::C; 2]],
    p_turn: i32,
    q: &[[K::C; 2]],
    q_turn: i32,
) -> Option<bool> {
    Some(!separates::<K>(p, p_turn, q)? && !separates::<K>(q, q_turn, p)?)
}

/// Whether the line of some edge of `p` has all of `q` strictly on its outer side.
fn separates<K: Orientation>(p: &[[K::C; 2]], turn: i32, q: &[[K::C; 2]]) -> Option<bool> {
    let ends = p.iter().skip(1).chain(p);
    for (from, to) in p.iter().zip(ends) {
        let mut outside = true;
        for point in q {
            if K::orient2d(from, to, point)? * turn >= 0 {
                outside = false;
                break;
            }
        }
        if outside {
            return Some(true);
        }
    }
    Some(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::{Exact, Point};

    /// An area that f64 takes for zero, in each projection: all are tried.
    #[test]
    fn every_projection_is_tried() {
        let sliver = [[-1.0, 1.0, 0.0], [f32::from_bits(1), 1.0, -1.0], [-0.5, 1.0, -0.5]];
        for turns in 0..3 {
            let t = sliver.map(|mut p: Point| {
                p.rotate_right(turns);
                p
            });
            let found = projection::<Exact<_>>(&t).unwrap().map(|p| (p.axis, p.turn != 0));
            assert_eq!(found, Some(((1 + turns) % 3, true)));
        }
    }
}
