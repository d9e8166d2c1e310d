//! Whether triangles in lanes are within a distance, as far as f32 certifies it.
//!
//! First near points x and y of both triangles are found, by any means; then they have to prove it:
//!
//! - *within*: |x − y| and its error are at most the distance;
//! - *beyond*: along y − x, the second triangle begins farther behind the first than the distance and the error.
//!
//! Bad divisions, NaN and a pair of features that is not the nearest cost a decision so, and never make a wrong one. Open pairs
//! go to [`crate::triangle`].
//!
//! # The bounds
//! Coordinates are taken from a corner of the pair, and scaled by a power of two so that those of the leaf pair are about 1 at
//! most; let R be the largest of the pair, and 2^-20 at least, and u = 2^-24.
//!
//! The points are x = p + s g (+ t h) with s and t from 0 to 1 and s + t at most 1 + u, whatever their errors. A coordinate
//! relative to the corner is off by u R, an edge by 4 u R, a product and a sum by 3 u R more a term, and s + t may exceed 1
//! by u: a coordinate of x − y by less than 20 u R, and |x − y| by less than 35 u R. A height n·b − n·a is off by less than
//! 7 u |n| R, and the difference of two by 18 u |n| R. The margins, 72 u R, leave room. Squares are compared, since that takes no
//! roots, with a relative margin of 16 u and 32 u, more than their roundings. Nothing underflows to matter: |n| must be at least
//! 2^-20, and the bound that it is compared with 72 u 2^-20, above 2^-38.
//!
//! If corners are shadows of others in f64, the difference of two is off by an error e more on each axis, and both the distance of
//! feasible points and the heights over |n| by at most |e|.

use crate::simd::Simd;
use crate::simd::point8::{abs, cross, difference, dot, highest, select, sum};

/// 72 u.
const MARGIN: f32 = 72.0 * UNIT;
/// u of f32.
pub(super) const UNIT: f32 = 5.960_464_5e-8;

/// 2^20: beyond it, squares might overflow.
pub(super) const MOST: f32 = 1_048_576.0;

/// 2^-20: the least extent that margins are made for, and the least length of a direction.
pub(super) const LEAST: f32 = 9.536_743e-7;

/// The question of each pair in lanes, in units in which coordinates are about 1 at most.
#[derive(Clone, Copy)]
pub(super) struct Reach<S> {
    /// The factor of coordinates: a power of two.
    pub(super) scale: S,
    /// The distance, multiplied by it.
    pub(super) distance: S,
    /// How far the difference of two points may be from that of what they stand for, multiplied by it.
    pub(super) error: S,
}

/// Lanes in which the triangles are certainly within the distance, and lanes in which they are certainly beyond it.
#[inline(always)]
pub(super) fn certify<S: Simd>(a: [[S; 3]; 3], b: [[S; 3]; 3], reach: &Reach<S>) -> [u32; 2] {
    let (zero, origin, scale) = (S::splat(0.0), a[0], reach.scale);
    let [p, q] = [relative(a[1], origin, scale), relative(a[2], origin, scale)];
    let [u, v] = [relative(b[0], origin, scale), relative(b[1], origin, scale)];
    let (a, b) = ([[zero; 3], p, q], [u, v, relative(b[2], origin, scale)]);
    let z = between(&a, &b);
    let [mut extent, rest] = [highest(abs(a[1]), abs(a[2])), highest(abs(b[0]), abs(b[1]))];
    extent = highest(highest(extent, rest), abs(b[2]));
    let extent = extent[0].max(extent[1]).max(extent[2].max(S::splat(LEAST)));
    let error = extent * S::splat(MARGIN) + reach.error;
    let square = dot(z, z);

    let most = reach.distance - error;
    let is_within = zero.le(most) & (square * S::splat(1.0 + 16.0 * UNIT)).le(most * most);

    let least = reach.distance + error;
    let (p, q, r) = (zero, dot(z, a[1]), dot(z, a[2]));
    let (u, v, w) = (dot(z, b[0]), dot(z, b[1]), dot(z, b[2]));
    // From x to y, heights are along −z.
    let gap = p.min(q).min(r) - u.max(v).max(w);
    let bound = square * (least * least) * S::splat(1.0 + 32.0 * UNIT);
    let holds = S::splat(LEAST * LEAST).le(square) & extent.le(S::splat(MOST)) & zero.le(gap);
    let is_beyond = holds & bound.le(gap * gap);
    [S::bits(is_within), S::bits(is_beyond)]
}

