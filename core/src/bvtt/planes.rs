//! Rejection of triangle pairs by supporting planes, a pair in each lane.
//!
//! A triangle strictly on one side of another's plane does not meet it, which rejects nearly all pairs whose
//! boxes overlap. The signs are certified by the bound of [`crate::exact::filter32`]; whatever is left goes to
//! the exact test of [`crate::triangle`].

use crate::exact::filter32::{ERROR, MAX_EXTENT, UNDERFLOW};
use crate::simd::Simd;
use crate::simd::point8::{abs, difference, highest};

/// The corners of a triangle in each lane.
#[derive(Clone, Copy)]
pub(super) struct Corners<S> {
    pub(super) points: [[S; 3]; 3],
    pub(super) vertices: [S; 3],
}

/// A triangle in each lane, with its plane.
pub(super) struct Planes<S> {
    pub(super) corners: Corners<S>,
    pub(super) normal: [S; 3],
    pub(super) extent: [S; 3],
}

impl<S: Simd> Planes<S> {
    /// A bit for each lane in which all corners that the triangles do not share are strictly on one side
    /// of the plane, and there is one.
    #[inline(always)]
    pub(super) fn apart<const ONE_MESH: bool>(&self, of: &Corners<S>) -> u32 {
        let (infinity, base, n) = (S::splat(f32::INFINITY), self.corners.points[0], &self.normal);
        let (mut low, mut high, mut extent) = (infinity, -infinity, self.extent);
        for k in 0..3 {
            let w = difference(of.points[k], base);
            extent = highest(extent, abs(w));
            let side = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
            let (mut least, mut most) = (side, side);
            if ONE_MESH {
                let [p, q, r] = self.corners.vertices;
                let v = of.vertices[k];
                let shared = v.eq(p) | v.eq(q) | v.eq(r);
                least = S::select(&shared, infinity, least);
                most = S::select(&shared, -infinity, most);
            }
            low = low.min(least);
            high = high.max(most);
        }
        let bound = extent[0] * extent[1] * extent[2] * S::splat(ERROR) + S::splat(UNDERFLOW);
        let holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_EXTENT));
        // Both if all corners are shared.
        S::bits((bound.lt(low) ^ high.lt(-bound)) & holds)
    }
}
