//! Rejection of the triangle pairs of two blocks: by boxes first, then by supporting planes.
//!
//! A triangle strictly on one side of another's plane does not intersect it, which rejects nearly all pairs whose
//! boxes overlap. The signs are certified by the bound of [`crate::exact::filter32`]; all other pairs go to
//! the exact test of [`crate::triangle`].
//!
//! # Triangles of one mesh
//! Triangles that share a certified vertex ([`crate::one_ring`]) do not intersect elsewhere. For other triangles that
//! share vertices, shared corners lie in both planes: with all other corners of one strictly on one side of the plane of
//! the other they have nothing in common beside these corners, and so are no hit under any rule of
//! [`crate::triangle::Adjacency`]. A shared corner that goes unnoticed is too close to the plane to reject anything.

use super::block::TriangleBlock;
use crate::Aabb;
use crate::exact::filter32::{ERROR, MAX_EXTENT, UNDERFLOW};
use crate::simd::point8::{abs, chunk_starts, difference, highest, load, splat};
use crate::simd::{LANES, Simd};

/// Sets of triangle pairs: bit 8·j + i for triangle i of the first block and j of the second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PairSets {
    /// Pairs whose boxes overlap.
    pub(super) overlapping: u64,
    /// Overlapping pairs that no plane separates and no certificate rejects.
    pub(super) undecided: u64,
    /// Undecided pairs that may share a vertex.
    pub(super) may_share_vertex: u64,
}

impl TriangleBlock {
    /// Tests the `allowed` pairs with the triangles of `other`; `SELF` if both blocks are of one mesh. Then, with
    /// `boxes_only`, no pair whose boxes overlap is rejected.
    #[inline(always)]
    pub(super) fn cull<S: Simd, const SELF: bool>(
        &self,
        other: &Self,
        allowed: u64,
        boxes_only: bool,
    ) -> PairSets {
        let mut pairs = PairSets::default();
        let (uncertified, other_uncertified) = (self.uncertified(), other.uncertified());
        // The triangles of `other` that reach into the box of this block.
        let Aabb { min: [a, b, c], max: [d, e, f] } = self.bounds;
        let low = [S::splat(a), S::splat(b), S::splat(c)];
        let mut rows = other.overlapping(low, [S::splat(d), S::splat(e), S::splat(f)]);
        while rows != 0 {
            let j = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let shift = LANES * j;
            let overlapping = self.overlapping(splat::<S>(&other.min, j), splat(&other.max, j));
            let mut found = overlapping & (allowed >> shift) as u32;
            pairs.overlapping |= u64::from(found) << shift;
            if SELF && boxes_only {
                pairs.undecided = pairs.overlapping;
                continue;
            }
            let mut neighbours = 0;
            if SELF {
                found &= !self.share_certified_vertex::<S>(other, j);
                neighbours = if other_uncertified >> j & 1 != 0 { found & uncertified } else { 0 };
            }
            if found == 0 {
                continue;
            }
            found = if SELF && neighbours != 0 {
                self.not_separated::<S, true>(other, j, found)
            } else {
                self.not_separated::<S, false>(other, j, found)
            };
            pairs.undecided |= u64::from(found) << shift;
            pairs.may_share_vertex |= u64::from(found & neighbours) << shift;
        }
        pairs
    }

    /// Lanes whose box overlaps the box from `low` to `high`.
    #[inline(always)]
    fn overlapping<S: Simd>(&self, low: [S; 3], high: [S; 3]) -> u32 {
        let mut found = 0;
        for at in chunk_starts::<S>() {
            let (min, max) = (load::<S>(&self.min, at), load::<S>(&self.max, at));
            let x = low[0].le(max[0]) & min[0].le(high[0]);
            let y = low[1].le(max[1]) & min[1].le(high[1]);
            let z = low[2].le(max[2]) & min[2].le(high[2]);
            found |= S::bits(x & y & z) << at;
        }
        found & self.occupied_mask()
    }

