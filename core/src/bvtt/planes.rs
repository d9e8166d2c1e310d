//! Triangles that lie on one side of another's plane.
//!
//! That settles nearly all pairs whose boxes overlap and who are no neighbours. Whatever it leaves goes
//! to the exact test of [`crate::triangle`], so only a wrong rejection could change an answer, and the
//! bound of `exact::filter32` excludes that.

use crate::exact::filter32::{BOUND, MOST, SLACK};
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
        let bound = extent[0] * extent[1] * extent[2] * S::splat(BOUND) + S::splat(SLACK);
        let sure = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MOST));
        // Both if all corners are shared.
        S::bits((bound.lt(low) ^ high.lt(-bound)) & sure)
    }
}
