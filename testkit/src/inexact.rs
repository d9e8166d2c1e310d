//! The test of two triangles in plain f32, which may be wrong, to compare with an exact one.
//!
//! It is that of Devillers and Guigue (*Faster Triangle-Triangle Intersection Tests*, INRIA RR-4488, 2002), as
//! `pfront_core::triangle` writes it, by other signs of orientation determinants.

use crate::{Point, Triangle};
use glam::{DVec3, Vec3};

/// Whether two closed triangles intersect by signs of plain f32, any of which may be wrong.
#[inline]
#[must_use]
pub fn fast(a: &Triangle, b: &Triangle) -> bool {
    let a_sides = plain_sides(b.each_ref(), a.each_ref());
    if one_sided(a_sides) {
        return false;
    }
    let b_sides = plain_sides(a.each_ref(), b.each_ref());
    if one_sided(b_sides) {
        return false;
    }
    if a_sides == [0; 3] || b_sides == [0; 3] {
        return coplanar_intersect(a, b);
    }
    let ((i, delta), (j, side)) = (apex(a_sides), apex(b_sides));
    let ([a0, a1, a2], [b0, b1, b2]) = (rotated(a, i), rotated(b, j));
    let [b1, b2] = if delta == side { [b1, b2] } else { [b2, b1] };
    (plain_sides([a0, a1, b0], [b1]) != [side]) & (plain_sides([a0, a2, b0], [b2]) != [-side])
}

#[inline]
fn plain_sides<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> [i32; N] {
    let edge = |p: &Point| Vec3::from_array(*p) - Vec3::from_array(*a);
    let normal = edge(b).cross(edge(c));
    points.map(|p| sign(normal.dot(edge(p))))
}

/// Zero for zero and for NaN.
fn sign(x: f32) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

fn difference(p: &Point, q: &Point) -> DVec3 {
    Vec3::from_array(*p).as_dvec3() - Vec3::from_array(*q).as_dvec3()
}

fn one_sided(sides: [i32; 3]) -> bool {
    sides[0] != 0 && sides[0] == sides[1] && sides[0] == sides[2]
}

/// The corner alone on its side of the other plane, and that side.
#[inline]
fn apex([p, q, r]: [i32; 3]) -> (usize, i32) {
    let is_apex = |own: i32, p: i32, q: i32| own != p && own != q && (own != 0 || p == q);
    let side = |own: i32, other: i32| if own == 0 { -other } else { own };
    if is_apex(r, p, q) {
        (2, side(r, p))
    } else if is_apex(q, r, p) {
        (1, side(q, r))
    } else {
        (0, side(p, q))
    }
}

#[inline]
fn rotated([p, q, r]: &Triangle, first: usize) -> [&Point; 3] {
    match first {
        0 => [p, q, r],
        1 => [q, r, p],
        _ => [r, p, q],
    }
}

/// Whether two triangles in one plane intersect, or two of which one is degenerate.
#[cold]
fn coplanar_intersect(a: &Triangle, b: &Triangle) -> bool {
    match (projection(a), projection(b)) {
        (Some(p), Some(q)) => {
            let turn = if p.0 == q.0 { q.1 } else { turn(flat(b, p.0)) };
            polygons_intersect(&flat(a, p.0), p.1, &flat(b, p.0), turn)
        }
        (_, None) => segment_intersects(extremes(b), a),
        (None, Some(_)) => segment_intersects(extremes(a), b),
    }
}

fn segment_intersects(s: [Point; 2], t: &Triangle) -> bool {
    match plain_sides(t.each_ref(), s.each_ref()) {
        [x, y] if x * y > 0 => false,
        [0, 0] => match projection(t) {
            Some((axis, turn)) => polygons_intersect(&flat(&s, axis), 1, &flat(t, axis), turn),
            None => segments_intersect(s, extremes(t)),
        },
        _ => {
            let ([p, q], [a, b, c]) = (&s, t);
            let side = |from, to| plain_sides([p, q, from], [to])[0];
            let sides = [side(a, b), side(b, c), side(c, a)];
            !(sides.contains(&1) && sides.contains(&-1))
        }
    }
}

fn segments_intersect(s: [Point; 2], r: [Point; 2]) -> bool {
    let [[p, q], [u, v]] = [s, r].map(|[p, q]| if p < q { [p, q] } else { [q, p] });
    if q < u || v < p || plain_sides([&p, &q, &u], [&v]) != [0] {
        return false;
    }
    (0..3).all(|axis| polygons_intersect(&flat(&s, axis), 1, &flat(&r, axis), 1))
}

/// An axis along which the projection of a triangle has an area, and the turn of the corners there.
fn projection(t: &Triangle) -> Option<(usize, i32)> {
    let normal = difference(&t[1], &t[0]).cross(difference(&t[2], &t[0]));
    let largest = normal.abs().max_position();
    let turns = [0, 1, 2].map(|k| (largest + k) % 3).map(|axis| (axis, turn(flat(t, axis))));
    turns.into_iter().find(|&(_, turn)| turn != 0)
}

fn turn([a, b, c]: [[f32; 2]; 3]) -> i32 {
    sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// Points projected along an axis.
fn flat<const N: usize>(points: &[Point; N], axis: usize) -> [[f32; 2]; N] {
    points.map(|p| [p[(axis + 1) % 3], p[(axis + 2) % 3]])
}

/// The ends of a degenerate triangle.
fn extremes(t: &Triangle) -> [Point; 2] {
    t.iter().fold([t[0]; 2], |[low, high], &p| {
        [if p < low { p } else { low }, if p > high { p } else { high }]
    })
}

fn polygons_intersect(p: &[[f32; 2]], p_turn: i32, q: &[[f32; 2]], q_turn: i32) -> bool {
    let separates = |p: &[[f32; 2]], p_turn: i32, q: &[[f32; 2]]| {
        let mut edges = p.iter().zip(p.iter().skip(1).chain(p));
        edges.any(|(&from, &to)| q.iter().all(|&x| turn([from, to, x]) * p_turn < 0))
    };
    !separates(p, p_turn, q) && !separates(q, q_turn, p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle;
    use crate::rng::{RngExt, seeded};

    /// In small whole coordinates f32 makes no error.
    #[test]
    fn plain_f32_is_right_where_it_is_exact() {
        let mut rng = seeded(18);
        for size in [1, 2, 9_i8] {
            for _ in 0..4_000 {
                let mut corner = |_| [0; 3].map(|_| f32::from(rng.random_range(-size..=size)));
                let (a, b) = ([0; 3].map(&mut corner), [0; 3].map(&mut corner));
                assert_eq!(fast(&a, &b), oracle::intersect(&a, &b), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn it_is_wrong_where_f32_is() {
        const FLOOR: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        // Determinants of 1e-50 are zero in f32.
        let small = |z: f32| FLOOR.map(|[x, y, _]| [1e-20 * x, 1e-20 * y, z]);
        assert!(fast(&small(0.0), &small(1e-10)) && !oracle::intersect(&small(0.0), &small(1e-10)));
    }
}
