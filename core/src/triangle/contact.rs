//! The segment in which two triangles intersect, for callers who need contacts rather than indices.
//!
//! Exact signs decide which features bound the segment; only the coordinates of its ends are rounded. An end is
//! where an edge cuts a plane, at the parameter d/(d − e) of the edge, with d and e the determinants of its ends
//! over that plane. They come from integers if f64 does not know them to 2^-30, so that nearly parallel triangles
//! lose no accuracy.

use super::coplanar::{extremes, flat, projection};
use super::{arrange, one_sided, triangles_intersect};
use crate::exact::filter64::{ERROR_2D, ERROR_3D, UNDERFLOW_2D, UNDERFLOW_3D, larger};
use crate::exact::orientation::{orient2d, sides};
use crate::exact::{Exact, difference, integer};
use crate::scalar::Scalar;
use crate::{Pose64, Triangle};
use core::ops::Range;
use glam::{DVec3, Vec3Swizzles};

/// 2^30: a value that exceeds its error bound by this factor is known within a relative 2^-30.
const TWO_30: f64 = 1_073_741_824.0;

/// 2^-900 to 2^900: squares of lengths that are exact to a few roundings.
const SQUARES: Range<f64> = f64::from_bits((1023 - 900) << 52)..f64::from_bits((1023 + 900) << 52);

/// The segment in which two triangles meet, and how they face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact<C = f32> {
    /// Whether they lie in one plane or one has no area: then the segment is the longest chord between corners of the
    /// region they share. Otherwise they cross in a segment, or in a point if its ends are equal.
    pub is_flat: bool,
    /// End points, each coordinate within 2^-28 of the extent of the edge it lies on, plus half a
    /// unit in the last place, of the true one. Where triangles that have an edge in common cross the same triangle, the
    /// end on that edge is the same to the bit, but for the sign of zero, and but where it is on an edge of that triangle
    /// too, of which either may then bound the segment.
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
pub(crate) fn contact_of<C: Scalar>(a: &[[C; 3]; 3], b: &[[C; 3]; 3]) -> Option<Contact<C>> {
    let [of_a, of_b] = [TrianglePlane::of(a), TrianglePlane::of(b)];
    let normals = || [of_a.unit_normal(), of_b.unit_normal()];
    // Six corners with the same x, y or z are coplanar, which is common where faces lie flush.
    let [[x, y, z], ..] = a;
    let level = |[all_x, all_y, all_z]: [bool; 3], [u, v, w]: &[C; 3]| {
        [all_x & (u == x), all_y & (v == y), all_z & (w == z)]
    };
    if a.iter().chain(b).fold([true; 3], level).contains(&true) {
        let segment = flat_chord(a, b, true)?;
        return Some(Contact { is_flat: true, segment, normals: normals() });
    }
    let (over_b, over_a) = (CornerHeights::new(a, &of_b), CornerHeights::new(b, &of_a));
    let (a_sides, b_sides) = (over_b.sides(), over_a.sides());
    if one_sided(&a_sides) || one_sided(&b_sides) {
        return None;
    }
    let are_flat = [a_sides, b_sides].map(|sides| sides == [0; 3]);
    let is_flat = are_flat != [false; 2];
    let segment = if is_flat {
        flat_chord(a, b, are_flat == [true; 2])?
    } else {
        crossing(&over_b, &a_sides, &over_a, &b_sides)?
    };
    Some(Contact { is_flat, segment, normals: normals() })
}

/// [`contact_of`] two triangles as they stand, whatever the pose, told of the posed ones: its segment is posed, and the
/// normals are those of the posed triangles.
pub(crate) fn posed_contact(
    a: &[[f64; 3]; 3],
    b: &[[f64; 3]; 3],
    pose: &Pose64,
) -> Option<Contact<f64>> {
    let contact = contact_of(a, b)?;
    let normals = [a, b].map(|t| TrianglePlane::of(&t.map(|p| pose.apply(p))).unit_normal());
    Some(Contact { segment: contact.segment.map(|p| pose.apply(p)), normals, ..contact })
}

