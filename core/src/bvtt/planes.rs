//! The triangle test of [`crate::triangle`] for the pairs of eight triangles with another one, side by side.
//!
//! The steps are those of `triangles_intersect`, with signs that f32 certifies by the bound of
//! [`crate::exact::filter32`]. Pairs for which one of the signs is uncertain are left to that test.

use super::block::TriangleBlock;
use crate::exact::filter32::{ERROR, MAX_EXTENT, UNDERFLOW};
use crate::simd::Simd;
use crate::simd::point8::{abs, cross, difference, dot, highest, load, select, splat};

/// A triangle in each lane, with its supporting plane.
pub(super) struct Planes<S> {
    corners: [[S; 3]; 3],
    vertices: [S; 3],
    normal: [S; 3],
    extent: [S; 3],
}

impl<S: Simd> Planes<S> {
    /// The triangles of a block in the lanes from `at` on.
    #[inline(always)]
    pub(super) fn load(block: &TriangleBlock, at: usize) -> Self {
        let [p, q, r] = &block.corners;
        Self {
            corners: [load(p, at), load(q, at), load(r, at)],
            vertices: load(&block.vertices, at),
            normal: load(&block.normal, at),
            extent: load(&block.extent, at),
        }
    }

    /// One triangle of a block in every lane.
    #[inline(always)]
    pub(super) fn splat(block: &TriangleBlock, lane: usize) -> Self {
        let [p, q, r] = &block.corners;
        Self {
            corners: [splat(p, lane), splat(q, lane), splat(r, lane)],
            vertices: splat(&block.vertices, lane),
            normal: splat(&block.normal, lane),
            extent: splat(&block.extent, lane),
        }
    }

    /// For each corner of `other`, the lanes in which this triangle has the same vertex.
    #[inline(always)]
    fn shared(&self, other: &Self) -> [S::Mask; 3] {
        let [p, q, r] = self.vertices;
        let [u, v, w] = other.vertices;
        [u.eq(p) | u.eq(q) | u.eq(r), v.eq(p) | v.eq(q) | v.eq(r), w.eq(p) | w.eq(q) | w.eq(r)]
    }

    /// The heights of the corners of `other` over this plane.
    #[inline(always)]
    pub(super) fn heights(&self, other: &Self) -> Heights<S> {
        let (base, [p, q, r]) = (self.corners[0], other.corners);
        let (p, q, r) = (difference(p, base), difference(q, base), difference(r, base));
        let extent = highest(highest(self.extent, abs(p)), highest(abs(q), abs(r)));
        let of = [dot(self.normal, p), dot(self.normal, q), dot(self.normal, r)];
        Heights { of, bound: error_bound(extent) }
    }

    /// Lanes in which this plane certainly has all corners of `other`, whose `heights` these are, strictly on one side. If
    /// there are `neighbours`, corners that both triangles share do not count, but there must be others.
    #[inline(always)]
    pub(super) fn separates<const SELF: bool>(
        &self,
        other: &Self,
        heights: &Heights<S>,
        neighbours: u32,
    ) -> u32 {
        if SELF && neighbours != 0 {
            heights.unshared_on_one_side(self.shared(other))
        } else {
            heights.between(heights.of, heights.of)
        }
    }

    /// Lanes in which this triangle certainly intersects `other`, and lanes in which it certainly does not, where neither
    /// plane separates the two. `own` are the heights of this triangle over the plane of `other`, and `others` those of
    /// `other` over this plane.
    ///
    /// That two signs decide is proved at `intervals_overlap` of [`crate::triangle`].
    #[inline(always)]
    pub(super) fn decide(&self, other: &Self, own: &Heights<S>, others: &Heights<S>) -> [u32; 2] {
        let ([a0, a1, a2], delta, own_known) = own.arrange(self.corners);
        let ([b0, b1, b2], epsilon, others_known) = others.arrange(other.corners);
        let same_side = delta.eq(epsilon);
        let (b1, b2) = (select(&same_side, b1, b2), select(&same_side, b2, b1));
        let (first, second) = (orientation(a0, a1, b0, b1), orientation(a0, a2, b0, b2));
        let first = Sign::new(first.0 * epsilon, first.1);
        let second = Sign::new(second.0 * epsilon, second.1);
        let known = S::bits(own_known & others_known);
        let meet = S::bits(first.negative & second.positive);
        let apart = S::bits(first.positive | second.negative);
        [known & meet, known & apart]
    }
}

