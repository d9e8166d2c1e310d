//! Where two triangles meet: for people who need contacts rather than indices.
//!
//! Which features bound the intersection is decided by exact signs; only the coordinates of its end
//! points are rounded. An end point is where an edge cuts a plane, at the parameter d/(d − e) of the
//! edge, with d and e the determinants of its ends over that plane. When f64 does not know these to
//! 2^-30 they come from integers, so nearly parallel triangles lose no accuracy.

use super::{Accuracy, coplanar, from_corner, intersects, lone_corner, one_sided};
use crate::Triangle;
use crate::exact::{
    Exact, Kernel, PROJECTIONS, Point, determinants, difference, orient2d, orient3d,
};

/// How two triangles meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ContactKind {
    /// Their planes differ: they meet in a segment, or in a point if its ends are equal.
    Crossing,
    /// They lie in one plane, or one has no area: the segment is the longest chord between corners
    /// of the region they share.
    Flat,
}

/// Where two triangles meet, and how they face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Crossing or flat.
    pub kind: ContactKind,
    /// End points, each coordinate within 2^-28 of the extent of the edge it lies on, plus half an
    /// f32 unit in the last place, of the true one.
    pub segment: [[f32; 3]; 2],
    /// Unit normals of both triangles by the right-hand rule; zero for a triangle without area.
    pub normals: [[f32; 3]; 2],
}

/// Where two closed triangles meet, or `None` if they do not: `Some` exactly when [`intersects`]
/// says so in mode `Exact`.
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
    let sides = |t, [p, q, r]: &Triangle| super::certain(Exact::sides(t, [p, q, r]));
    let (a_sides, b_sides) = (sides(b, a), sides(a, b));
    if one_sided(&a_sides) || one_sided(&b_sides) {
        return None;
    }
    let (kind, segment) = if a_sides == [0; 3] || b_sides == [0; 3] {
        (ContactKind::Flat, flat_chord(a, b)?)
    } else {
        (ContactKind::Crossing, crossing(a, &a_sides, b, &b_sides)?)
    };
    Some(Contact { kind, segment, normals: [unit_normal(a), unit_normal(b)] })
}

/// The unit normal of a triangle by the right-hand rule, or zero if f64 finds no area.
#[must_use]
pub fn unit_normal(t: &Triangle) -> [f32; 3] {
    let (u, v) = (difference(&t[1], &t[0]), difference(&t[2], &t[0]));
    // The squares of the largest f32 areas would overflow, those of the smallest vanish.
    let normal = u.cross(v);
    let largest = normal.abs().max_element();
    if largest == 0.0 { [0.0; 3] } else { (normal / largest).normalize().as_vec3().to_array() }
}

/// See [`super::cross`], whose intervals this compares at the inner ends too.
fn crossing(
    a: &Triangle,
    a_sides: &[i32; 3],
    b: &Triangle,
    b_sides: &[i32; 3],
) -> Option<[Point; 2]> {
    let (i, delta) = lone_corner(a_sides);
    let (j, epsilon) = lone_corner(b_sides);
    let ([a0, a1, a2], [b0, mut b1, mut b2]) = (from_corner(a, i), from_corner(b, j));
    if delta != epsilon {
        core::mem::swap(&mut b1, &mut b2);
    }
    if orient3d(a0, a1, b0, b1) == epsilon || orient3d(a0, a2, b0, b2) == -epsilon {
        return None;
    }
    // Along the line, a runs from a0a1 to a0a2 and b from b0b2 to b0b1.
    let start = if orient3d(a0, a1, b0, b2) == -epsilon {
        edge_point(b0, b2, a)
    } else {
        edge_point(a0, a1, b)
    };
    let end = if orient3d(a0, a2, b0, b1) == epsilon {
        edge_point(b0, b1, a)
    } else {
        edge_point(a0, a2, b)
    };
    Some([start, end])
}

/// Where the edge p–q, whose ends lie on different sides of the plane of `t`, cuts it.
fn edge_point(p: &Point, q: &Point, t: &Triangle) -> Point {
    let [d, e] = plane_distances(t, [p, q]);
    let s = d / (d - e);
    // From the nearer end, so that an end in the plane is returned unchanged.
    let (end, part) = if s <= 0.5 { (p, s) } else { (q, s - 1.0) };
    (difference(end, &[0.0; 3]) + part * difference(q, p)).as_vec3().to_array()
}

/// Determinants of two points over a plane, up to one common factor, each within 2^-29.
fn plane_distances(t: &Triangle, points: [&Point; 2]) -> [f64; 2] {
    const SURE: f64 = 5.4e-15 * (1 << 30) as f64;
    let (u, v) = (difference(&t[1], &t[0]), difference(&t[2], &t[0]));
    let w = points.map(|p| difference(p, &t[0]));
    let extent = u.abs().max(v.abs()).max(w[0].abs()).max(w[1].abs());
    let bound = SURE * extent.x * extent.y * extent.z;
    let normal = u.cross(v);
    let found = w.map(|w| normal.dot(w));
    if found.iter().all(|d| d.abs() > bound) { found } else { determinants(t, points) }
}

