//! The triangle pairs of two blocks that are within a distance.
//!
//! Few lanes of a row are left after the test of boxes, and [`nearest`](super::nearest) takes long. So pairs of all rows are
//! gathered until every lane has one.

use super::block::TriangleBlock;
use super::cull::PairSets;
use super::nearest::{Reach, certify};
use super::planes::Planes;
use crate::Mesh;
use crate::aabb::Bounds;
use crate::simd::point8::{Points, chunk_starts, difference, dot, highest, load, splat};
use crate::simd::{LANES, Simd};
use glam::Vec3A;

impl TriangleBlock {
    /// The `allowed` pairs with the triangles of `other` that are at most `distance` apart, as [`TriangleBlock::cull`] has those
    /// that intersect: hits as far as f32 certifies them, and open pairs. Triangles of one `mesh` that share a vertex stay open.
    /// With `boxes_only` all pairs are open whose boxes are at most `distance` apart on each axis. If corners are shadows of others
    /// in f64, differences of coordinates may be off by `error`.
    #[inline(always)]
    pub(super) fn near<S: Simd, const SELF: bool>(
        &self,
        other: &Self,
        allowed: u64,
        mesh: Mesh<'_>,
        distance: f32,
        boxes_only: bool,
        error: Option<Vec3A>,
    ) -> PairSets {
        let mut pairs = PairSets::default();
        let (is_shadow, error) = (error.is_some(), error.unwrap_or(Vec3A::ZERO));
        // Rounded up, so that no box is too far away that is not.
        let grown = error + Vec3A::splat(distance);
        let around = Some([
            S::splat(grown.x.next_up()),
            S::splat(grown.y.next_up()),
            S::splat(grown.z.next_up()),
        ]);
        let [low, high] = self.around::<S>();
        let mut rows = other.overlapping(low, high, around);
        // No shorter than the error, and without its square, which underflows.
        let error_length = error.max_element() * 1.733;
        let most = farthest_square((distance + error_length).next_up());
        while rows != 0 {
            let j = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let shift = LANES * j;
            let overlapping =
                self.overlapping(splat::<S>(&other.min, j), splat(&other.max, j), around);
            let mut found = overlapping & (allowed >> shift) as u32;
            pairs.overlapping |= u64::from(found) << shift;
            if SELF && boxes_only {
                continue;
            }
            if found != 0 {
                found &= self.have_near_boxes::<S>(other, j, most);
            }
            if SELF {
                found &= !self.share_certified_vertex::<S>(other, j);
            }
            if found != 0 && !is_shadow {
                found &= !self.are_farther::<S>(other, j, distance);
            }
            pairs.open |= u64::from(found) << shift;
        }
        if SELF && boxes_only {
            return PairSets { open: pairs.overlapping, ..pairs };
        }
        if SELF {
            pairs.may_share_vertex = self.sharing(other, pairs.open, mesh);
        }
        let mut left = pairs.open & !pairs.may_share_vertex;
        let scale = scale(&self.bounds, &other.bounds);
        let reach = Reach {
            scale: S::splat(scale),
            distance: S::splat(distance * scale),
            error: S::splat(error_length * scale),
        };
        while left != 0 {
            let mut group = Group::new();
            left = group.gather(self, other, left);
            let [within, beyond] = group.certify::<S>(&reach);
            pairs.hits |= within;
            pairs.open &= !(within | beyond);
        }
        pairs
    }

    /// Lanes whose box is not certainly farther from that of triangle `j` of `other` than a distance, of which this is the
    /// [`farthest_square`].
    #[inline(always)]
    fn have_near_boxes<S: Simd>(&self, other: &Self, j: usize, most: f32) -> u32 {
        let (low, high) = (splat::<S>(&other.min, j), splat::<S>(&other.max, j));
        let (mut found, zero) = (0, [S::splat(0.0); 3]);
        for at in chunk_starts::<S>() {
            let (min, max) = (load::<S>(&self.min, at), load::<S>(&self.max, at));
            let gap = highest(difference(low, max), difference(min, high));
            let gap = highest(gap, zero);
            found |= S::bits(dot(gap, gap).le(S::splat(most))) << at;
        }
        found
    }