/// The plane of a triangle.
struct TrianglePlane<'t, C> {
    triangle: &'t [[C; 3]; 3],
    /// The edges from the first corner.
    edges: [DVec3; 2],
    /// Their cross product, rounded.
    normal: DVec3,
}

impl<'t, C: Scalar> TrianglePlane<'t, C> {
    #[inline]
    fn of(triangle: &'t [[C; 3]; 3]) -> Self {
        let [a, b, c] = triangle;
        let edges = [difference(b, a), difference(c, a)];
        Self { triangle, edges, normal: edges[0].cross(edges[1]) }
    }

    /// A bound of the errors of heights; see [`crate::exact::filter64`].
    #[inline]
    fn bound<const N: usize>(&self, offsets: &[DVec3; N]) -> f64 {
        let [u, v] = self.edges;
        let extent = offsets.iter().fold(larger(u.abs(), v.abs()), |e, w| larger(e, w.abs()));
        extent.x * extent.y * extent.z * ERROR_3D + UNDERFLOW_3D
    }

    /// The unit normal of the triangle by the right-hand rule, or zero if it is degenerate.
    fn unit_normal(&self) -> [f32; 3] {
        let [u, v] = self.edges;
        let extent = larger(u.abs(), v.abs());
        let largest = (extent.yzx() * extent.zxy()).max_element();
        let bound = (largest * ERROR_2D + UNDERFLOW_2D) * TWO_30;
        let is_certain = self.normal.abs().max_element() > bound;
        let normal = if is_certain {
            self.normal
        } else {
            integer::direction_of_normal(self.triangle.each_ref())
        };
        // The squares of the largest f64 areas would overflow, those of the smallest vanish.
        let squared = normal.length_squared();
        let normal = match SQUARES.contains(&squared) {
            true => normal / normal.length(),
            false => (normal / normal.abs().max_element()).normalize_or_zero(),
        };
        normal.as_vec3().to_array()
    }
}

/// The corners of a triangle, with their heights over the plane of another.
struct CornerHeights<'t, C> {
    plane: &'t TrianglePlane<'t, C>,
    points: [Corner<C>; 3],
    /// No error of a height is larger.
    bound: f64,
}

struct Corner<C> {
    at: [C; 3],
    /// The determinant of the plane and this point, rounded: positive on the side of the normal of the plane.
    height: f64,
}

impl<'t, C: Scalar> CornerHeights<'t, C> {
    #[inline]
    fn new(points: &[[C; 3]; 3], plane: &'t TrianglePlane<'t, C>) -> Self {
        let offsets = points.each_ref().map(|p| difference(p, &plane.triangle[0]));
        let ([p, q, r], heights) = (*points, offsets.map(|offset| plane.normal.dot(offset)));
        let corner = |at, height| Corner { at, height };
        let points = [corner(p, heights[0]), corner(q, heights[1]), corner(r, heights[2])];
        Self { plane, points, bound: plane.bound(&offsets) }
    }

    /// The exact sides of the triangle, as it turns, on which the points lie.
    #[inline]
    fn sides(&self) -> [i32; 3] {
        let points = self.points.each_ref();
        if points.iter().all(|point| point.height.abs() > self.bound) {
            return points.map(|point| if point.height > 0.0 { 1 } else { -1 });
        }
        sides(self.plane.triangle.each_ref(), points.map(|point| &point.at))
    }

