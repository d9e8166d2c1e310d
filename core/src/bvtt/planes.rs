//! The triangle test of [`crate::triangle`] for the pairs of eight triangles with another one, side by side.
//!
//! The steps are those of `triangles_intersect`, with signs that f32 certifies by the bound of
//! [`crate::exact::filter32`] or, for corners on a grid, computes without any error. Pairs still open are left to that test.

use super::block::TriangleBlock;
use crate::exact::filter32::{ERROR, MAX_EXTENT, UNDERFLOW};
use crate::simd::Simd;
use crate::simd::point8::{
    abs, cross, difference, dot, highest, load, lowest, pick, select, splat,
};

/// A triangle in each lane, with its supporting plane.
pub(super) struct Planes<S> {
    /// How far differences of coordinates may be from those that corners stand for, if they are shadows.
    error: Option<[S; 3]>,
    pub(super) corners: [[S; 3]; 3],
    pub(super) vertices: [S; 3],
    pub(super) normal: [S; 3],
    pub(super) extent: [S; 3],
}

impl<S: Simd> Planes<S> {
    /// The triangles of a block in the lanes from `at` on.
    #[inline(always)]
    pub(super) fn load(block: &TriangleBlock, at: usize, error: Option<[S; 3]>) -> Self {
        let [p, q, r] = &block.corners;
        Self {
            error,
            corners: [load(p, at), load(q, at), load(r, at)],
            vertices: load(&block.vertices, at),
            normal: load(&block.normal, at),
            extent: load(&block.extent, at),
        }
    }

    /// Triangles of a block at some places, see [`Simd::pick`], in the lanes from `at` on.
    #[inline(always)]
    pub(super) fn pick(
        block: &TriangleBlock,
        places: u64,
        at: usize,
        error: Option<[S; 3]>,
    ) -> Self {
        let [p, q, r] = &block.corners;
        Self {
            error,
            corners: [pick(p, places, at), pick(q, places, at), pick(r, places, at)],
            vertices: pick(&block.vertices, places, at),
            normal: pick(&block.normal, places, at),
            extent: pick(&block.extent, places, at),
        }
    }

    /// One triangle of a block in every lane.
    #[inline(always)]
    pub(super) fn splat(block: &TriangleBlock, lane: usize, error: Option<[S; 3]>) -> Self {
        let [p, q, r] = &block.corners;
        Self {
            error,
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

    /// Lanes in which both triangles have a vertex in common, or one whose key is NaN.
    #[inline(always)]
    pub(super) fn may_share_vertex(&self, other: &Self) -> u32 {
        let ([p, q, r], [u, v, w]) = (self.vertices, other.vertices);
        let are_known = p.eq(p) & q.eq(q) & r.eq(r) & u.eq(u) & v.eq(v) & w.eq(w);
        let [u, v, w] = self.shared(other);
        S::bits(u | v | w) | !S::bits(are_known)
    }

    /// The heights of the corners of `other` over this plane.
    #[inline(always)]
    pub(super) fn heights(&self, other: &Self) -> Heights<S> {
        let (base, [p, q, r]) = (self.corners[0], other.corners);
        let (p, q, r) = (difference(p, base), difference(q, base), difference(r, base));
        let extent = highest(highest(self.extent, abs(p)), highest(abs(q), abs(r)));
        let of = [dot(self.normal, p), dot(self.normal, q), dot(self.normal, r)];
        Heights { of, bound: error_bound(extent, self.error) }
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
            heights.on_one_side(heights.of, heights.of)
        }
    }

    /// Lanes in which all corners of `other`, whose `heights` these are, are certainly on one side of this plane and farther away
    /// from it than a distance.
    ///
    /// The true heights are as far from these as their bound says. The true normal is at most as long as the one computed, plus
    /// 8 u (e f + f g + g e) for the extents e, f and g of the edges, plus the smallest normal number for what underflows.
    #[inline(always)]
    pub(super) fn is_farther(&self, heights: &Heights<S>, distance: S) -> u32 {
        let (length, [d, e, f]) = (longest(self.normal), self.extent);
        let error = (d * e + e * f + f * d) * S::splat(5e-7);
        let smallest = S::splat(f32::MIN_POSITIVE);
        let more = (length + error + smallest) * distance + smallest;
        let farther =
            Heights { of: heights.of, bound: (heights.bound + more) * S::splat(1.000_001) };
        farther.on_one_side(farther.of, farther.of)
    }

    /// The `candidates` in which this triangle certainly intersects `other`, and those in which it certainly does not, where
    /// neither plane separates the two. `own` are the heights of this triangle over the plane of `other`, and `others` those of
    /// `other` over this plane.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        other: &Self,
        own: &Heights<S>,
        others: &Heights<S>,
        candidates: u32,
    ) -> [u32; 2] {
        let (own, others) = (own.signs(), others.signs());
        let known = candidates & S::bits(are_nonzero(own) & are_nonzero(others));
        if known == 0 {
            return [0; 2];
        }
        let [first, second] = self.interval_signs(other, own, others, None);
        let (one, minus_one) = (S::splat(1.0), S::splat(-1.0));
        let meet = S::bits(first.eq(minus_one) & second.eq(one));
        let apart = S::bits(first.eq(one) | second.eq(minus_one));
        [known & meet, known & apart]
    }

