//! Triangles of one mesh: a vertex or edge that they share by index is not a contact.
//!
//! Two triangles of a mesh collide by the number of vertices they share, which holds for degenerate triangles too:
//!
//! - no shared vertex: the closed triangles intersect;
//! - one shared vertex: the rest of one, the hull of its other vertices, meets the other triangle;
//! - a shared edge: the triangles have a point in common that is not on the closed edge, which for
//!   triangles with area means that they lie in one plane on the same side of it;
//! - three shared vertices, or the same set of vertices: always a hit.
//!
//! Neighbours in a surface are far from intersecting. But a shared corner lies in both planes, and no filter certifies a
//! side that is zero. So a plane through the shared vertex or edge is tried first that separates all other corners, in f64
//! with an error bound of its own: see [`separated_at_vertex`] and [`separated_at_edge`].

use super::coplanar::{projection, segment_intersects, turn};
#[cfg(feature = "relation")]
use super::triangles_intersect;
use super::{intersects, intersects_in_f64};
use crate::Mesh;
use crate::exact::filter64::{UNDERFLOW_2D, UNDERFLOW_3D};
use crate::exact::{Exact, Orientation, difference};
use crate::scalar::Scalar;
use glam::DVec3;

/// The rule for triangles of one mesh that share vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Adjacency {
    /// All pairs, with the shared-index rule above.
    #[default]
    SharedIndexRule,
    /// Only pairs without a common vertex index.
    SkipNeighbours,
}

/// Whether triangles `i` and `j` of one mesh collide, exactly.
///
/// # Panics
/// If `i` or `j` is not a triangle of `mesh`.
///
/// # Examples
/// ```
/// use pfront_core::{Mesh, triangle::{Adjacency, intersects_in_mesh}};
/// // Two faces of a fold: they share an edge and nothing else.
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let fold = Mesh::new(&points, &[[0, 1, 2], [1, 0, 3]])?;
/// assert!(!intersects_in_mesh(fold, 0, 1, Adjacency::SharedIndexRule));
/// # Ok::<(), pfront_core::MeshError>(())
/// ```
#[must_use]
pub fn intersects_in_mesh(mesh: Mesh<'_>, i: u32, j: u32, adjacency: Adjacency) -> bool {
    if mesh.is_f64() {
        return intersects_in_mesh_f64(mesh, [i, j], adjacency);
    }
    match neighbours(mesh, [i, j], |vertex| mesh.shadow()[vertex as usize]) {
        None => intersects(&mesh.shadow_triangle(i), &mesh.shadow_triangle(j)),
        Some(_) if adjacency == Adjacency::SkipNeighbours => false,
        Some([a, b]) => neighbours_intersect::<Exact<f32>>(&a, &b) == Some(true),
    }
}

/// [`intersects_in_mesh`] of a mesh whose positions are in f64. Apart, so that the other does not take its stack.
#[inline(never)]
fn intersects_in_mesh_f64(mesh: Mesh<'_>, [i, j]: [u32; 2], adjacency: Adjacency) -> bool {
    match neighbours(mesh, [i, j], |vertex| mesh.position_f64(vertex)) {
        None => intersects_in_f64(&mesh.triangle_f64(i), &mesh.triangle_f64(j)),
        Some(_) if adjacency == Adjacency::SkipNeighbours => false,
        Some([a, b]) => neighbours_intersect::<Exact<f64>>(&a, &b) == Some(true),
    }
}

/// [`intersects_in_mesh`] of triangles whose vertices and corners these are.
#[cfg(feature = "relation")]
pub(crate) fn intersects_as_in_mesh<C: Scalar>(
    a: &([u32; 3], [[C; 3]; 3]),
    b: &([u32; 3], [[C; 3]; 3]),
) -> bool {
    let shared = shared_with(&b.0, &a.0);
    if shared == [false; 3] {
        return triangles_intersect::<Exact<C>>(&a.1, &b.1) == Some(true);
    }
    let neighbour = |t: &([u32; 3], [[C; 3]; 3]), shared| {
        let position = |vertex: u32| t.1[(0..2).find(|&k| t.0[k] == vertex).unwrap_or(2)];
        Neighbour::new(position, &t.0, shared)
    };
    let [a, b] = [neighbour(a, shared), neighbour(b, shared_with(&a.0, &b.0))];
    neighbours_intersect::<Exact<C>>(&a, &b) == Some(true)
}