/// How high the corners of a triangle are above a plane, times the length of the plane's normal.
pub(super) struct Heights<S> {
    of: [S; 3],
    bound: S,
}

impl<S: Simd> Heights<S> {
    /// Lanes in which all corners that are not `shared` are certainly on one side of the plane; there must be one.
    #[inline(always)]
    fn unshared_on_one_side(&self, shared: [S::Mask; 3]) -> u32 {
        let [mut low, mut high] = [self.of; 2];
        for k in 0..3 {
            low[k] = S::select(&shared[k], S::splat(f32::INFINITY), low[k]);
            high[k] = S::select(&shared[k], S::splat(f32::NEG_INFINITY), high[k]);
        }
        let [p, q, r] = shared;
        self.between(low, high) & !S::bits(p & q & r)
    }

    /// Lanes in which the lowest or the highest of some heights certainly have the sign of all.
    #[inline(always)]
    fn between(&self, [p, q, r]: [S; 3], [x, y, z]: [S; 3]) -> u32 {
        let (low, high) = (p.min(q).min(r), x.max(y).max(z));
        S::bits(self.bound.le(low) | high.le(S::splat(0.0) - self.bound))
    }

    /// The `corners` from the apex on, the side of the apex as 1 or −1, and the lanes in which all sides are known. Corners
    /// must be on both sides.
    #[inline(always)]
    fn arrange(&self, [p, q, r]: [[S; 3]; 3]) -> ([[S; 3]; 3], S, S::Mask) {
        let [of_p, of_q, of_r] = self.of;
        let of_p = Sign::new(of_p, self.bound);
        let of_q = Sign::new(of_q, self.bound);
        let of_r = Sign::new(of_r, self.bound);
        // The apex is alone on its side, so the product of all three signs is its own.
        let (is_r, is_q) = (of_p.is(&of_q), of_p.is(&of_r));
        let side = of_p.to_float() * of_q.to_float() * of_r.to_float();
        let known = of_p.known() & of_q.known() & of_r.known();
        let first = select(&is_r, r, select(&is_q, q, p));
        let second = select(&is_r, p, select(&is_q, r, q));
        let third = select(&is_r, q, select(&is_q, p, r));
        ([first, second, third], side, known)
    }
}

/// The lanes in which a determinant is certainly positive and certainly negative.
struct Sign<S: Simd> {
    positive: S::Mask,
    negative: S::Mask,
}

impl<S: Simd> Sign<S> {
    #[inline(always)]
    fn new(determinant: S, bound: S) -> Self {
        let minus = S::splat(0.0) - bound;
        Self { positive: bound.le(determinant), negative: determinant.le(minus) }
    }

    #[inline(always)]
    fn known(&self) -> S::Mask {
        self.positive | self.negative
    }

    /// Lanes in which two signs are known and equal.
    #[inline(always)]
    fn is(&self, other: &Self) -> S::Mask {
        (self.positive & other.positive) | (self.negative & other.negative)
    }

    /// 1 or −1.
    #[inline(always)]
    fn to_float(&self) -> S {
        S::select(&self.positive, S::splat(1.0), S::splat(-1.0))
    }
}

/// The determinant det(b − a, c − a, d − a) and its error bound.
#[inline(always)]
fn orientation<S: Simd>(a: [S; 3], b: [S; 3], c: [S; 3], d: [S; 3]) -> (S, S) {
    let (u, v, w) = (difference(b, a), difference(c, a), difference(d, a));
    let extent = highest(highest(abs(u), abs(v)), abs(w));
    (dot(cross(u, v), w), error_bound(extent))
}

/// The bound of [`crate::exact::filter32`]; NaN, to which nothing compares, where it does not hold.
#[inline(always)]
fn error_bound<S: Simd>(extent: [S; 3]) -> S {
    let holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_EXTENT));
    let bound = extent[0] * extent[1] * extent[2] * S::splat(ERROR) + S::splat(UNDERFLOW);
    S::select(&holds, bound, S::splat(f32::NAN))
}
