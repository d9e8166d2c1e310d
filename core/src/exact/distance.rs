//! Whether two features of two triangles are within a distance, in integers: exact for any coordinates that are in range.
//!
//! The distance of two closed triangles that do not intersect is that of two of their features: a vertex of each, a vertex and
//! an edge or the face, or an edge of each. Each test below holds only if it exhibits two points within the distance, and at
//! the minimum one of them holds. So the answer is their disjunction, whatever their order, and ties need no rule. With points
//! p of one feature, w leads from its first corner to that of the other; g and h are edges:
//!
//! - vertex and vertex: |w|² ≤ d²;
//! - vertex and edge: 0 ≤ w·g ≤ g·g, the foot is on the edge; |w×g|² ≤ d² g·g;
//! - vertex and face, and edge and edge, with n = g×h, s = (w×h)·n and t = (g×w)·n: the feet are w = (s g + t h)/n·n + ..., so
//!   they are in the face if s, t ≥ 0 and s + t ≤ n·n, and on both edges if s and −t are between 0 and n·n; (n·w)² ≤ d² n·n.
//!
//! A test whose g·g or n·n is 0 is left out: triangles without area and edges in parallel are covered by the others.
//!
//! Squares of different axes are added, so all axes and the distance are multiples of one power of two. With differences of
//! b bits, (n·w)² is below 2^(6b + 6).

use super::integer::{Axis, finest_bit};
use super::wide::Wide;
use crate::scalar::Scalar;

/// Limbs for coordinates of up to 40 bits, such as those of most meshes have.
const LIMBS: usize = 4;

/// Limbs for any f32: differences of 278 bits.
const LIMBS_IN_F32: usize = 27;

/// Limbs for f64 up to 2^128: differences of 1,203 bits.
const LIMBS_IN_F64: usize = 113;

/// Whether two features of `a` and `b` are at most `distance` apart. With triangles that do not intersect, that is whether these
/// are.
#[cold]
#[inline(never)]
pub(crate) fn features_are_within<C: Scalar>(
    a: &[[C; 3]; 3],
    b: &[[C; 3]; 3],
    distance: f32,
) -> bool {
    let axis = |k: usize| [a[0][k], a[1][k], a[2][k], b[0][k], b[1][k], b[2][k], C::from(distance)];
    let coordinates = [axis(0), axis(1), axis(2)];
    let finest = coordinates.as_flattened().iter().filter_map(finest_bit).min().unwrap_or(0);
    let axes = coordinates.map(|coordinates| Axis::in_units(coordinates, finest));
    let bits = axes.iter().map(Axis::bits).max().unwrap_or(0) + 1;
    let limbs = (6 * bits + 6).div_ceil(u64::BITS) as usize;
    if limbs <= LIMBS {
        any_within::<LIMBS>(&axes)
    } else if size_of::<C>() == size_of::<f32>() || limbs <= LIMBS_IN_F32 {
        any_within::<LIMBS_IN_F32>(&axes)
    } else {
        any_within::<LIMBS_IN_F64>(&axes)
    }
}

type Vector<const L: usize> = [Wide<L>; 3];

/// Points 0 to 2 are the corners of one triangle, 3 to 5 those of the other, and coordinate 6 is the distance.
#[inline(never)]
fn any_within<const L: usize>(axes: &[Axis<7>; 3]) -> bool {
    let between =
        |from: usize, to: usize| -> Vector<L> { [0, 1, 2].map(|k| axes[k].difference(from, to)) };
    let distance = axes[0].wide(6);
    let square = distance * distance;
    let vertices = |w: &Vector<L>| at_most(&dot(w, w), &square);
    let corners = |of: usize| (3 * of..3 * of + 3).map(move |k| (k, 3 * of + (k + 1) % 3));
    corners(0).any(|(p, _)| corners(1).any(|(q, _)| vertices(&between(p, q))))
        || [0, 1].into_iter().any(|of| {
            corners(of).any(|(o, next)| {
                let g = between(o, next);
                corners(1 - of).any(|(p, _)| edge_reaches(&g, &between(o, p), &square))
            })
        })
        || [0, 1].into_iter().any(|of| {
            let o = 3 * of;
            let (g, h) = (between(o, o + 1), between(o, o + 2));
            corners(1 - of)
                .any(|(p, _)| planes_reach(&g, &h, &between(o, p), &square, Feet::InFace))
        })
        || corners(0).any(|(o, next)| {
            let g = between(o, next);
            corners(1).any(|(p, last)| {
                planes_reach(&g, &between(p, last), &between(o, p), &square, Feet::OnEdges)
            })
        })
}

/// Where the nearest points of two features have to be.
enum Feet {
    InFace,
    OnEdges,
}

/// Whether a vertex is near the inner of an edge.
fn edge_reaches<const L: usize>(g: &Vector<L>, w: &Vector<L>, square: &Wide<L>) -> bool {
    let (length, along) = (dot(g, g), dot(w, g));
    if length.sign() == 0 || along.sign() < 0 || !at_most(&along, &length) {
        return false;
    }
    let across = cross(w, g);
    at_most(&dot(&across, &across), &(*square * length))
}

/// Whether a vertex is near a face with the edges `g` and `h`, or an edge along `g` near one along `h`.
fn planes_reach<const L: usize>(
    g: &Vector<L>,
    h: &Vector<L>,
    w: &Vector<L>,
    square: &Wide<L>,
    feet: Feet,
) -> bool {
    let n = cross(g, h);
    let (area, s, t) = (dot(&n, &n), dot(&cross(w, h), &n), dot(&cross(g, w), &n));
    let zero = Wide::new(0, 0);
    let are_inside = match feet {
        Feet::InFace => s.sign() >= 0 && t.sign() >= 0 && at_most(&(s + t), &area),
        Feet::OnEdges => {
            s.sign() >= 0 && at_most(&s, &area) && t.sign() <= 0 && at_most(&(zero - t), &area)
        }
    };
    if area.sign() == 0 || !are_inside {
        return false;
    }
    let height = dot(&n, w);
    at_most(&(height * height), &(*square * area))
}

fn at_most<const L: usize>(x: &Wide<L>, y: &Wide<L>) -> bool {
    (*y - *x).sign() >= 0
}

fn dot<const L: usize>(p: &Vector<L>, q: &Vector<L>) -> Wide<L> {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross<const L: usize>(p: &Vector<L>, q: &Vector<L>) -> Vector<L> {
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| p[j] * q[k] - p[k] * q[j])
}
