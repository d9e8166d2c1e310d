//! When two triangles of one mesh meet first that share vertices by index.

use super::apart::{CUBIC, Cubic, HEIGHT, height, normal};
use super::impact::{Impact, impact_of};
use super::pair::{MovingTriangle, UNIT};
use crate::Mesh;
use crate::exact::difference;
use crate::exact::filter64::larger;
use crate::triangle::{Adjacency, intersects_in_mesh, neighbours};
use glam::DVec3;

/// A coefficient of the product of two moving normals has to exceed so much of the sum of the squared products of two extents each. A component of a
/// normal is at most twice such a product. Its two products, or four over 2, are off by 2 u for their factors and by at most 3 u for
/// multiplications and sums, so by 12 u; the product of two components by 48 u, and by 4 · 6 u for its own.
const PRODUCT: f64 = 128.0 * UNIT;

/// 2^-930, more than what underflow takes from a determinant: some dozens of products of two differences of f64, each of which loses 2^-1075, times
/// a third of at most 2^126. Products of differences of f32, which may be larger, do not underflow.
const UNDERFLOW: f64 = f64::from_bits((1023 - 930) << 52);

/// 2^-800, more than what it takes from the product of two normals: some dozens of products lose 2^-1075 each, times a component of at most 2^253.
const UNDERFLOW_4D: f64 = f64::from_bits((1023 - 800) << 52);

/// When triangles `i` and `j` of one mesh meet first that moves from `start` to `end`, two meshes with the same triangles; `None` if they never do.
///
/// Vertices and edges that they share by index are no contact, at each time as in [`intersects_in_mesh`]:
///
/// - with one shared vertex they meet where the opposite edge of one meets the other;
/// - with a shared edge they meet where the opposite corner of one meets the other, or two edges that have no corner in common meet. These
///   include times at which this corner is on the line of the edge, so that the triangle has no area: for an instant they meet, which
///   would not count without a motion;
/// - with three shared vertices, or the same set of vertices, they meet from the start on.
///
/// # Panics
/// If `i` or `j` is not a triangle of both meshes.
///
/// # Examples
/// ```
/// use pfront_core::{Mesh, motion::impact_in_mesh, triangle::Adjacency};
/// // Two faces of a fold, of which one turns through the other.
/// let points = |z| [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.25, z]];
/// let (start, end) = (points(1.0), points(-1.0));
/// let triangles = [[0, 1, 2], [1, 0, 3]];
/// let [start, end] = [Mesh::new(&start, &triangles)?, Mesh::new(&end, &triangles)?];
/// let found = impact_in_mesh(start, end, 0, 1, Adjacency::SharedIndexRule);
/// assert!(found.is_some_and(|impact| impact.from <= 0.5 && 0.5 <= impact.to));
/// # Ok::<(), pfront_core::MeshError>(())
/// ```
#[must_use]
pub fn impact_in_mesh(
    start: Mesh<'_>,
    end: Mesh<'_>,
    i: u32,
    j: u32,
    adjacency: Adjacency,
) -> Option<Impact> {
    let ends = [start, end];
    let [a, b] = [i, j].map(|triangle| ends.map(|mesh| mesh.triangle_f64(triangle)));
    let indices = [i, j].map(|triangle| &start.triangles()[triangle as usize]);
    if are_certainly_apart(indices, [&a, &b]) {
        return None;
    }
    let at = |mesh: Mesh<'_>| neighbours(mesh, [i, j], |vertex| mesh.position_f64(vertex));
    let (Some([a, b]), Some([a_end, b_end])) = (at(start), at(end)) else {
        return impact_of(&a, &b);
    };
    if adjacency == Adjacency::SkipNeighbours {
        return None;
    }
    let (shared, distinct) = (a.shared, [a.distinct, b.distinct]);
    let [a, b] = [[a.corners, a_end.corners], [b.corners, b_end.corners]];
    if distinct == [shared; 2] {
        return Some(Impact { from: 0.0, to: 0.0 });
    }
    // One may be no more than the edge.
    if shared == 2 && distinct.contains(&2) {
        return None;
    }
    decide(ends, [i, j], [&a, &b], shared, distinct)
}