    /// The point in which the edge p–q, whose ends lie on different sides of the plane, cuts it.
    ///
    /// It does not depend on the order of ends, so that neighbours, which have the edge in common, have the point in common
    /// too, to the bit.
    fn cut(&self, p: &Corner<C>, q: &Corner<C>) -> [C; 3] {
        let (p, q) = if q.at < p.at { (q, p) } else { (p, q) };
        let is_certain = |bound: f64| p.height.abs().min(q.height.abs()) > bound * TWO_30;
        let ends = || [p, q].map(|p| difference(&p.at, &self.plane.triangle[0]));
        // Within 2^-28.
        let s = if is_certain(self.bound) || is_certain(self.plane.bound(&ends())) {
            p.height / (p.height - q.height)
        } else {
            integer::orient3d_ratio(self.plane.triangle.each_ref(), &p.at, &q.at)
        };
        // The parameter counts from the nearer end, so that an end in the plane is returned unchanged.
        let (end, part) = if s <= 0.5 { (p, s) } else { (q, s - 1.0) };
        C::point(difference(&end.at, &[C::from(0.0); 3]) + part * difference(&q.at, &p.at))
    }
}

fn orient3d<C: Scalar>(a: &[C; 3], b: &[C; 3], c: &[C; 3], d: &[C; 3]) -> i32 {
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

/// The overlap of the two intervals that [`intervals_overlap`](super::intervals_overlap) compares: of `a` over the plane of
/// `b`, and the other way round.
fn crossing<C: Scalar>(
    a: &CornerHeights<'_, C>,
    a_sides: &[i32; 3],
    b: &CornerHeights<'_, C>,
    b_sides: &[i32; 3],
) -> Option<[[C; 3]; 2]> {
    let ([a0, a1, a2], [b0, b1, b2], side) = arrange(&a.points, a_sides, &b.points, b_sides);
    let turn = |a: &Corner<C>| sides([&a0.at, &a.at, &b0.at], [&b1.at, &b2.at]);
    let ([first, start], [end, last]) = (turn(a1), turn(a2));
    if first == side || last == -side {
        return None;
    }
    // Along the line, a runs from a0a1 to a0a2 and b from b0b2 to b0b1.
    let start = if start == -side { b.cut(b0, b2) } else { a.cut(a0, a1) };
    let end = if end == side { b.cut(b0, b1) } else { a.cut(a0, a2) };
    Some([start, end])
}

/// The point in which the edge p–q cuts the plane of a triangle.
fn edge_point<C: Scalar>(p: &[C; 3], q: &[C; 3], t: &[[C; 3]; 3]) -> [C; 3] {
    let plane = TrianglePlane::of(t);
    let over = CornerHeights::new(&[*p, *q, *q], &plane);
    over.cut(&over.points[0], &over.points[1])
}

/// The longest chord between corners of the intersection of triangles that are coplanar or of which one is
/// degenerate. These corners are corners of one within the other, and points where two edges cross.
fn flat_chord<C: Scalar>(
    a: &[[C; 3]; 3],
    b: &[[C; 3]; 3],
    are_coplanar: bool,
) -> Option<[[C; 3]; 2]> {
    if are_coplanar
        && let [Some(Some(of_a)), Some(Some(of_b))] = [a, b].map(projection::<Exact<C>>)
        && let Some(turn_of_b) = of_b.turn_along::<Exact<C>>(b, of_a.axis)
    {
        return coplanar_chord(a, b, of_a.axis, [of_a.turn, turn_of_b]);
    }
    let meet = |p: &[[C; 3]; 3], t| triangles_intersect::<Exact<C>>(p, t) == Some(true);
    let mut corners = Corners::new();
    for (own, other) in [(a, b), (b, a)] {
        for p in own {
            if meet(&[*p; 3], other) {
                corners.add(*p);
            }
        }
    }
    if are_coplanar {
        edge_crossings(a, b, |p| corners.add(p));
    } else {
        for (thin, t) in [(a, b), (b, a)] {
            let [p, q] = extremes(thin);
            let [p_side, q_side] = sides(t.each_ref(), [&p, &q]);
            if p_side * q_side < 0 && meet(&[p, q, q], t) {
                corners.add(edge_point(&p, &q, t));
            }
        }
    }
    corners.longest()
}

/// The same of coplanar triangles that have areas, by their turns in a projection along an axis.
fn coplanar_chord<C: Scalar>(
    a: &[[C; 3]; 3],
    b: &[[C; 3]; 3],
    axis: usize,
    turns: [i32; 2],
) -> Option<[[C; 3]; 2]> {
    let [p, q] = [a, b].map(|t| flat(t, axis));
    // The sides of each edge on which the corners of the other triangle lie, 1 being the inner one.
    let sides = |p: &[[C; 2]; 3], turn: i32, q: &[[C; 2]; 3]| {
        edges(p).map(|(from, to)| q.each_ref().map(|point| turn * orient2d(from, to, point)))
    };
    let (of_a, of_b) = (sides(&p, turns[0], &q), sides(&q, turns[1], &p));
    let mut corners = Corners::new();
    for (t, of_other) in [(a, of_b), (b, of_a)] {
        for (corner, sides) in t.iter().zip(transposed(of_other)) {
            if sides.iter().all(|&side| side >= 0) {
                corners.add(*corner);
            }
        }
    }
    // Whether the ends of an edge of the other triangle are on different sides.
    let parts = |sides: [[i32; 3]; 3]| sides.map(|own| edges(&own).map(|(x, y)| x * y < 0));
    let crossings = parts(of_a).into_iter().zip(transposed(parts(of_b)));
    for ((p, q), (own, other)) in edges(a).into_iter().zip(crossings) {
        for ((r, s), (x, y)) in edges(b).into_iter().zip(own.into_iter().zip(other)) {
            if x && y {
                corners.add(edges_cross_at([p, q], [r, s], axis));
            }
        }
    }
    corners.longest()
}

fn transposed<T>([[a, b, c], [d, e, f], [g, h, i]]: [[T; 3]; 3]) -> [[T; 3]; 3] {
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// The point in which two edges cross that cross in the projection along an axis and lie in one plane.
fn edges_cross_at<C: Scalar>([p, q]: [&[C; 3]; 2], [r, s]: [&[C; 3]; 2], axis: usize) -> [C; 3] {
    // The plane through r–s along the axis.
    let other = |x: C| C::from(if x == C::from(0.0) { 1.0 } else { 0.0 });
    let [x, y, z] = *r;
    let up = match axis {
        0 => [other(x), y, z],
        1 => [x, other(y), z],
        _ => [x, y, other(z)],
    };
    edge_point(p, q, &[*r, *s, up])
}

/// The points in which an edge of one coplanar triangle crosses an edge of the other, where one of them is degenerate.
fn edge_crossings<C: Scalar>(a: &[[C; 3]; 3], b: &[[C; 3]; 3], mut add: impl FnMut([C; 3])) {
    let differ =
        |[p, q]: [[C; 2]; 2], [r, s]: [[C; 2]; 2]| orient2d(&p, &q, &r) * orient2d(&p, &q, &s) < 0;
    for axis in 0..3 {
        let mut any = false;
        for (p, q) in edges(a) {
            for (r, s) in edges(b) {
                let (k, l) = (flat(&[*p, *q], axis), flat(&[*r, *s], axis));
                if differ(k, l) && differ(l, k) && orient3d(p, q, r, s) == 0 {
                    add(edges_cross_at([p, q], [r, s], axis));
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

fn edges<T>([p, q, r]: &[T; 3]) -> [(&T, &T); 3] {
    [(p, q), (q, r), (r, p)]
}

/// The corners of an intersection: 6 corners of triangles, and 9 crossings of edges or 2 of segments with triangles.
struct Corners<C> {
    points: [[C; 3]; 15],
    count: usize,
}

impl<C: Scalar> Corners<C> {
    fn new() -> Self {
        Self { points: [[C::from(0.0); 3]; 15], count: 0 }
    }

    fn add(&mut self, p: [C; 3]) {
        match self.points.get_mut(self.count) {
            Some(slot) => (*slot, self.count) = (p, self.count + 1),
            None => debug_assert!(false, "6 + 9 corners at most"),
        }
    }

    /// The two points farthest from each other; any two where all are closer than 2^-537, whose squares f64 does not know.
    fn longest(&self) -> Option<[[C; 3]; 2]> {
        let points = self.points.iter().take(self.count);
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
}

#[cfg(test)]
mod tests;
