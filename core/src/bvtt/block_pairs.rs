//! The triangles of one leaf against those of another.
//!
//! # Vertices in common
//! Triangles of one mesh that share a certified vertex ([`crate::one_ring`]) do not collide. For other
//! neighbours, corners in common lie in both planes: with all other corners of one strictly on one side of
//! the plane of the other they share nothing beside these corners, and so collide by none of the rules in
//! `triangle::neighbours`. A corner in common that goes unnoticed is found too close to the plane to
//! reject anything.

use super::block::Block;
use super::planes::{Corners, Planes};
use crate::aabb::Bounds;
use crate::simd::point8::{lanes, load, splat};
use crate::simd::{LANES, Simd};

/// Sets of pairs: bit 8·j + i for triangle i of the first block and j of the second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pairs {
    /// Those whose boxes overlap.
    pub(crate) tested: u64,
    /// Of these, those that may collide.
    pub(crate) left: u64,
    /// Of those left, those that may have a vertex in common.
    pub(crate) neighbours: u64,
}

impl Block {
    /// Tests the `allowed` pairs with others. `bounds` contains all of these triangles; `ONE_MESH` if
    /// they may have vertices in common.
    #[inline(always)]
    pub(crate) fn pairs<S: Simd, const ONE_MESH: bool>(
        &self,
        others: &Self,
        bounds: &Bounds,
        allowed: u64,
    ) -> Pairs {
        let mut pairs = Pairs::default();
        let own_doubtful = self.doubtful();
        let doubtful = others.doubtful();
        let mut rows = others.rows::<S>(bounds);
        while rows != 0 {
            let row = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let shift = LANES * row;
            let mut found = self.overlapping::<S>(others, row) & (allowed >> shift) as u32;
            pairs.tested |= u64::from(found) << shift;
            let mut neighbours = 0;
            if ONE_MESH {
                found &= !self.at_peace::<S>(others, row);
                neighbours = if doubtful >> row & 1 != 0 { found & own_doubtful } else { 0 };
            }
            if found == 0 {
                continue;
            }
            found &= if ONE_MESH && neighbours != 0 {
                self.undecided::<S, true>(others, row, found)
            } else {
                self.undecided::<S, false>(others, row, found)
            };
            pairs.left |= u64::from(found) << shift;
            pairs.neighbours |= u64::from(found & neighbours) << shift;
        }
        pairs
    }

    /// Those of the `allowed` pairs whose boxes overlap.
    #[inline(always)]
    pub(crate) fn boxes<S: Simd>(&self, others: &Self, bounds: &Bounds, allowed: u64) -> u64 {
        let (mut pairs, mut rows) = (0, others.rows::<S>(bounds));
        while rows != 0 {
            let row = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            pairs |= u64::from(self.overlapping::<S>(others, row)) << (LANES * row);
        }
        pairs & allowed
    }

    /// A bit for each of these that reaches into some bounds.
    #[inline(always)]
    fn rows<S: Simd>(&self, bounds: &Bounds) -> u32 {
        let (low, high) = (bounds.min, bounds.max);
        let low = [S::splat(low.x), S::splat(low.y), S::splat(low.z)];
        let high = [S::splat(high.x), S::splat(high.y), S::splat(high.z)];
        self.reach_into(low, high)
    }

    /// A bit for each of these whose box overlaps one other.
    #[inline(always)]
    fn overlapping<S: Simd>(&self, others: &Self, row: usize) -> u32 {
        self.reach_into(splat::<S>(&others.min, row), splat::<S>(&others.max, row))
    }

    #[inline(always)]
    fn reach_into<S: Simd>(&self, low: [S; 3], high: [S; 3]) -> u32 {
        let mut found = 0;
        for at in lanes::<S>() {
            found |= S::bits(overlap(low, high, load(&self.min, at), load(&self.max, at))) << at;
        }
        found & self.lanes()
    }

    /// A bit for each of these that has a certified vertex in common with one other.
    #[inline(always)]
    fn at_peace<S: Simd>(&self, others: &Self, row: usize) -> u32 {
        let u = S::splat(others.if_certified(0, row));
        let v = S::splat(others.if_certified(1, row));
        let w = S::splat(others.if_certified(2, row));
        let mut found = 0;
        for at in lanes::<S>() {
            let [p, q, r] = load::<S>(&self.vertices, at);
            let first = p.eq(u) | q.eq(u) | r.eq(u);
            let second = p.eq(v) | q.eq(v) | r.eq(v);
            found |= S::bits(first | second | (p.eq(w) | q.eq(w) | r.eq(w))) << at;
        }
        found
    }

    /// Those of some pairs with one other that are on neither's plane's one side.
    #[inline(always)]
    fn undecided<S: Simd, const ONE_MESH: bool>(
        &self,
        others: &Self,
        row: usize,
        found: u32,
    ) -> u32 {
        let mut left = 0;
        for at in lanes::<S>() {
            let some = found >> at & (u32::MAX >> (u32::BITS as usize - S::WIDTH));
            if S::WIDTH == LANES || some != 0 {
                left |= self.undecided_from::<S, ONE_MESH>(at, others, row, some) << at;
            }
        }
        left
    }

    /// The same of the lanes from `at` on.
    #[inline(always)]
    fn undecided_from<S: Simd, const ONE_MESH: bool>(
        &self,
        at: usize,
        others: &Self,
        row: usize,
        mut found: u32,
    ) -> u32 {
        let [p, q, r] = &self.corners;
        let own = Planes {
            corners: Corners {
                points: [load(p, at), load(q, at), load(r, at)],
                vertices: load::<S>(&self.vertices, at),
            },
            normal: load(&self.normal, at),
            extent: load(&self.extent, at),
        };
        let [p, q, r] = &others.corners;
        let corners = Corners {
            points: [splat(p, row), splat(q, row), splat(r, row)],
            vertices: splat::<S>(&others.vertices, row),
        };
        found &= !own.apart::<ONE_MESH>(&corners);
        if found != 0 {
            let (normal, extent) = (splat(&others.normal, row), splat(&others.extent, row));
            found &= !Planes { corners, normal, extent }.apart::<ONE_MESH>(&own.corners);
        }
        found
    }

    fn lanes(&self) -> u32 {
        (1 << self.len) - 1
    }

    /// A bit for each triangle with a vertex that is not certified.
    fn doubtful(&self) -> u32 {
        !(self.certified[0] & self.certified[1] & self.certified[2]) & self.lanes()
    }

    /// A vertex that is certified, or no number.
    #[inline(always)]
    fn if_certified(&self, corner: usize, lane: usize) -> f32 {
        let certified = self.certified[corner] >> lane & 1 != 0;
        if certified { self.vertices[corner][lane] } else { f32::NAN }
    }
}

/// Where boxes, by their smallest and largest corners, overlap others.
#[inline(always)]
fn overlap<S: Simd>(a_min: [S; 3], a_max: [S; 3], b_min: [S; 3], b_max: [S; 3]) -> S::Mask {
    let x = a_min[0].le(b_max[0]) & b_min[0].le(a_max[0]);
    let y = a_min[1].le(b_max[1]) & b_min[1].le(a_max[1]);
    let z = a_min[2].le(b_max[2]) & b_min[2].le(a_max[2]);
    x & y & z
}