/// Decides by the parts of both that have no vertex in common, shared ones first.
#[cold]
#[inline(never)]
fn decide(
    [start, end]: [Mesh<'_>; 2],
    [i, j]: [u32; 2],
    [a, b]: [&MovingTriangle; 2],
    shared: usize,
    distinct: [usize; 2],
) -> Option<Impact> {
    if intersects_in_mesh(start, i, j, Adjacency::SharedIndexRule) {
        return Some(Impact { from: 0.0, to: 0.0 });
    }
    if a[0] == a[1] && b[0] == b[1] {
        return None;
    }
    let hull = |t: &MovingTriangle, corners: [usize; 3]| t.map(|end| corners.map(|k| end[k]));
    let found = if shared == 2 {
        // Both list the shared edge from the same end on. Where that is not known, it has no length.
        let turned = [b[0][0], b[1][0]] != [a[0][0], a[1][0]];
        let b = if turned { hull(b, [1, 0, 2]) } else { *b };
        let meet = |of_a, of_b| impact_of(&hull(a, of_a), &hull(&b, of_b));
        const ALL: [usize; 3] = [0, 1, 2];
        let parts = [([2; 3], ALL), (ALL, [2; 3]), ([0, 2, 2], [1, 2, 2]), ([1, 2, 2], [0, 2, 2])];
        parts.map(|(of_a, of_b)| meet(of_a, of_b))
    } else {
        let meet = |t: &MovingTriangle, other, distinct| {
            (distinct > 1).then(|| impact_of(&hull(t, [1, 2, 2]), other)).flatten()
        };
        [meet(a, b, distinct[0]), meet(b, a, distinct[1]), None, None]
    };
    let found = found.into_iter().flatten().reduce(Impact::first);
    if !intersects_in_mesh(end, i, j, Adjacency::SharedIndexRule) {
        return found;
    }
    let Impact { from, to } = found.unwrap_or(Impact { from: 1.0, to: 1.0 });
    Some(Impact { from, to: to.min(1.0) })
}

/// Whether two triangles certainly have no more in common at any time than the one vertex or edge that they share by index. Most neighbours in
/// a surface end here.
#[inline]
pub(super) fn are_certainly_apart(
    [of_a, of_b]: [&[u32; 3]; 2],
    [a, b]: [&MovingTriangle; 2],
) -> bool {
    let (mut shared, mut count) = ([[0; 2]; 2], 0);
    for (i, vertex) in of_a.iter().enumerate() {
        for (j, other) in of_b.iter().enumerate() {
            if vertex == other {
                if count == 2 {
                    return false;
                }
                shared[count] = [i, j];
                count += 1;
            }
        }
    }
    let [[i, j], [i_next, j_next]] = shared;
    let from = |t: &MovingTriangle, corner: usize, to: usize| {
        [0, 1].map(|end| difference(&t[end][to], &t[end][corner]))
    };
    let others = |k: usize| if k == 0 { [1, 2] } else { [0, 3 - k] };
    match count {
        1 => {
            let ([p, q], [r, s]) = (others(i), others(j));
            are_apart_at_vertex([from(a, i, p), from(a, i, q)], [from(b, j, r), from(b, j, s)])
        }
        2 if i != i_next && j != j_next => are_apart_at_edge(
            from(a, i, i_next),
            from(a, i, 3 - i - i_next),
            from(b, j, 3 - j - j_next),
        ),
        _ => false,
    }
}

/// A moving vector, at the start and at the end: the difference of two corners, off by u of itself.
type Moving = [DVec3; 2];

/// Whether two triangles have no more than a corner in common, from which these vectors lead to their others.
///
/// Either a plane through that corner has all others of the first above and of the second below: one that stands still, whose heights are
/// linear in time, through the corner; it is normal to the directions of one triangle minus those of the other. Or all others of one are
/// on one side of the plane of the other.
#[inline]
fn are_apart_at_vertex(a: [Moving; 2], b: [Moving; 2]) -> bool {
    let all = [a[0], a[1], b[0], b[1]];
    let direction = |[start, end]: Moving| {
        let middle = start + end;
        middle / middle.abs().element_sum()
    };
    let [p, q, r, s] = all.map(direction);
    let n = (p + q) - (r + s);
    let extents = extents(&all);
    let margin = n.abs().dot(extents) * HEIGHT + UNDERFLOW;
    let is_above = |[start, end]: Moving, n: DVec3| n.dot(start) > margin && n.dot(end) > margin;
    if a.into_iter().all(|v| is_above(v, n)) && b.into_iter().all(|v| is_above(v, -n)) {
        return true;
    }
    let on_one_side = |[u, v]: [Moving; 2], others: [Moving; 2]| {
        let (normal, margin) = (normal(u, v), volume(extents) * CUBIC + UNDERFLOW);
        let [x, y] = others.map(|w| strict_side(&height(&normal, w), margin));
        x != 0 && x == y
    };
    on_one_side(a, b) || on_one_side(b, a)
}

/// Whether two triangles have no more than an edge in common, from an end of which a vector leads to its other end, and to the other corner of
/// each.
///
/// Either they never are in one plane; or, seen along the edge, they never are less than a right angle apart: the product of their
/// normals, taken in the same sense, is negative. It is a quartic of time.
#[inline]
fn are_apart_at_edge(edge: Moving, to_a: Moving, to_b: Moving) -> bool {
    let extents = extents(&[edge, to_a, to_b]);
    let [a0, a1, a2] = normal(edge, to_a);
    let cubic = height(&[a0, a1, a2], to_b);
    if strict_side(&cubic, volume(extents) * CUBIC + UNDERFLOW) != 0 {
        return true;
    }
    let [b0, b1, b2] = normal(edge, to_b);
    let quartic = [
        a0.dot(b0),
        (a0.dot(b1) + a1.dot(b0)) * 0.25,
        (a0.dot(b2) + a1.dot(b1) + a2.dot(b0)) * (1.0 / 6.0),
        (a1.dot(b2) + a2.dot(b1)) * 0.25,
        a2.dot(b2),
    ];
    let [x, y, z] = (extents * extents).to_array();
    let margin = (x * y + y * z + z * x) * PRODUCT + UNDERFLOW_4D;
    quartic.iter().all(|c| *c < -margin)
}

/// The largest coordinates of some vectors from one corner, along each axis. Bounds for differences of corners with their ranges hold for vectors
/// from one corner with these: they are rounded once.
#[inline(always)]
fn extents(vectors: &[Moving]) -> DVec3 {
    vectors.as_flattened().iter().fold(DVec3::ZERO, |extents, v| larger(extents, v.abs()))
}

fn volume(extents: DVec3) -> f64 {
    extents.x * extents.y * extents.z
}

/// The sign of a cubic all through its interval, 0 if it is not certain.
#[inline(always)]
fn strict_side(cubic: &Cubic, margin: f64) -> i32 {
    i32::from(cubic.iter().all(|c| *c > margin)) - i32::from(cubic.iter().all(|c| *c < -margin))
}