/// The longest chord between corners of what two triangles share that are coplanar or have no area.
/// These corners are corners of one within the other, and points where two edges cross.
fn flat_chord(a: &Triangle, b: &Triangle) -> Option<[Point; 2]> {
    // 6 corners and 9 crossings of edges.
    let mut found = [[0.0; 3]; 15];
    let mut count = 0;
    let mut add = |p: Point| {
        if let Some(free) = found.get_mut(count) {
            *free = p;
            count += 1;
        }
    };
    for (own, other) in [(a, b), (b, a)] {
        for p in own {
            if intersects(&[*p; 3], other, Accuracy::Exact) {
                add(*p);
            }
        }
    }
    if !edge_crossings(a, b, &mut add) {
        for (thin, t) in [(a, b), (b, a)] {
            let [p, q] = coplanar::extremes(thin);
            let sides = [&p, &q].map(|x| orient3d(&t[0], &t[1], &t[2], x));
            if sides[0] * sides[1] < 0 && intersects(&[p, q, q], t, Accuracy::Exact) {
                add(edge_point(&p, &q, t));
            }
        }
    }
    longest(found.get(..count).unwrap_or_default())
}

/// Points in which an edge of one crosses an edge of the other in their common plane; whether there
/// are any.
fn edge_crossings(a: &Triangle, b: &Triangle, add: &mut impl FnMut(Point)) -> bool {
    let coplanar = b.iter().all(|p| orient3d(&a[0], &a[1], &a[2], p) == 0)
        && a.iter().all(|p| orient3d(&b[0], &b[1], &b[2], p) == 0);
    if !coplanar {
        return false;
    }
    for (k, axes) in PROJECTIONS.into_iter().enumerate() {
        let mut any = false;
        for (p, q) in edges(a) {
            for (r, s) in edges(b) {
                let across = |p, q, r, s| orient2d(axes, p, q, r) * orient2d(axes, p, q, s) < 0;
                if across(p, q, r, s) && across(r, s, p, q) && orient3d(p, q, r, s) == 0 {
                    // The plane through r–s along the axis that the projection leaves out.
                    let mut up = *r;
                    up[k % 3] = if r[k % 3] == 0.0 { 1.0 } else { 0.0 };
                    add(edge_point(p, q, &[*r, *s, up]));
                    any = true;
                }
            }
        }
        if any {
            return true;
        }
    }
    false
}

fn edges(t: &Triangle) -> [(&Point, &Point); 3] {
    [(&t[0], &t[1]), (&t[1], &t[2]), (&t[2], &t[0])]
}

fn longest(points: &[Point]) -> Option<[Point; 2]> {
    let mut best = None;
    let mut length = -1.0;
    let mut rest = points;
    while let [p, others @ ..] = rest {
        for q in rest {
            let squared = difference(p, q).length_squared();
            if squared > length {
                (length, best) = (squared, Some([*p, *q]));
            }
        }
        rest = others;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    #[test]
    fn crossing_segment_ends_on_the_inner_features() {
        let wall = [[1.0, -1.0, -1.0], [1.0, 9.0, -1.0], [1.0, -1.0, 9.0]];
        let c = contact(&FLOOR, &wall).unwrap();
        let mut ends = c.segment;
        ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
        assert_eq!(c.kind, ContactKind::Crossing);
        assert_eq!(ends, [[1.0, 0.0, 0.0], [1.0, 3.0, 0.0]]);
        assert_eq!(c.normals, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn nearly_parallel_planes_keep_their_accuracy() {
        // Two sheets that cross at x = 1/3 at an angle of 1e-40.
        let tilt = 1e-40;
        let sheet = [[0.0, -1.0, -tilt], [0.0, 9.0, -tilt], [1.0, 0.0, 2.0 * tilt]];
        let big = [[-9.0, -9.0, 0.0], [99.0, -9.0, 0.0], [-9.0, 99.0, 0.0]];
        let c = contact(&big, &sheet).unwrap();
        for p in c.segment {
            assert!((p[0] - 1.0 / 3.0).abs() < 1e-5 && p[2] == 0.0, "{p:?}");
        }
    }

    #[test]
    fn flat_contacts() {
        let c = contact(&FLOOR, &[[1.0, 1.0, 0.0], [1.0, 9.0, 0.0], [-9.0, 1.0, 0.0]]).unwrap();
        assert_eq!(c.kind, ContactKind::Flat);
        for [p, expected] in
            [[[1.0, 1.0, -1.0], [1.0, 1.0, 0.0]], [[2.0, 2.0, -1.0], [2.0, 2.0, 0.0]]]
        {
            let needle = [p, [p[0], p[1], 1.0], p];
            assert_eq!(contact(&FLOOR, &needle).unwrap().segment, [expected; 2]);
        }
        let across = [[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [9.0, 1.0, 0.0]];
        let mut ends = contact(&FLOOR, &across).unwrap().segment;
        ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
        assert_eq!(ends, [[0.0, 1.0, 0.0], [3.0, 1.0, 0.0]]);
        assert!(contact(&FLOOR, &[[5.0, 5.0, 0.0]; 3]).is_none());
    }
}
