//! Triangle pairs of two blocks that may intersect: boxes first, then planes.
//!
//! # Triangles of one mesh
//! Triangles that share a certified vertex ([`crate::one_ring`]) do not meet. For other triangles that share
//! vertices, shared corners lie in both planes: with all other corners of one strictly on one side of the plane of
//! the other they have nothing in common beside these corners, and so are no hit under any rule of
//! [`crate::triangle::Adjacency`]. A shared corner that goes unnoticed is too close to the plane to reject anything.

use super::block::TriangleBlock;
use super::planes::{Corners, Planes};
use crate::Aabb;
use crate::simd::point8::{lanes, load, splat};
use crate::simd::{LANES, Simd};

/// Sets of triangle pairs: bit 8·j + i for triangle i of the first block and j of the second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PairSets {
    /// Pairs whose boxes overlap.
    pub(super) tested: u64,
    /// Pairs of these that no plane separates.
    pub(super) left: u64,
    /// Pairs of those left that may share a vertex.
    pub(super) neighbours: u64,
}

impl TriangleBlock {
    /// Tests the `allowed` pairs with the triangles of `other`; `SELF` if both are of one mesh.
    #[inline(always)]
    pub(super) fn pairs<S: Simd, const SELF: bool>(&self, other: &Self, allowed: u64) -> PairSets {
        let mut pairs = PairSets::default();
        let (uncertified, other_uncertified) = (self.uncertified(), other.uncertified());
        let mut rows = self.overlapping_rows::<S>(other);
        while rows != 0 {
            let j = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let shift = LANES * j;
            let mut found = self.overlapping_row::<S>(other, j) & (allowed >> shift) as u32;
            pairs.tested |= u64::from(found) << shift;
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
            pairs.left |= u64::from(found) << shift;
            pairs.neighbours |= u64::from(found & neighbours) << shift;
        }
        pairs
    }

    /// The `allowed` pairs whose boxes overlap.
    #[inline(always)]
    pub(super) fn box_pairs<S: Simd>(&self, other: &Self, allowed: u64) -> u64 {
        let (mut pairs, mut rows) = (0, self.overlapping_rows::<S>(other));
        while rows != 0 {
            let j = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            pairs |= u64::from(self.overlapping_row::<S>(other, j)) << (LANES * j);
        }
        pairs & allowed
    }

    /// Triangles of `other` that reach into the box of this block, as bits.
    #[inline(always)]
    fn overlapping_rows<S: Simd>(&self, other: &Self) -> u32 {
        let Aabb { min: [a, b, c], max: [d, e, f] } = self.bounds;
        let low = [S::splat(a), S::splat(b), S::splat(c)];
        other.overlapping(low, [S::splat(d), S::splat(e), S::splat(f)])
    }

    /// Lanes whose box overlaps that of triangle `j` of `other`.
    #[inline(always)]
    fn overlapping_row<S: Simd>(&self, other: &Self, j: usize) -> u32 {
        self.overlapping(splat::<S>(&other.min, j), splat::<S>(&other.max, j))
    }

    /// Lanes whose box overlaps the box from `low` to `high`.
    #[inline(always)]
    fn overlapping<S: Simd>(&self, low: [S; 3], high: [S; 3]) -> u32 {
        let mut found = 0;
        for at in lanes::<S>() {
            let (min, max) = (load::<S>(&self.min, at), load::<S>(&self.max, at));
            let x = low[0].le(max[0]) & min[0].le(high[0]);
            let y = low[1].le(max[1]) & min[1].le(high[1]);
            let z = low[2].le(max[2]) & min[2].le(high[2]);
            found |= S::bits(x & y & z) << at;
        }
        found & self.lanes()
    }

    /// Lanes that share a certified vertex with triangle `j` of `other`.
    #[inline(always)]
    fn share_certified_vertex<S: Simd>(&self, other: &Self, j: usize) -> u32 {
        let u = S::splat(other.certified_key(0, j));
        let v = S::splat(other.certified_key(1, j));
        let w = S::splat(other.certified_key(2, j));
        let mut found = 0;
        for at in lanes::<S>() {
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
        !(self.certified[0] & self.certified[1] & self.certified[2]) & self.lanes()
    }

    /// Lanes of `candidates` that neither supporting plane separates from triangle `j` of `other`.
    #[inline(always)]
    fn not_separated<S: Simd, const SELF: bool>(
        &self,
        other: &Self,
        j: usize,
        candidates: u32,
    ) -> u32 {
        let mut left = 0;
        for at in lanes::<S>() {
            let some = candidates >> at & (u32::MAX >> (u32::BITS as usize - S::WIDTH));
            if S::WIDTH < LANES && some == 0 {
                continue;
            }
            let own = self.planes::<S>(at);
            let [p, q, r] = &other.corners;
            let corners = Corners {
                points: [splat(p, j), splat(q, j), splat(r, j)],
                vertices: splat(&other.vertices, j),
            };
            let mut found = some & !own.separated::<SELF>(&corners);
            if found != 0 {
                let (normal, extent) = (splat(&other.normal, j), splat(&other.extent, j));
                let planes = Planes { corners, normal, extent };
                found &= !planes.separated::<SELF>(&own.corners);
            }
            left |= found << at;
        }
        left
    }

    #[inline(always)]
    fn planes<S: Simd>(&self, at: usize) -> Planes<S> {
        let [p, q, r] = &self.corners;
        let points = [load(p, at), load(q, at), load(r, at)];
        let corners = Corners { points, vertices: load(&self.vertices, at) };
        Planes { corners, normal: load(&self.normal, at), extent: load(&self.extent, at) }
    }
}

/// Whether two triangles share a vertex.
pub(super) fn share_vertex(a: &[u32; 3], b: &[u32; 3]) -> bool {
    a.iter().any(|vertex| b.contains(vertex))
}