    /// Lanes that a plane certainly holds apart from triangle `j` of `other`, by more than a distance.
    #[inline(always)]
    fn are_farther<S: Simd>(&self, other: &Self, j: usize, distance: f32) -> u32 {
        let (mut found, distance) = (0, S::splat(distance));
        for at in chunk_starts::<S>() {
            let (own, others) = (Planes::<S>::load(self, at, None), Planes::splat(other, j, None));
            let by_own = own.is_farther(&own.heights(&others), distance);
            found |= (by_own | others.is_farther(&others.heights(&own), distance)) << at;
        }
        found
    }

    /// Pairs of triangles of one mesh that share a vertex.
    fn sharing(&self, other: &Self, pairs: u64, mesh: Mesh<'_>) -> u64 {
        let (mut left, mut sharing) = (pairs, 0);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let vertices =
                |triangles: &[u32; LANES], lane| mesh.triangles()[triangles[lane % LANES] as usize];
            let of_b = vertices(&other.triangles, bit / LANES);
            let is_shared = vertices(&self.triangles, bit).iter().any(|v| of_b.contains(v));
            sharing |= u64::from(is_shared) << bit;
        }
        sharing
    }
}

/// Boxes are farther apart than `reach` if the square of their distance in f32 is greater than this: four roundings are below
/// 2^-21 of it, and squares that underflow below the smallest normal number.
pub(super) fn farthest_square(reach: f32) -> f32 {
    reach * reach * (1.0 + 1.0 / 1_048_576.0) + f32::MIN_POSITIVE
}

/// A power of two by which the coordinates of two blocks, from a corner of theirs, become about 1 at most.
#[inline]
pub(super) fn scale(a: &Bounds, b: &Bounds) -> f32 {
    let extent = (a.max.max(b.max) - a.min.min(b.min)).max_element();
    // Far from where products of six factors overflow.
    let exponent = (extent.to_bits() >> 23).clamp(27, 227);
    f32::from_bits((254 - exponent) << 23)
}

/// As many pairs as there are lanes.
pub(super) struct Group {
    pub(super) corners: [[Points; 3]; 2],
    /// The bit of each.
    pub(super) bits: [u32; LANES],
    pub(super) len: usize,
}

impl Group {
    pub(super) fn new() -> Self {
        Self { corners: [[[[0.0; LANES]; 3]; 3]; 2], bits: [0; LANES], len: 0 }
    }

    /// Takes pairs until every lane has one. Returns those that are left.
    #[inline(always)]
    pub(super) fn gather(&mut self, a: &TriangleBlock, b: &TriangleBlock, mut pairs: u64) -> u64 {
        while pairs != 0 && self.len < LANES {
            let bit = pairs.trailing_zeros();
            pairs &= pairs - 1;
            let (i, j) = (bit as usize % LANES, bit as usize / LANES % LANES);
            for (to, (block, lane)) in self.corners.iter_mut().zip([(a, i), (b, j)]) {
                for (to, from) in to.iter_mut().zip(&block.corners) {
                    for (to, from) in to.iter_mut().zip(from) {
                        to[self.len] = from[lane];
                    }
                }
            }
            self.bits[self.len] = bit;
            self.len += 1;
        }
        pairs
    }

    /// Pairs that are certainly within the distance, and beyond it.
    #[inline(always)]
    fn certify<S: Simd>(&self, reach: &Reach<S>) -> [u64; 2] {
        let mut lanes = [0; 2];
        for at in chunk_starts::<S>().take_while(|at| *at < self.len) {
            let [[p, q, r], [u, v, w]] = &self.corners;
            let a = [load(p, at), load(q, at), load(r, at)];
            let found = certify::<S>(a, [load(u, at), load(v, at), load(w, at)], reach);
            lanes[0] |= found[0] << at;
            lanes[1] |= found[1] << at;
        }
        let mut pairs = [0; 2];
        for (lane, &bit) in self.bits.iter().enumerate().take(self.len) {
            pairs[0] |= u64::from(lanes[0] >> lane & 1) << bit;
            pairs[1] |= u64::from(lanes[1] >> lane & 1) << bit;
        }
        pairs
    }
}
