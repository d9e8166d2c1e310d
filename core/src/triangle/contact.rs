//! The segment in which two triangles intersect, for callers who need contacts rather than indices.
//!
//! Exact signs decide which features bound the segment; only the coordinates of its ends are rounded. An end is
//! where an edge cuts a plane, at the parameter d/(d − e) of the edge, with d and e the determinants of its ends
//! over that plane. They come from integers if f64 does not know them to 2^-30, so that nearly parallel triangles
//! lose no accuracy.

use super::coplanar::{extremes, flat};
use super::{arrange, one_sided, triangles_intersect};
use crate::Triangle;
use crate::exact::filter64::{ERROR_2D, ERROR_3D, UNDERFLOW_2D, UNDERFLOW_3D};
use crate::exact::orientation::{orient2d, sides};
use crate::exact::{Coordinate, Exact, difference, integer};
use glam::{DVec3, Vec3Swizzles};

/// 2^30: a value that exceeds its error bound by this factor is known within a relative 2^-30.
const TWO_30: f64 = 1_073_741_824.0;

/// The segment in which two triangles meet, and how they face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact<C = f32> {
    /// Whether they lie in one plane or one has no area: then the segment is the longest chord between corners of the
    /// region they share. Otherwise they cross in a segment, or in a point if its ends are equal.
    pub is_flat: bool,
    /// End points, each coordinate within 2^-28 of the extent of the edge it lies on, plus half a
    /// unit in the last place, of the true one. Where triangles that have an edge in common cross the same triangle, the
    /// end on that edge is the same to the bit, but for the sign of zero.
    pub segment: [[C; 3]; 2],
    /// Unit normals of both triangles by the right-hand rule, which is outward where corners are counter-clockwise seen from
    /// outside, each coordinate within 2^-23; zero for a degenerate triangle.
    pub normals: [[f32; 3]; 2],
}

/// The segment in which two closed triangles meet, or `None` if they do not: `Some` exactly when [`intersects`](super::intersects) says so.
///
/// # Complexity
/// O(1), no allocation.
///
/// # Examples
/// ```
/// use pfront_core::triangle::contact;
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let blade = [[1.0, 1.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0]];
/// let found = contact(&floor, &blade).map(|c| c.segment);
/// assert_eq!(found, Some([[1.0, 1.5, 0.0], [1.0, 1.0, 0.0]]));
/// ```
#[must_use]
pub fn contact(a: &Triangle, b: &Triangle) -> Option<Contact> {
    contact_of(a, b)
}

/// [`contact`] of triangles with coordinates of either kind, which are in range.
pub(crate) fn contact_of<C: Coordinate>(a: &[[C; 3]; 3], b: &[[C; 3]; 3]) -> Option<Contact<C>> {
    let a_sides = sides(b.each_ref(), a.each_ref());
    let b_sides = sides(a.each_ref(), b.each_ref());
    if one_sided(&a_sides) || one_sided(&b_sides) {
        return None;
    }
    let are_flat = [a_sides, b_sides].map(|sides| sides == [0; 3]);
    let is_flat = are_flat != [false; 2];
    let segment = if is_flat {
        flat_chord(a, b, are_flat == [true; 2])?
    } else {
        crossing(a, &a_sides, b, &b_sides)?
    };
    Some(Contact { is_flat, segment, normals: [unit_normal(a), unit_normal(b)] })
}

fn orient3d<C: Coordinate>(a: &[C; 3], b: &[C; 3], c: &[C; 3], d: &[C; 3]) -> i32 {
    let [side] = sides([a, b, c], [d]);
    side
}

/// Rounds the end points.
impl From<Contact<f64>> for Contact {
    fn from(contact: Contact<f64>) -> Self {
        let Contact { segment, is_flat, normals } = contact;
        let segment = segment.map(|p| DVec3::from_array(p).as_vec3().to_array());
        Self { segment, is_flat, normals }
    }
}

impl From<Contact> for Contact<f64> {
    fn from(contact: Contact) -> Self {
        let Contact { segment, is_flat, normals } = contact;
        Self { segment: segment.map(|p| p.map(f64::from)), is_flat, normals }
    }
}

/// The unit normal of a triangle by the right-hand rule, or zero if it is degenerate.
fn unit_normal<C: Coordinate>(t: &[[C; 3]; 3]) -> [f32; 3] {
    let (u, v) = (difference(&t[1], &t[0]), difference(&t[2], &t[0]));
    let (in_f64, extent) = (u.cross(v), u.abs().max(v.abs()));
    let largest = (extent.yzx() * extent.zxy()).max_element();
    let bound = (largest * ERROR_2D + UNDERFLOW_2D) * TWO_30;
    let is_certain = in_f64.abs().max_element() > bound;
    let normal = if is_certain { in_f64 } else { integer::direction_of_normal(t.each_ref()) };
    // The squares of the largest f32 areas would overflow, those of the smallest vanish.
    let largest = normal.abs().max_element();
    if largest == 0.0 { [0.0; 3] } else { (normal / largest).normalize().as_vec3().to_array() }
}

/// The overlap of the two intervals that [`intervals_overlap`](super::intervals_overlap) compares.
fn crossing<C: Coordinate>(
    a: &[[C; 3]; 3],
    a_sides: &[i32; 3],
    b: &[[C; 3]; 3],
    b_sides: &[i32; 3],
) -> Option<[[C; 3]; 2]> {
    let ([a0, a1, a2], [b0, b1, b2], side) = arrange(a, a_sides, b, b_sides);
    if orient3d(a0, a1, b0, b1) == side || orient3d(a0, a2, b0, b2) == -side {
        return None;
    }
    // Along the line, a runs from a0a1 to a0a2 and b from b0b2 to b0b1.
    let start = if orient3d(a0, a1, b0, b2) == -side {
        edge_point(b0, b2, a)
    } else {
        edge_point(a0, a1, b)
    };
    let end = if orient3d(a0, a2, b0, b1) == side {
        edge_point(b0, b1, a)
    } else {
        edge_point(a0, a2, b)
    };
    Some([start, end])
}

