//! Triangles of one mesh: what they share by index is not a contact.
//!
//! The rule of `accuracy.md` (contract 4), made precise where triangles have no area:
//!
//! - no shared index: the closed triangles meet;
//! - one shared vertex: the rest of one, the hull of its corners that are not shared, meets the
//!   other triangle;
//! - a shared edge: the triangles have a point in common that is not on the closed edge, which for
//!   triangles with area means that they lie in one plane on the same side of it;
//! - three shared vertices, or the same set of vertices: always a hit.

use super::coplanar::{order, proper, segment_meets};
use super::{Accuracy, certain, intersects};
use crate::Mesh;
use crate::exact::{Exact, Fast, Filtered, Kernel, Point, difference};
use crate::index::at;
use core::cmp::Ordering;
use glam::DVec3;

/// Which pairs of triangles of one mesh a self-collision query looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Adjacency {
    /// All pairs, with the shared-index rule above.
    #[default]
    SharedIndexRule,
    /// Only pairs without a common vertex index.
    SkipNeighbours,
}

/// Whether triangles `i` and `j` of one mesh collide.
///
/// # Panics
/// With the feature `std`, if `i` or `j` is not a triangle of `mesh`.
///
/// # Examples
/// ```
/// use pfront_core::{Mesh, triangle::{Accuracy, Adjacency, intersects_in_mesh}};
/// // Two faces of a fold: they share an edge and nothing else.
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let fold = Mesh::new(&points, &[[0, 1, 2], [1, 0, 3]])?;
/// assert!(!intersects_in_mesh(fold, 0, 1, Adjacency::SharedIndexRule, Accuracy::Exact));
/// # Ok::<(), pfront_core::MeshError>(())
/// ```
#[must_use]
pub fn intersects_in_mesh(
    mesh: Mesh<'_>,
    i: u32,
    j: u32,
    adjacency: Adjacency,
    accuracy: Accuracy,
) -> bool {
    let (own, other) = (at(mesh.triangles(), i), at(mesh.triangles(), j));
    let shared = shared_with(other, own);
    if shared == [false; 3] {
        return intersects(&mesh.triangle(i), &mesh.triangle(j), accuracy);
    }
    if adjacency == Adjacency::SkipNeighbours {
        return false;
    }
    let pair = Pair::new(mesh, [own, other], [&shared, &shared_with(own, other)]);
    match accuracy {
        Accuracy::Exact => certain(pair.hit::<Exact>()),
        Accuracy::Conservative => pair.hit::<Filtered>().unwrap_or(true),
        Accuracy::Fast => certain(pair.hit::<Fast>()),
    }
}

/// Two triangles that share a vertex, with their shared corners first.
struct Pair {
    a: [Point; 3],
    b: [Point; 3],
    /// How many different vertices they share.
    shared: usize,
    /// How many corners of each are shared vertices (more if an index repeats).
    corners: [usize; 2],
}

impl Pair {
    fn new(mesh: Mesh<'_>, triangles: [&[u32; 3]; 2], are_shared: [&[bool; 3]; 2]) -> Self {
        let (a, shared, m) = shared_first(triangles[0], are_shared[0]);
        let (b, _, n) = shared_first(triangles[1], are_shared[1]);
        let points = |t: [u32; 3]| t.map(|vertex| *at(mesh.positions(), vertex));
        Self { a: points(a), b: points(b), shared, corners: [m, n] }
    }

    fn hit<K: Kernel>(&self) -> Result<bool, K::Undecided> {
        let Self { a, b, shared, corners } = self;
        match (shared, corners) {
            (3, _) | (_, [3, 3]) => Ok(true),
            (2, _) => edge_rule::<K>(a, b),
            _ => vertex_rule::<K>(a, b, *corners),
        }
    }
}

/// Which indices of `own` the other triangle has too.
#[inline]
fn shared_with(other: &[u32; 3], own: &[u32; 3]) -> [bool; 3] {
    let [p, q, r] = *other;
    // All at once: three comparisons are cheaper than a jump that may be mispredicted.
    let has = |v: u32| (v == p) | (v == q) | (v == r);
    [has(own[0]), has(own[1]), has(own[2])]
}

/// The indices of a triangle, shared ones first, each of them once before repeats; how many different
/// ones these are; and how many corners have one of them.
#[inline]
fn shared_first(own: &[u32; 3], shared: &[bool; 3]) -> ([u32; 3], usize, usize) {
    let [p, q, r] = *own;
    if (p == q) | (q == r) | (r == p) {
        return repeated_shared_first(own, shared);
    }
    let corners = [p, q, r, r];
    let [p, q, r] = [usize::from(shared[0]), usize::from(shared[1]), usize::from(shared[2])];
    let first = SHARED_FIRST[(4 * p + 2 * q + r) % 8].map(|corner| corners[corner % 4]);
    (first, p + q + r, p + q + r)
}

/// Corners with those that are shared first, by whether the first, the second and the third are.
const SHARED_FIRST: [[usize; 3]; 8] =
    [[0, 1, 2], [2, 0, 1], [1, 2, 0], [1, 2, 0], [0, 1, 2], [0, 2, 1], [0, 1, 2], [0, 1, 2]];

