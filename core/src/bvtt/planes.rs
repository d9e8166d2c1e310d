//! Rejection of triangle pairs by supporting planes, a pair in each lane.
//!
//! A triangle strictly on one side of another's plane does not intersect it, which rejects nearly all pairs whose
//! boxes overlap. The signs are certified by the bound of [`crate::exact::filter32`]; all other pairs go to
//! the exact test of [`crate::triangle`].

use crate::exact::filter32::{ERROR, MAX_EXTENT, UNDERFLOW};
use crate::simd::Simd;
use crate::simd::point8::{abs, difference, highest};

/// The corners of a triangle in each lane, and their vertices as floats.
#[derive(Clone, Copy)]
pub(super) struct Corners<S> {
    pub(super) points: [[S; 3]; 3],
    pub(super) vertices: [S; 3],
}

/// A triangle in each lane, with its supporting plane.
pub(super) struct Planes<S> {
    pub(super) corners: Corners<S>,
    pub(super) normal: [S; 3],
    pub(super) extent: [S; 3],
}

impl<S: Simd> Planes<S> {
    /// Lanes in which all corners of the other triangle are strictly on one side of this plane; with `SELF`, all
    /// corners that the two do not share, of which there must be one.
    #[inline(always)]
    pub(super) fn separated<const SELF: bool>(&self, other: &Corners<S>) -> u32 {
        let (infinity, base, n) = (S::splat(f32::INFINITY), self.corners.points[0], &self.normal);
        let (mut low, mut high, mut extent) = (infinity, -infinity, self.extent);
        for k in 0..3 {
            let w = difference(other.points[k], base);
            extent = highest(extent, abs(w));
            let side = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
            let (mut least, mut most) = (side, side);
            if SELF {
                let [p, q, r] = self.corners.vertices;
                let v = other.vertices[k];
                let shared = v.eq(p) | v.eq(q) | v.eq(r);
                least = S::select(&shared, infinity, least);
                most = S::select(&shared, -infinity, most);
            }
            low = low.min(least);
            high = high.max(most);
        }
        let bound = extent[0] * extent[1] * extent[2] * S::splat(ERROR) + S::splat(UNDERFLOW);
        let holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_EXTENT));
        // Both comparisons hold where all corners are shared, hence the exclusive or.
        S::bits((bound.lt(low) ^ high.lt(-bound)) & holds)
    }
}