    /// The same for corners on a grid, in lanes in which the triangles are not coplanar. Flush faces are the everyday case of
    /// voxels, of CAD and of welded parts, and there most determinants are zero, which no error bound certifies.
    ///
    /// # The proof
    /// Let r be the extent of all six corners along an axis, and c = 1.5 · 2^18 · r, rounded. To add c to a coordinate of at
    /// most c/4 and to take it away again rounds it to a multiple of half an ulp of c at least, which is more than r · 2^-7,
    /// and a power of two, u. Where no corner changes, all are multiples of u, and all differences are less than 2^7 u; they
    /// are exact, since coordinates are at most 2^23 u. Let units be 1, as scaling an axis changes no sign. A product of
    /// three differences is then an integer below 2^21 and a determinant, the sum of six of them, is below 2^24, as are all
    /// intermediate results: f32 makes no error. A determinant that is not zero is at least u_x u_y u_z, which is more than
    /// the product of the extents times 2^-21. With extents from 2^-30 to 2^40, nothing underflows or overflows.
    #[inline(always)]
    pub(super) fn decide_on_grid(
        &self,
        other: &Self,
        own: &Heights<S>,
        others: &Heights<S>,
    ) -> [u32; 2] {
        let ([p, q, r], [u, v, w]) = (self.corners, other.corners);
        let low = lowest(lowest(lowest(p, q), r), lowest(lowest(u, v), w));
        let high = highest(highest(highest(p, q), r), highest(highest(u, v), w));
        let (mut on_grid, mut bound) = (low[0].le(low[0]), S::splat(GRID));
        for k in 0..3 {
            let extent = high[k] - low[k];
            let c = extent * S::splat(ROUNDING);
            let holds = S::splat(MIN_EXTENT).le(extent) & extent.le(S::splat(MAX_EXTENT));
            let is_near = low[k].abs().max(high[k].abs()).le(c * S::splat(0.25));
            on_grid = on_grid & holds & is_near;
            for corner in [p[k], q[k], r[k], u[k], v[k], w[k]] {
                on_grid = on_grid & ((corner + c) - c).eq(corner);
            }
            bound = bound * extent;
        }
        let known = S::bits(on_grid);
        if known == 0 {
            return [0; 2];
        }
        let (own, others) = (Heights { of: own.of, bound }, Heights { of: others.of, bound });
        let separated = own.on_one_side(own.of, own.of) | others.on_one_side(others.of, others.of);
        let (own, others) = (own.signs(), others.signs());
        let [first, second] = self.interval_signs(other, own, others, Some(bound));
        let zero = S::splat(0.0);
        let cross = !S::bits(are_zero(own) | are_zero(others)) & !separated;
        let meet = S::bits(first.le(zero) & zero.le(second));
        [known & cross & meet, known & (separated | cross & !meet)]
    }

    /// The two signs that decide whether triangles that reach the plane of each other intersect, given on which sides of it
    /// they have their corners: they do unless the first is 1 or the second −1. A sign is 0 if it is not certain or, with
    /// the bound of determinants on a grid, if the determinant is zero.
    ///
    /// The proof is at `intervals_overlap` of [`crate::triangle`].
    #[inline(always)]
    fn interval_signs(
        &self,
        other: &Self,
        own: [S; 3],
        others: [S; 3],
        on_grid: Option<S>,
    ) -> [S; 2] {
        let ([a0, a1, a2], delta) = arrange(self.corners, own);
        let ([b0, b1, b2], epsilon) = arrange(other.corners, others);
        let same_side = delta.eq(epsilon);
        let (b1, b2) = (select(&same_side, b1, b2), select(&same_side, b2, b1));
        let (first, bound) = orientation(a0, a1, b0, b1, self.error);
        let first = sign(first, on_grid.unwrap_or(bound)) * epsilon;
        let (second, bound) = orientation(a0, a2, b0, b2, self.error);
        [first, sign(second, on_grid.unwrap_or(bound)) * epsilon]
    }
}