/// Two triangles of a mesh, if they share a vertex.
#[inline]
pub(crate) fn neighbours<C: Scalar>(
    mesh: Mesh<'_>,
    triangles: [u32; 2],
    position: impl Fn(u32) -> [C; 3],
) -> Option<[Neighbour<C>; 2]> {
    let [a, b] = triangles.map(|triangle| &mesh.triangles()[triangle as usize]);
    let shared = shared_with(b, a);
    (shared != [false; 3]).then(|| {
        [Neighbour::new(&position, a, shared), Neighbour::new(&position, b, shared_with(a, b))]
    })
}

/// A triangle that shares a vertex with another one.
pub(crate) struct Neighbour<C> {
    /// Its vertices, shared ones first, each once and the last again if an index repeats.
    pub(crate) corners: [[C; 3]; 3],
    /// How many different vertices it shares.
    pub(crate) shared: usize,
    /// How many different vertices it has.
    pub(crate) distinct: usize,
}

impl<C: Scalar> Neighbour<C> {
    #[inline]
    fn new(position: impl Fn(u32) -> [C; 3], triangle: &[u32; 3], is_shared: [bool; 3]) -> Self {
        let (vertices, shared, distinct) = shared_first(triangle, is_shared);
        Self { corners: vertices.map(position), shared, distinct }
    }

    /// The segment or point of the vertices beside one that is shared.
    fn rest(&self) -> Option<[[C; 3]; 2]> {
        let [_, p, q] = self.corners;
        (self.distinct > 1).then_some([p, q])
    }
}

/// The vertices of `own` that `other` has too.
#[inline]
fn shared_with(other: &[u32; 3], own: &[u32; 3]) -> [bool; 3] {
    let [p, q, r] = *other;
    // All at once: three comparisons are cheaper than a jump that may be mispredicted.
    own.map(|v| (v == p) | (v == q) | (v == r))
}

/// Vertices, shared ones first; how many of them are shared; and how many there are.
#[inline]
fn shared_first(triangle: &[u32; 3], is_shared: [bool; 3]) -> ([u32; 3], usize, usize) {
    let [p, q, r] = *triangle;
    if (p == q) | (q == r) | (r == p) {
        return repeated_shared_first(triangle, is_shared);
    }
    let vertices = match is_shared {
        [_, false, true] => [r, p, q],
        [false, true, _] => [q, r, p],
        _ => [p, q, r],
    };
    (vertices, is_shared.map(usize::from).iter().sum(), 3)
}

/// [`shared_first`] of a triangle in which an index repeats.
#[cold]
fn repeated_shared_first(triangle: &[u32; 3], is_shared: [bool; 3]) -> ([u32; 3], usize, usize) {
    let [p, q, r] = *triangle;
    // Two corners with all the vertices there are.
    let ([u, v], [shared, other_shared]) = match is_shared {
        [x, _, y] if p == q => ([p, r], [x, y]),
        [x, y, _] => ([p, q], [x, y]),
    };
    let distinct = if u == v { 1 } else { 2 };
    let vertices = if shared { [u, v, v] } else { [v, u, u] };
    (vertices, distinct.min(usize::from(shared) + usize::from(other_shared)), distinct)
}

fn neighbours_intersect<K: Orientation>(a: &Neighbour<K::C>, b: &Neighbour<K::C>) -> Option<bool> {
    match a.shared {
        _ if [a.distinct, b.distinct] == [a.shared; 2] => Some(true),
        2 => edge_rule::<K>(&a.corners, &b.corners),
        _ => vertex_rule::<K>(a, b),
    }
}