/// The point in which the edge p–q, whose ends lie on different sides of the plane of `t`, cuts it.
///
/// It does not depend on the order of ends and corners, so that neighbours, which have the edge in common, have the point in
/// common too, to the bit.
fn edge_point<C: Coordinate>(p: &[C; 3], q: &[C; 3], t: &[[C; 3]; 3]) -> [C; 3] {
    let (p, q) = in_order(p, q);
    let [a, b, c] = t;
    let (a, b) = in_order(a, b);
    let (b, c) = in_order(b, c);
    let (a, b) = in_order(a, b);
    let t = [a, b, c];
    let s = edge_parameter(p, q, t);
    // The parameter counts from the nearer end, so that an end in the plane is returned unchanged.
    let (end, part) = if s <= 0.5 { (p, s) } else { (q, s - 1.0) };
    C::point(difference(end, &[C::from(0.0); 3]) + part * difference(q, p))
}

/// Two points, the one with the smaller first coordinate in which they differ first.
fn in_order<'p, C: Coordinate>(p: &'p [C; 3], q: &'p [C; 3]) -> (&'p [C; 3], &'p [C; 3]) {
    if q < p { (q, p) } else { (p, q) }
}

/// The parameter of that point along the edge, within 2^-28.
fn edge_parameter<C: Coordinate>(p: &[C; 3], q: &[C; 3], t: [&[C; 3]; 3]) -> f64 {
    let (u, v) = (difference(t[1], t[0]), difference(t[2], t[0]));
    let w = [p, q].map(|p| difference(p, t[0]));
    let extent = u.abs().max(v.abs()).max(w[0].abs()).max(w[1].abs());
    let [d, e] = w.map(|w| u.cross(v).dot(w));
    let bound = extent.x * extent.y * extent.z * ERROR_3D + UNDERFLOW_3D;
    if d.abs().min(e.abs()) > bound * TWO_30 {
        d / (d - e)
    } else {
        integer::orient3d_ratio(t, p, q)
    }
}

/// The longest chord between corners of the intersection of triangles that are coplanar or of which one is
/// degenerate. These corners are corners of one within the other, and points where two edges cross.
fn flat_chord<C: Coordinate>(
    a: &[[C; 3]; 3],
    b: &[[C; 3]; 3],
    are_coplanar: bool,
) -> Option<[[C; 3]; 2]> {
    let meet = |p: &[[C; 3]; 3], t| triangles_intersect::<Exact<C>>(p, t) == Some(true);
    // 6 corners, and 9 crossings of edges or 2 of segments with triangles.
    let mut corners = [[C::from(0.0); 3]; 15];
    let mut free = corners.iter_mut();
    let mut add = |p: [C; 3]| match free.next() {
        Some(slot) => *slot = p,
        None => debug_assert!(false, "6 + 9 corners at most"),
    };
    for (own, other) in [(a, b), (b, a)] {
        for p in own {
            if meet(&[*p; 3], other) {
                add(*p);
            }
        }
    }
    if are_coplanar {
        edge_crossings(a, b, &mut add);
    } else {
        for (thin, t) in [(a, b), (b, a)] {
            let [p, q] = extremes(thin);
            let [p_side, q_side] = sides(t.each_ref(), [&p, &q]);
            if p_side * q_side < 0 && meet(&[p, q, q], t) {
                add(edge_point(&p, &q, t));
            }
        }
    }
    let count = 15 - free.len();
    longest(corners.iter().take(count))
}

/// The points in which an edge of one coplanar triangle crosses an edge of the other.
fn edge_crossings<C: Coordinate>(a: &[[C; 3]; 3], b: &[[C; 3]; 3], add: &mut impl FnMut([C; 3])) {
    let differ =
        |[p, q]: [[C; 2]; 2], [r, s]: [[C; 2]; 2]| orient2d(&p, &q, &r) * orient2d(&p, &q, &s) < 0;
    for axis in 0..3 {
        let mut any = false;
        for (p, q) in edges(a) {
            for (r, s) in edges(b) {
                let (k, l) = (flat(&[*p, *q], axis), flat(&[*r, *s], axis));
                if differ(k, l) && differ(l, k) && orient3d(p, q, r, s) == 0 {
                    // The plane through r–s along the axis of the projection.
                    let mut up = *r;
                    up[axis] = C::from(if r[axis] == C::from(0.0) { 1.0 } else { 0.0 });
                    add(edge_point(p, q, &[*r, *s, up]));
                    any = true;
                }
            }
        }
        // Another projection would find the same points, or none if the plane is a line there.
        if any {
            return;
        }
    }
}

fn edges<C>(t: &[[C; 3]; 3]) -> [(&[C; 3], &[C; 3]); 3] {
    [(&t[0], &t[1]), (&t[1], &t[2]), (&t[2], &t[0])]
}

/// The two points farthest from each other.
fn longest<'p, C: Coordinate + 'p>(
    points: impl Iterator<Item = &'p [C; 3]> + Clone,
) -> Option<[[C; 3]; 2]> {
    let mut best = None;
    let mut length = -1.0;
    for (i, p) in points.clone().enumerate() {
        for q in points.clone().skip(i) {
            let squared = difference(p, q).length_squared();
            if squared > length {
                (length, best) = (squared, Some([*p, *q]));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests;
