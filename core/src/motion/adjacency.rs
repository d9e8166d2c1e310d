//! When two triangles of one mesh meet first that share vertices by index.

use super::apart::{CUBIC, HEIGHT, height, normal};
use super::impact::{Impact, impact_of};
use super::pair::{MovingPair, MovingTriangle, UNDERFLOWN, UNIT};
use crate::Mesh;
use crate::triangle::{Adjacency, intersects_in_mesh, neighbours};
use glam::DVec3;

/// A coefficient of the product of two moving normals has to exceed so much of the sum of the squared products of two ranges each. A component of a
/// normal is at most twice such a product, and off by 40 u of it, or 44 u in the middle (see `meets`): the product of two of them by
/// 176 u, and by 4 · 6 u for its multiplications and sums.
const PRODUCT: f64 = 256.0 * UNIT;

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
    let at = |mesh: Mesh<'_>| neighbours(mesh, [i, j], |vertex| mesh.position_f64(vertex));
    let (Some([a, b]), Some([a_end, b_end])) = (at(start), at(end)) else {
        let [a, b] = [i, j].map(|triangle| ends.map(|mesh| mesh.triangle_f64(triangle)));
        return impact_of(&a, &b);
    };
    if adjacency == Adjacency::SkipNeighbours {
        return None;
    }
    let (shared, distinct) = (a.shared, [a.distinct, b.distinct]);
    let [a, b] = [[a.corners, a_end.corners], [b.corners, b_end.corners]];
    let certainly_apart = match shared {
        _ if distinct == [shared; 2] => return Some(Impact { from: 0.0, to: 0.0 }),
        // No more than the edge.
        2 if distinct.contains(&2) => return None,
        2 => are_apart_at_edge(&a, &b),
        _ => are_apart_at_vertex(&a, &b),
    };
    if certainly_apart {
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

/// Whether two triangles have no more than their first corner in common at any time, certainly.
///
/// Either a plane through that corner has all others of the first above and of the second below: one that stands still, whose heights are
/// linear in time, through the corner; it is normal to the directions of one triangle minus those of the other. Or all others of one are
/// on one side of the plane of the other.
fn are_apart_at_vertex(a: &MovingTriangle, b: &MovingTriangle) -> bool {
    let pair = MovingPair::new(a, b);
    let [o, p, q, _, r, s] = pair.at(0.5);
    let direction = |p: DVec3| (p - o) / (p - o).abs().element_sum();
    let n = (direction(p) + direction(q)) - (direction(r) + direction(s));
    let margin = (n.x.abs() + n.y.abs() + n.z.abs()) * HEIGHT + UNDERFLOWN;
    let is_separated = pair
        .ends
        .iter()
        .all(|[_, p, q, _, r, s]| [*p, *q, -*r, -*s].into_iter().all(|x| n.dot(x) > margin));
    is_separated || {
        let side = |face: [usize; 2], corner: usize| pair.side(face, corner);
        let on_one_side = |face: [usize; 2], [p, q]: [usize; 2]| {
            side(face, p) != 0 && side(face, p) == side(face, q)
        };
        on_one_side([1, 2], [4, 5]) || on_one_side([4, 5], [1, 2])
    }
}

/// Whether two triangles have no more than the edge between their first two corners in common at any time, certainly.
///
/// Either they never are in one plane; or, seen along the edge, they never are less than a right angle apart: the product of their
/// normals, taken in the same sense, is negative. It is a quartic of time.
fn are_apart_at_edge(a: &MovingTriangle, b: &MovingTriangle) -> bool {
    let pair = MovingPair::new(a, b);
    if pair.side([1, 2], 5) != 0 {
        return true;
    }
    let ends = |corner: usize| pair.ends.map(|corners| corners[corner]);
    let [[a0, a1, a2], [b0, b1, b2]] = [2, 5].map(|corner| normal(ends(1), ends(corner)));
    let quartic = [
        a0.dot(b0),
        (a0.dot(b1) + a1.dot(b0)) * 0.25,
        (a0.dot(b2) + a1.dot(b1) + a2.dot(b0)) * (1.0 / 6.0),
        (a1.dot(b2) + a2.dot(b1)) * 0.25,
        a2.dot(b2),
    ];
    let [x, y, z] = (pair.ranges * pair.ranges).to_array();
    let margin = (x * y + y * z + z * x) * PRODUCT + UNDERFLOWN;
    quartic.iter().all(|c| *c < -margin)
}

impl MovingPair {
    /// The side of the plane through the first corner and two others on which another corner certainly is at all times; 0 if it is not
    /// known to be on one.
    fn side(&self, [p, q]: [usize; 2], corner: usize) -> i32 {
        let ends = |corner: usize| self.ends.map(|corners| corners[corner]);
        let cubic = height(&normal(ends(p), ends(q)), ends(corner));
        let margin = self.volume() * CUBIC + UNDERFLOWN;
        i32::from(cubic.iter().all(|c| *c > margin)) - i32::from(cubic.iter().all(|c| *c < -margin))
    }
}