/// The rule for one shared vertex, the first of both.
fn vertex_rule<K: Orientation>(a: &Neighbour<K::C>, b: &Neighbour<K::C>) -> Option<bool> {
    if separated_at_vertex(&a.corners, &b.corners) {
        return Some(false);
    }
    // With the rest of one strictly on one side of the other's plane, the planes cut each triangle in the
    // shared vertex alone: neighbours in a smooth surface end here.
    for (t, [_, p, q]) in [(b, &a.corners), (a, &b.corners)] {
        if let Some([p, q]) = K::orient3d(t.corners.each_ref(), [p, q])
            && p * q > 0
        {
            return Some(false);
        }
    }
    for (t, rest) in [(b, a.rest()), (a, b.rest())] {
        if let Some(rest) = rest
            && segment_intersects::<K>(rest, &t.corners)?
        {
            return Some(true);
        }
    }
    Some(false)
}

/// The rule for a shared edge, the first two corners of both.
fn edge_rule<K: Orientation>(a: &[[K::C; 3]; 3], b: &[[K::C; 3]; 3]) -> Option<bool> {
    let ([e, f, c], d) = (*a, b[2]);
    if separated_at_edge(a, &d) || K::orient3d([&e, &f, &c], [&d])? != [0] {
        return Some(false);
    }
    if let Some(p) = projection::<K>(&[e, f, c])? {
        return Some(turn::<K>(&[e, f, d], p.axis)? == p.turn);
    }
    // The first lies on the line of the edge. If the second does not, they meet in the edge alone, and so do
    // two segments in different directions from an edge without length.
    if projection::<K>(&[e, f, d])?.is_some() || projection::<K>(&[e, c, d])?.is_some() {
        return Some(false);
    }
    // All on one line: only past the same end of the edge do they have more in common.
    let (low, high) = if e < f { (e, f) } else { (f, e) };
    Some(c < low && d < low || c > high && d > high)
}

/// Whether a plane through the shared vertex, the first corner, certainly has all other corners of one
/// triangle strictly above it and those of the other below. This settles neighbours in one plane, which no
/// side of their own planes does.
///
/// Any plane will do; this one is normal to the directions of one triangle minus those of the other. Its height
/// over a corner is off by less than (1+u)^4 − 1 of the sum of the three products, u = 2^-53, and by 3 · 2^-1075 where they
/// underflow; the bound loses as little.
fn separated_at_vertex<C: Scalar>(a: &[[C; 3]; 3], b: &[[C; 3]; 3]) -> bool {
    let edges = [&a[1], &a[2], &b[1], &b[2]].map(|p| difference(p, &a[0]));
    // An edge without length has the direction NaN, and nothing is above such a plane.
    let [p, q, r, s] = edges.map(|e| e / e.abs().element_sum());
    let normal = (p + q) - (r + s);
    let is_above = |e: DVec3| normal.dot(e) - 4.5e-16 * normal.abs().dot(e.abs()) > UNDERFLOW_2D;
    is_above(edges[0]) && is_above(edges[1]) && is_above(-edges[2]) && is_above(-edges[3])
}

