//! Tests of the triangle pairs of two blocks: by boxes first, then by what f32 certifies.
//!
//! A triangle strictly on one side of another's plane does not intersect it, which rejects nearly all pairs whose
//! boxes overlap. Most others are decided as far as f32 certifies the signs that it takes ([`super::planes`]); what is
//! left goes to the exact test of [`crate::triangle`].
//!
//! # Triangles of one mesh
//! Triangles that share a certified vertex ([`crate::one_ring`]) do not intersect elsewhere. For other triangles that
//! share vertices, shared corners lie in both planes: with all other corners of one strictly on one side of the plane of
//! the other they have nothing in common beside these corners, and so are no hit under any rule of
//! [`crate::triangle::Adjacency`]. A shared corner that goes unnoticed is too close to the plane to reject anything.

use super::block::TriangleBlock;
use super::planes::Planes;
use crate::simd::point8::{chunk_starts, difference, load, splat, sum};
use crate::simd::{LANES, Simd};
use glam::Vec3A;

/// Sets of triangle pairs: bit 8·j + i for triangle i of the first block and j of the second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PairSets {
    /// Pairs whose boxes overlap.
    pub(crate) overlapping: u64,
    /// Pairs that intersect, as far as f32 certifies it.
    pub(crate) hits: u64,
    /// Overlapping pairs that neither f32 nor a certificate decides.
    pub(crate) open: u64,
    /// Undecided pairs that may share a vertex.
    pub(crate) may_share_vertex: u64,
}

impl TriangleBlock {
    /// Tests the `allowed` pairs with the triangles of `other`; `SELF` if both blocks are of one mesh. Then, with
    /// `boxes_only`, no pair whose boxes overlap is rejected. If corners are shadows of others in f64, differences of
    /// coordinates may be off by `error`.
    #[inline(always)]
    pub(super) fn cull<S: Simd, const SELF: bool>(
        &self,
        other: &Self,
        allowed: u64,
        boxes_only: bool,
        error: Option<Vec3A>,
    ) -> PairSets {
        let (mut pairs, mut left, mut neighbours) = (PairSets::default(), 0, 0);
        let (uncertified, other_uncertified) = (self.uncertified(), other.uncertified());
        let error = error.map(|error| [S::splat(error.x), S::splat(error.y), S::splat(error.z)]);
        // The triangles of `other` that reach into the box of this block.
        let [low, high] = self.around::<S>();
        let mut rows = other.overlapping(low, high, error);
        while rows != 0 {
            let j = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let shift = LANES * j;
            let overlapping =
                self.overlapping(splat::<S>(&other.min, j), splat(&other.max, j), error);
            let mut found = overlapping & (allowed >> shift) as u32;
            pairs.overlapping |= u64::from(found) << shift;
            if SELF && !boxes_only {
                found &= !self.share_certified_vertex::<S>(other, j);
                let uncertified = if other_uncertified >> j & 1 != 0 { uncertified } else { 0 };
                neighbours |= u64::from(found & uncertified) << shift;
            }
            left |= u64::from(found) << shift;
        }
        if SELF && boxes_only {
            return PairSets { open: left, ..pairs };
        }
        while left != 0 {
            let group = PairLanes::take(&mut left);
            let [hits, open] =
                self.decide::<S, SELF>(other, &group, group.lanes_of(neighbours), error);
            pairs.hits |= group.set_of(hits);
            pairs.open |= group.set_of(open);
        }
        pairs.may_share_vertex = pairs.open & neighbours;
        pairs
    }

    /// Lanes whose box overlaps the box from `low` to `high`, as far as that is known with an `error`.
    #[inline(always)]
    pub(super) fn overlapping<S: Simd>(
        &self,
        low: [S; 3],
        high: [S; 3],
        error: Option<[S; 3]>,
    ) -> u32 {
        let mut found = 0;
        let (low, high) = match error {
            Some(error) => (difference(low, error), sum(high, error)),
            None => (low, high),
        };
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
    pub(super) fn share_certified_vertex<S: Simd>(&self, other: &Self, j: usize) -> u32 {
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

    /// Lanes of a group of pairs that certainly intersect, and those that may. Lanes of `neighbours`, which may share a vertex, are left
    /// out only if a plane separates them beside what they share, and decided only if they share none.
    #[inline(always)]
    fn decide<S: Simd, const SELF: bool>(
        &self,
        other: &Self,
        group: &PairLanes,
        neighbours: u32,
        error: Option<[S; 3]>,
    ) -> [u32; 2] {
        let [mut hits, mut open] = [0; 2];
        for at in chunk_starts::<S>() {
            let mut left = group.lanes >> at & (u32::MAX >> (u32::BITS as usize - S::WIDTH));
            if S::WIDTH < LANES && left == 0 {
                continue;
            }
            let own = Planes::<S>::pick(self, group.bits, at, error);
            let others = Planes::pick(other, group.bits >> LANES.ilog2(), at, error);
            let of_others = own.heights(&others);
            left &= !own.separates::<SELF>(&others, &of_others, neighbours);
            if left == 0 {
                continue;
            }
            let of_own = others.heights(&own);
            left &= !others.separates::<SELF>(&own, &of_own, neighbours);
            let sharing = if SELF && neighbours >> at & left != 0 {
                neighbours >> at & own.may_share_vertex(&others)
            } else {
                0
            };
            let mut distinct = left & !sharing;
            let mut meet = [0; 2];
            // One lane alone gains nothing over the test of two triangles.
            if S::WIDTH > 1 && distinct != 0 {
                let [met, apart] = own.decide(&others, &of_own, &of_others, distinct);
                meet[0] = met;
                distinct &= !(met | apart);
            }
            if S::WIDTH > 1 && distinct != 0 && error.is_none() {
                let [met, apart] = own.decide_on_grid(&others, &of_own, &of_others);
                meet[1] = distinct & met;
                distinct &= !(met | apart);
            }
            hits |= (meet[0] | meet[1]) << at;
            left = distinct | left & sharing;
            open |= left << at;
        }
        [hits, open]
    }
}

/// Up to eight pairs of a leaf pair, one a lane.
struct PairLanes {
    /// The bit of each, in a byte.
    bits: u64,
    /// The lanes that have one.
    lanes: u32,
}

impl PairLanes {
    /// Takes the lowest pairs out of a set.
    #[inline(always)]
    fn take(pairs: &mut u64) -> Self {
        let lanes = !(u32::MAX << pairs.count_ones().min(LANES as u32));
        let mut bits = 0;
        // Without a branch: how many there are is hard to predict.
        for lane in 0..LANES {
            bits |= u64::from(pairs.trailing_zeros() % u64::BITS) << (8 * lane);
            *pairs &= pairs.wrapping_sub(1);
        }
        Self { bits, lanes }
    }

    /// The lanes whose pair is in a set.
    #[inline(always)]
    fn lanes_of(&self, pairs: u64) -> u32 {
        if pairs == 0 {
            return 0;
        }
        let mut lanes = 0;
        for lane in 0..LANES {
            lanes |= (pairs >> (self.bits >> (8 * lane) & 63) & 1) << lane;
        }
        lanes as u32 & self.lanes
    }

    /// The pairs of some lanes.
    #[inline(always)]
    fn set_of(&self, mut lanes: u32) -> u64 {
        let mut pairs = 0;
        while lanes != 0 {
            pairs |= 1 << (self.bits >> (8 * lanes.trailing_zeros()) & 63);
            lanes &= lanes - 1;
        }
        pairs
    }
}