    /// Lanes that share a certified vertex with triangle `j` of `other`.
    #[inline(always)]
    fn share_certified_vertex<S: Simd>(&self, other: &Self, j: usize) -> u32 {
        let u = S::splat(other.certified_key(0, j));
        let v = S::splat(other.certified_key(1, j));
        let w = S::splat(other.certified_key(2, j));
        let mut found = 0;
        for at in chunk_starts::<S>() {
            let [p, q, r] = load::<S>(&self.vertices, at);
            let first = p.eq(u) | q.eq(u) | r.eq(u);
            let second = p.eq(v) | q.eq(v) | r.eq(v);
            found |= S::bits(first | second | (p.eq(w) | q.eq(w) | r.eq(w))) << at;
        }
        found
    }

    /// The vertex of a corner as a float; NaN, which equals nothing, unless it is certified.
    #[inline(always)]
    fn certified_key(&self, corner: usize, lane: usize) -> f32 {
        let certified = self.certified[corner] >> lane & 1 != 0;
        if certified { self.vertices[corner][lane] } else { f32::NAN }
    }

    /// Lanes with a vertex that is not certified.
    fn uncertified(&self) -> u32 {
        !(self.certified[0] & self.certified[1] & self.certified[2]) & self.occupied_mask()
    }

    /// Lanes of `candidates` that neither supporting plane separates from triangle `j` of `other`.
    #[inline(always)]
    fn not_separated<S: Simd, const SELF: bool>(
        &self,
        other: &Self,
        j: usize,
        candidates: u32,
    ) -> u32 {
        let mut undecided = 0;
        for at in chunk_starts::<S>() {
            let some = candidates >> at & (u32::MAX >> (u32::BITS as usize - S::WIDTH));
            if S::WIDTH < LANES && some == 0 {
                continue;
            }
            let (own, others) = (Planes::<S>::load(self, at), Planes::splat(other, j));
            let mut found = some & !own.separate::<SELF>(&others);
            if found != 0 {
                found &= !others.separate::<SELF>(&own);
            }
            undecided |= found << at;
        }
        undecided
    }
}

/// A triangle in each lane, with its supporting plane.
struct Planes<S> {
    corners: [[S; 3]; 3],
    vertices: [S; 3],
    normal: [S; 3],
    extent: [S; 3],
}

impl<S: Simd> Planes<S> {
    /// The triangles of a block in the lanes from `at` on.
    #[inline(always)]
    fn load(block: &TriangleBlock, at: usize) -> Self {
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
    fn splat(block: &TriangleBlock, lane: usize) -> Self {
        let [p, q, r] = &block.corners;
        Self {
            corners: [splat(p, lane), splat(q, lane), splat(r, lane)],
            vertices: splat(&block.vertices, lane),
            normal: splat(&block.normal, lane),
            extent: splat(&block.extent, lane),
        }
    }

    /// Lanes in which this plane certainly has all corners of the other triangle strictly on one side; with `SELF`, all
    /// corners that the two triangles do not share, of which there must be one.
    ///
    /// The height of a corner over the plane, times the length of the normal, is the determinant of
    /// [`crate::exact::filter32`]. Its sign is certain when it reaches the error bound stated there.
    #[inline(always)]
    fn separate<const SELF: bool>(&self, other: &Self) -> u32 {
        let (infinity, minus_infinity) = (S::splat(f32::INFINITY), S::splat(f32::NEG_INFINITY));
        let n = &self.normal;
        // The least and the greatest height of a corner, and the largest extents that went into them.
        let (mut low, mut high, mut extent) = (infinity, minus_infinity, self.extent);
        for k in 0..3 {
            let w = difference(other.corners[k], self.corners[0]);
            extent = highest(extent, abs(w));
            let height = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
            let (mut least, mut most) = (height, height);
            if SELF {
                let ([p, q, r], vertex) = (self.vertices, other.vertices[k]);
                let shared = vertex.eq(p) | vertex.eq(q) | vertex.eq(r);
                least = S::select(&shared, infinity, least);
                most = S::select(&shared, minus_infinity, most);
            }
            low = low.min(least);
            high = high.max(most);
        }
        let bound = extent[0] * extent[1] * extent[2] * S::splat(ERROR) + S::splat(UNDERFLOW);
        let mut holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_EXTENT));
        if SELF {
            // Where all corners are shared, no height has been seen.
            holds = holds & low.le(high);
        }
        S::bits((bound.le(low) | high.le(S::splat(0.0) - bound)) & holds)
    }
}