/// Whether triangle `a` and the corner `d` are certainly on different sides of the plane through the first
/// edge of `a` at a right angle to it, or as nearly so as comes out.
///
/// The six products of det(f − e, normal, x − e) are off by less than (1+u)^7 − 1 each. Any normal will do. Where they
/// underflow, the determinant loses 6 · 2^-1075 times the extent of x − e, and the bound as much, as in `filter64`: so
/// the extents are multiplied first there too.
fn separated_at_edge<C: Scalar>(a: &[[C; 3]; 3], d: &[C; 3]) -> bool {
    let [edge, c, d] = [&a[1], &a[2], d].map(|p| difference(p, &a[0]));
    let normal = edge.cross(c);
    let across = edge.cross(normal);
    let extent = edge.abs().max_element() * normal.abs().max_element();
    let bound = |x: DVec3| extent * x.abs().max_element() * 4.8e-15 + UNDERFLOW_3D;
    let [c, d] = [c, d].map(|x| (across.dot(x), bound(x)));
    // Away from c by construction: across·c = (edge·c)² − edge²·c² ≤ 0.
    c.0 < -c.1 && d.0 > d.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Point;
    use pfront_testkit::families::Family;
    use pfront_testkit::oracle::self_hit;
    use pfront_testkit::rng::{RngExt, seeded};

    const RULE: Adjacency = Adjacency::SharedIndexRule;

    #[test]
    fn neighbours_as_the_oracle() {
        let mut rng = seeded(12);
        for family in Family::ALL {
            for _ in 0..if cfg!(miri) { 2 } else { 150 } {
                let (positions, a, b) = family.indexed(&mut rng);
                let triangles = [a, b];
                let mesh = Mesh::new(&positions, &triangles).unwrap();
                let found = intersects_in_mesh(mesh, 0, 1, RULE);
                let truth = self_hit(a, b, &positions);
                assert_eq!(found, truth, "{family:?} {positions:?} {triangles:?}");
            }
        }
    }

    /// All six corners on one line.
    #[test]
    fn segments_on_one_line_as_the_oracle() {
        let mut rng = seeded(13);
        for _ in 0..if cfg!(miri) { 20 } else { 4_000 } {
            let direction = [0; 3].map(|_| rng.random_range(-2..=2_i8));
            let positions: [Point; 6] = [0; 6].map(|_| {
                let step = rng.random_range(0..5_i8);
                direction.map(|x| f32::from(step * x))
            });
            let triangles = [0; 2].map(|_| [0; 3].map(|_| rng.random_range(0..6)));
            let mesh = Mesh::new(&positions, &triangles).unwrap();
            let truth = self_hit(triangles[0], triangles[1], &positions);
            let found = intersects_in_mesh(mesh, 0, 1, RULE);
            assert_eq!(found, truth, "{positions:?} {triangles:?}");
        }
    }

    /// Triangles with edges of one direction from the shared corner, which no plane separates: the height of these edges
    /// over a plane normal to the difference of the other two is nothing but rounding errors.
    #[test]
    fn rounding_errors_do_not_separate_at_a_vertex() {
        let mut rng = seeded(14);
        for round in 0..if cfg!(miri) { 20 } else { 20_000 } {
            let size = [1e-9, 1.0, 1e9][round % 3];
            let mut third = || size * rng.random_range(1..1 << 22) as f32;
            let (x, y) = (third(), third());
            let edge = [[x; 3], [3.0 * x; 3]];
            let positions =
                [[0.0; 3], edge[0], [x, y, third()], edge[1], [third(), x, y], [y, third(), x]];
            let [a, b] = [[0, 1, 2], [0, 3, 4 + rng.random_range(0..2)]];
            let corners = [a, b].map(|t: [usize; 3]| t.map(|v| positions[v]));
            assert!(!separated_at_vertex(&corners[0], &corners[1]), "{corners:?}");
        }
        // Equal directions make a plane without a normal.
        let ([x, y], [far_x, far_y]) =
            ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        assert!(!separated_at_vertex(&[[0.0; 3], x, y], &[[0.0; 3], far_x, far_y]));
    }

    /// Neighbours in one plane, which no side of their own planes tells apart.
    #[test]
    fn neighbours_in_a_plane_are_separated() {
        let [o, x, y] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let opposite = [o, [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        assert!(separated_at_vertex(&[o, x, y], &opposite));
        assert!(separated_at_vertex(&[o, x.map(|c| 1e6 * c), y], &opposite));
        for (c, d, expected) in [(y, [0.5, -1.0, 0.0], true), (y, [0.5, 1.0, 0.0], false)] {
            for size in [1e-12, 1.0, 1e12] {
                let [x, c, d] = [x, c, d].map(|p| p.map(|coordinate| size * coordinate));
                assert_eq!(separated_at_edge(&[o, x, c], &d), expected, "{size}");
                assert!(!separated_at_edge(&[o, x, c], &x), "a corner on the plane");
            }
        }
    }
}
