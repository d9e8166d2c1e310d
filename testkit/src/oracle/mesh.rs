//! Brute force over meshes, with the rule for triangles of one mesh.

use super::lattice::{Coordinate, Integer, Vector, cross, dot, minus};
use super::{hulls_meet, intersect, lattice};
use crate::{Point, Triangle};
use num_traits::Zero;

/// All pairs of triangles of two meshes that share a point, sorted.
///
/// # Panics
/// If an index is out of range.
pub fn pairs(
    a_positions: &[Point],
    a_triangles: &[[u32; 3]],
    b_positions: &[Point],
    b_triangles: &[[u32; 3]],
) -> Vec<(u32, u32)> {
    let mut all = corners(a_triangles, a_positions);
    all.extend(corners(b_triangles, b_positions));
    let n = a_triangles.len();
    let mut found = Vec::new();
    sweep(&all, |i, j| {
        if i < n && j >= n && intersect(&all[i], &all[j]) {
            found.push((i as u32, (j - n) as u32));
        }
    });
    found.sort_unstable();
    found
}

/// All pairs i < j of triangles of one mesh that hit each other by the rule of [`self_hit`], sorted.
///
/// # Panics
/// If an index is out of range.
pub fn self_pairs(positions: &[Point], triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let mut found = Vec::new();
    sweep(&corners(triangles, positions), |i, j| {
        if self_hit(triangles[i], triangles[j], positions) {
            found.push((i as u32, j as u32));
        }
    });
    found.sort_unstable();
    found
}

/// Whether two triangles of one mesh hit each other, what they share by index being no contact.
///
/// With S the set of the vertices that both have:
/// - S is empty: they share a point;
/// - S has three vertices, or holds all vertices of both: always;
/// - S is an edge: they share a point outside this closed edge;
/// - S is a vertex: the hull of the other vertices of one (none, a point or an edge) shares a point
///   with the other triangle.
///
/// # Panics
/// If an index is out of range.
pub fn self_hit<C: Coordinate>(ta: [u32; 3], tb: [u32; 3], positions: &[[C; 3]]) -> bool {
    let point = |v: &u32| positions[*v as usize];
    let rest = |own: [u32; 3], other: [u32; 3]| -> Vec<[C; 3]> {
        own.iter().filter(|v| !other.contains(v)).map(point).collect()
    };
    let mut shared: Vec<u32> = ta.into_iter().filter(|v| tb.contains(v)).collect();
    shared.sort_unstable();
    shared.dedup();
    let (rest_a, rest_b) = (rest(ta, tb), rest(tb, ta));
    let [a, b] = [ta, tb].map(|t| t.map(|v| point(&v)));

    match (&shared[..], &rest_a[..], &rest_b[..]) {
        ([], _, _) => intersect(&a, &b),
        ([_, _, _], _, _) | (_, [], []) => true,
        // With both its vertices in S, one triangle is no more than the edge.
        ([_, _], [], _) | ([_, _], _, []) => false,
        ([e, f], [c, ..], [d, ..]) => {
            let (edge, tips) = ([point(e), point(f)], [*c, *d]);
            match lattice::small(&edge, &tips) {
                Some([edge, tips]) => beyond_edge(&edge, &tips),
                None => {
                    let [edge, tips] = lattice::wide(&edge, &tips);
                    beyond_edge(&edge, &tips)
                }
            }
        }
        _ => hulls_meet(&rest_a, &b) || hulls_meet(&rest_b, &a),
    }
}

/// Whether two triangles share a vertex by index.
pub fn share_a_vertex(ta: [u32; 3], tb: [u32; 3]) -> bool {
    ta.iter().any(|v| tb.contains(v))
}

/// Whether hull(e, f, c) and hull(e, f, d) share a point outside the closed edge from e to f.
///
/// Around an edge with length, a triangle is half a plane: they share more exactly if these are the
/// same, or, where c and d are on the line of the edge, if both go past the same end of it. An edge
/// without length leaves two segments from e, which share more exactly if they point the same way.
fn beyond_edge<T: Integer>(edge: &[Vector<T>], tips: &[Vector<T>]) -> bool {
    let same_way = |u: &Vector<T>, v: &Vector<T>| is_zero(&cross(u, v)) && dot(u, v) > T::zero();
    let along = minus(&edge[1], &edge[0]);
    let from_end = |end: usize| [0, 1].map(|tip: usize| minus(&tips[tip], &edge[end]));
    let [c, d] = from_end(0);
    if is_zero(&along) {
        return same_way(&c, &d);
    }
    let [across_c, across_d] = [&c, &d].map(|tip| cross(&along, tip));
    let past = |ahead: [T; 2]| ahead.iter().all(|x| *x > T::zero());
    same_way(&across_c, &across_d)
        || is_zero(&across_c)
            && is_zero(&across_d)
            && (past(from_end(1).map(|tip| dot(&along, &tip)))
                || past([c, d].map(|tip| T::zero() - dot(&along, &tip))))
}

fn is_zero<T: Integer>(v: &Vector<T>) -> bool {
    v.iter().all(Zero::is_zero)
}

fn corners(triangles: &[[u32; 3]], positions: &[Point]) -> Vec<Triangle> {
    triangles.iter().map(|t| t.map(|v| positions[v as usize])).collect()
}

/// Visits all pairs i < j of triangles whose boxes meet: a sweep along x.
fn sweep(triangles: &[Triangle], mut visit: impl FnMut(usize, usize)) {
    let boxes: Vec<_> = triangles.iter().map(|t| [0, 1, 2].map(|axis| range(t, axis))).collect();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_unstable_by(|&i, &j| boxes[i][0].0.total_cmp(&boxes[j][0].0));
    let mut open: Vec<usize> = Vec::new();
    for i in order {
        open.retain(|&j| boxes[j][0].1 >= boxes[i][0].0);
        let meet = |&&j: &&usize| {
            let mut axes = boxes[i].iter().zip(&boxes[j]);
            axes.all(|(s, t)| s.0 <= t.1 && t.0 <= s.1)
        };
        open.iter().filter(meet).for_each(|&j| visit(i.min(j), i.max(j)));
        open.push(i);
    }
}

fn range(t: &Triangle, axis: usize) -> (f32, f32) {
    let [x, y, z] = t.map(|p| p[axis]);
    (x.min(y).min(z), x.max(y).max(z))
}