#[cold]
fn repeated_shared_first(own: &[u32; 3], shared: &[bool; 3]) -> ([u32; 3], usize, usize) {
    let rank = |shared: bool, repeats: bool| match (shared, repeats) {
        (true, false) => 0,
        (true, true) => 1,
        (false, _) => 2,
    };
    let ([p, q, r], [first, second, third]) = (*own, *shared);
    let ranks = [rank(first, false), rank(second, q == p), rank(third, r == p || r == q)];
    let mut ordered = [0; 3];
    let by_rank = (0..3).flat_map(|rank| own.iter().zip(&ranks).filter(move |of| *of.1 == rank));
    for (slot, (index, _)) in ordered.iter_mut().zip(by_rank) {
        *slot = *index;
    }
    let up_to = |most: u32| ranks.iter().filter(|rank| **rank <= most).count();
    (ordered, up_to(0), up_to(1))
}

/// One common vertex, in the first corner of both.
fn vertex_rule<K: Kernel>(
    a: &[Point; 3],
    b: &[Point; 3],
    corners: [usize; 2],
) -> Result<bool, K::Undecided> {
    if corners == [1, 1] && parted_at_vertex(a, b) {
        return Ok(false);
    }
    // With both free corners of one strictly on one side of the other's plane, the planes cut each
    // triangle in the common vertex alone: neighbours in a smooth surface end here.
    for (t, free) in [(b, a), (a, b)] {
        if let Ok([p, q]) = K::sides(t, [&free[1], &free[2]])
            && p * q > 0
        {
            return Ok(false);
        }
    }
    for (t, own, corners) in [(b, a, corners[0]), (a, b, corners[1])] {
        // A repeated index leaves a point, or nothing, of the opposite edge.
        let rest = match corners {
            1 => [own[1], own[2]],
            2 => [own[2], own[2]],
            _ => continue,
        };
        if segment_meets::<K>(rest, t)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether some plane through the common vertex, the first corner, surely parts two triangles: all other
/// corners of one are strictly above it and those of the other below. That settles neighbours in a
/// plane, which no side of their own planes does.
///
/// The plane may be any; this one is normal to the directions of one triangle minus those of the other.
/// Its height over a corner is off by less than (1+u)^4 − 1 of the sum of the three products, u = 2^-53.
fn parted_at_vertex(a: &[Point; 3], b: &[Point; 3]) -> bool {
    let edges = [&a[1], &a[2], &b[1], &b[2]].map(|p| difference(p, &a[0]));
    // An edge of no length has a direction that is no number, and nothing is above such a plane.
    let [p, q, r, s] = edges.map(|e| e / e.abs().element_sum());
    let normal = (p + q) - (r + s);
    let least = |e: DVec3| normal.dot(e) - 4.5e-16 * normal.abs().dot(e.abs());
    least(edges[0]) > 0.0
        && least(edges[1]) > 0.0
        && least(-edges[2]) > 0.0
        && least(-edges[3]) > 0.0
}

/// Whether the triangle `a` and the corner `d` are surely on different sides of the plane through the
/// first edge of `a` at a right angle to it, or as nearly so as comes out.
///
/// The six products of det(f − e, normal, x − e) are off by less than (1+u)^7 − 1 each.
fn parted_at_edge(a: &[Point; 3], d: &Point) -> bool {
    let [edge, c, d] = [&a[1], &a[2], d].map(|p| difference(p, &a[0]));
    let normal = edge.cross(c);
    let across = edge.cross(normal);
    let unit = 4.8e-15 * edge.abs().max_element() * normal.abs().max_element();
    let sure = |x: DVec3| {
        let height = across.dot(x);
        if height.abs() > unit * x.abs().max_element() { height } else { 0.0 }
    };
    sure(c) * sure(d) < 0.0
}

/// A common edge e–f in the first two corners of both; `c` and `d` are the third corners.
fn edge_rule<K: Kernel>(a: &[Point; 3], b: &[Point; 3]) -> Result<bool, K::Undecided> {
    let ([e, f, c], d) = (*a, b[2]);
    if parted_at_edge(a, &d) {
        return Ok(false);
    }
    if K::orient3d(&e, &f, &c, &d)? != 0 {
        return Ok(false);
    }
    match (proper::<K>(&[e, f, c])?, proper::<K>(&[e, f, d])?) {
        (Some(p), Some(_)) => {
            let [c, d] = [&c, &d].map(|x| K::orient2d(p.axes, &e, &f, x));
            Ok(c? == d?)
        }
        // One lies on the line of the edge, which the other meets in the edge alone.
        (Some(_), None) | (None, Some(_)) => Ok(false),
        // All on one line, unless e = f; past the edge only if both go the same way.
        (None, None) => {
            if proper::<K>(&[e, c, d])?.is_some() {
                return Ok(false);
            }
            let (low, high) = if order(&e, &f).is_le() { (e, f) } else { (f, e) };
            let past = |x: &Point| match (order(x, &low), order(x, &high)) {
                (Ordering::Less, _) => -1,
                (_, Ordering::Greater) => 1,
                _ => 0,
            };
            Ok(past(&c) != 0 && past(&c) == past(&d))
        }
    }
}