/// Rounds coordinates to a grid, see [`Planes::decide_on_grid`]; the smallest extent for which it does; and the smallest
/// determinant, but for zero, by the product of the extents.
const ROUNDING: f32 = 393_216.0;
const MIN_EXTENT: f32 = 9.313_226e-10;
const GRID: f32 = 4.768_371_6e-7;

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
        self.on_one_side(low, high) & !S::bits(p & q & r)
    }

    /// Lanes in which the lowest or the highest of some heights certainly have the sign of all.
    #[inline(always)]
    fn on_one_side(&self, [p, q, r]: [S; 3], [x, y, z]: [S; 3]) -> u32 {
        let (low, high) = (p.min(q).min(r), x.max(y).max(z));
        S::bits(self.bound.le(low) | high.le(S::splat(0.0) - self.bound))
    }

    #[inline(always)]
    fn signs(&self) -> [S; 3] {
        let [p, q, r] = self.of;
        [sign(p, self.bound), sign(q, self.bound), sign(r, self.bound)]
    }
}

/// The corners of a triangle from its apex on, and the side of the apex, from the sides of the corners. It does in lanes what
/// `arrange` and `apex` of [`crate::triangle`] do.
#[inline(always)]
fn arrange<S: Simd>([p, q, r]: [[S; 3]; 3], [of_p, of_q, of_r]: [S; 3]) -> ([[S; 3]; 3], S) {
    let (zero, minus_one) = (S::splat(0.0), S::splat(-1.0));
    // Two equal sides leave the third. If all differ, one is 0, and not that of the apex.
    let is_r = of_p.eq(of_q);
    let is_q = of_p.eq(of_r) | (of_p.eq(zero) & (of_q * of_r).eq(minus_one));
    let first = select(&is_r, r, select(&is_q, q, p));
    let second = select(&is_r, p, select(&is_q, r, q));
    let third = select(&is_r, q, select(&is_q, p, r));
    let own = S::select(&is_r, of_r, S::select(&is_q, of_q, of_p));
    let next = S::select(&is_r, of_p, S::select(&is_q, of_r, of_q));
    ([first, second, third], S::select(&own.eq(zero), zero - next, own))
}

/// 1 or −1 where a determinant reaches its bound, else 0.
#[inline(always)]
fn sign<S: Simd>(determinant: S, bound: S) -> S {
    let (zero, one, minus_one) = (S::splat(0.0), S::splat(1.0), S::splat(-1.0));
    let negative = S::select(&determinant.le(zero - bound), minus_one, zero);
    S::select(&bound.le(determinant), one, negative)
}

#[inline(always)]
fn are_nonzero<S: Simd>([p, q, r]: [S; 3]) -> S::Mask {
    (p * q * r).abs().eq(S::splat(1.0))
}

#[inline(always)]
fn are_zero<S: Simd>([p, q, r]: [S; 3]) -> S::Mask {
    (p.abs() + q.abs() + r.abs()).eq(S::splat(0.0))
}

/// The determinant det(b − a, c − a, d − a) and its error bound.
#[inline(always)]
fn orientation<S: Simd>(
    a: [S; 3],
    b: [S; 3],
    c: [S; 3],
    d: [S; 3],
    error: Option<[S; 3]>,
) -> (S, S) {
    let (u, v, w) = (difference(b, a), difference(c, a), difference(d, a));
    let extent = highest(highest(abs(u), abs(v)), abs(w));
    (dot(cross(u, v), w), error_bound(extent, error))
}

/// How far a determinant may be from that of other points, if none of its differences is more than `error` from theirs.
///
/// Each of its six products is off by |p q r − (p + d)(q + e)(r + f)|, at most (x + d)(y + e)(z + f) − x y z with the extents
/// for the differences. The factor has room for the roundings, and [`UNDERFLOW`] for what underflow takes from three products.
#[inline(always)]
fn shadow_bound<S: Simd>([x, y, z]: [S; 3], [d, e, f]: [S; 3]) -> S {
    let (y_most, z_most) = (y + e, z + f);
    (d * y_most * z_most + x * e * z_most + x * y * f) * S::splat(6.0001)
}

/// A bound of the length of a vector, but for roundings, without a root: for x ≥ y ≥ z ≥ 0, it is at most x + (√2 − 1) y + (√3 − √2) z, since it is
/// convex, and equal at the corners of that cone.
#[inline(always)]
pub(super) fn longest<S: Simd>(vector: [S; 3]) -> S {
    let [x, y, z] = abs(vector);
    let (most, least) = (x.max(y).max(z), x.min(y).min(z));
    let middle = x + y + z - most - least;
    most * S::splat(1.000_001) + middle * S::splat(0.414_22) + least * S::splat(0.317_85)
}

/// The bound of [`crate::exact::filter32`]; NaN, to which nothing compares, where it does not hold. If corners are shadows, whose
/// differences may be off by `error`, it holds for what they stand for.
#[inline(always)]
pub(super) fn error_bound<S: Simd>(extent: [S; 3], error: Option<[S; 3]>) -> S {
    let holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_EXTENT));
    let mut bound = extent[0] * extent[1] * extent[2] * S::splat(ERROR) + S::splat(UNDERFLOW);
    if let Some(error) = error {
        bound = bound + shadow_bound(extent, error);
    }
    S::select(&holds, bound, S::splat(f32::NAN))
}