/// x − y for near points x and y of two triangles: the nearest but for rounding, unless they intersect.
#[inline(always)]
pub(super) fn between<S: Simd>(a: &[[S; 3]; 3], b: &[[S; 3]; 3]) -> [S; 3] {
    let (of_a, of_b) = (edges(a), edges(b));
    let mut best = Best { z: difference(a[0], b[0]), square: S::splat(f32::INFINITY) };
    for k in 0..3 {
        let edge = Edge::new(a[k], of_a[k]);
        for l in 0..3 {
            best.take(between_edges(&edge, &Edge::new(b[l], of_b[l])));
        }
    }
    let minus_one = S::splat(-1.0);
    let face_a = Face::new(a[0], of_a[0], scaled(of_a[2], minus_one));
    let face_b = Face::new(b[0], of_b[0], scaled(of_b[2], minus_one));
    for k in 0..3 {
        best.take(face_a.to_point(b[k]));
        best.take(scaled(face_b.to_point(a[k]), minus_one));
    }
    best.z
}

/// The shortest of some vectors.
struct Best<S> {
    z: [S; 3],
    square: S,
}

impl<S: Simd> Best<S> {
    #[inline(always)]
    fn take(&mut self, z: [S; 3]) {
        let square = dot(z, z);
        let is_shorter = square.le(self.square);
        self.z = select(&is_shorter, z, self.z);
        self.square = S::select(&is_shorter, square, self.square);
    }
}

/// A segment from `p` along `g`, and 1 / g·g.
struct Edge<S> {
    p: [S; 3],
    g: [S; 3],
    inverse: S,
}

impl<S: Simd> Edge<S> {
    #[inline(always)]
    fn new(p: [S; 3], g: [S; 3]) -> Self {
        Self { p, g, inverse: S::splat(1.0) / dot(g, g) }
    }
}

/// x − y for the nearest points of two segments (Ericson, *Real-Time Collision Detection*, 5.1.9). Segments in parallel have
/// some of them.
#[inline(always)]
fn between_edges<S: Simd>(a: &Edge<S>, b: &Edge<S>) -> [S; 3] {
    let (g, h, w) = (a.g, b.g, difference(a.p, b.p));
    let (gg, gh, hh, gw, hw) = (dot(g, g), dot(g, h), dot(h, h), dot(g, w), dot(h, w));
    let s = clamped((gh * hw - gw * hh) / (gg * hh - gh * gh));
    let t = clamped((gh * s + hw) * b.inverse);
    let s = clamped((gh * t - gw) * a.inverse);
    difference(sum(w, scaled(g, s)), scaled(h, t))
}

/// A triangle as its first corner and the edges from it, with the products that its nearest points take.
struct Face<S> {
    p: [S; 3],
    g: [S; 3],
    h: [S; 3],
    gg: S,
    gh: S,
    hh: S,
    /// 1 over the determinant of these products.
    inverse: S,
}

impl<S: Simd> Face<S> {
    #[inline(always)]
    fn new(p: [S; 3], g: [S; 3], h: [S; 3]) -> Self {
        let (gg, gh, hh) = (dot(g, g), dot(g, h), dot(h, h));
        let n = cross(g, h);
        Self { p, g, h, gg, gh, hh, inverse: S::splat(1.0) / dot(n, n) }
    }

    /// x − y for a point y and a point x of the face that is near it; the nearest if that is inside.
    #[inline(always)]
    fn to_point(&self, y: [S; 3]) -> [S; 3] {
        let w = difference(y, self.p);
        let (gw, hw) = (dot(self.g, w), dot(self.h, w));
        let s = clamped((self.hh * gw - self.gh * hw) * self.inverse);
        let t = clamped((self.gg * hw - self.gh * gw) * self.inverse);
        let t = t.min(S::splat(1.0) - s);
        difference(sum(scaled(self.g, s), scaled(self.h, t)), w)
    }
}

/// The edges of a triangle, from each corner to the next.
#[inline(always)]
fn edges<S: Simd>(t: &[[S; 3]; 3]) -> [[S; 3]; 3] {
    [difference(t[1], t[0]), difference(t[2], t[1]), difference(t[0], t[2])]
}

/// A point relative to another, scaled.
#[inline(always)]
pub(super) fn relative<S: Simd>(p: [S; 3], origin: [S; 3], scale: S) -> [S; 3] {
    scaled(difference(p, origin), scale)
}

#[inline(always)]
fn scaled<S: Simd>(v: [S; 3], factor: S) -> [S; 3] {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// Between 0 and 1.
#[inline(always)]
fn clamped<S: Simd>(x: S) -> S {
    x.min(S::splat(1.0)).max(S::splat(0.0))
}
