//! The triangles of a leaf, and the rejection of those that lie on one side of another's plane.
//!
//! That settles nearly all pairs whose boxes overlap: neighbours in a smooth surface, and what lies
//! close by without touching. Whatever it leaves goes to the exact test of [`crate::triangle`], so
//! only a wrong rejection could change an answer, and the bound below excludes that.
//!
//! # The bound
//! As that of the f64 filter (`predicates`), with u = 2^-24: each of the six products of three
//! differences carries a relative error below (1+u)^8 − 1, so that the determinant is off by less
//! than 48.06u · mx·my·mz, the largest absolute differences an axis. The constant has room for the
//! roundings of the bound. Unlike there, products may underflow or overflow. With no difference above
//! 2^40 none overflows, and underflow costs less than 6 · 2^-150 · 2^40 before the last product and
//! 4 · 2^-150 after; the bound may lose 2^-110. `SLACK`, 2^-100, is far above their sum.
//!
//! # Vertices in common
//! Triangles of one mesh may have corners in common, which lie in both planes. With all other corners
//! of one strictly on one side of the plane of the other they share nothing beside these corners, and
//! so collide by none of the rules in `triangle::neighbours`. A corner in common that goes unnoticed is
//! found too close to the plane to reject anything.

use super::{LANES, Simd};
use crate::aabb::Bounds;
use crate::fans::Fan;
use crate::place::Placement;
use crate::{Mesh, Triangle};

pub(super) const BOUND: f32 = 2.9e-6;
pub(super) const SLACK: f32 = 7.888_609e-31;
/// 2^40.
pub(super) const MOST: f32 = 1.099_511_6e12;

/// Coordinates of the same corner of each triangle: all x, all y, all z.
type Points = [[f32; LANES]; 3];

/// Up to eight triangles, placed, and their boxes and planes.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    len: usize,
    pub(super) corners: [Points; 3],
    /// Vertices as numbers that are equal as they are.
    vertices: Points,
    /// For each corner, a bit for the triangles whose vertex there is certified.
    certified: [u32; 3],
    min: Points,
    max: Points,
    pub(super) normal: Points,
    /// The largest extent of the two edges from the first corner, an axis.
    pub(super) extent: Points,
}

impl Block {
    const EMPTY: Self = {
        let zero = [[0.0; LANES]; 3];
        Self {
            len: 0,
            corners: [zero; 3],
            vertices: zero,
            certified: [0; 3],
            min: zero,
            max: zero,
            normal: zero,
            extent: zero,
        }
    };

    /// Takes in the triangles of a leaf.
    #[inline(always)]
    fn fill<S: Simd>(
        &mut self,
        mesh: Mesh<'_>,
        triangles: &[u32],
        place: &impl Placement,
        fans: &[Fan],
    ) {
        self.len = triangles.len().min(LANES);
        self.certified = [0; 3];
        for (lane, &triangle) in triangles.iter().take(LANES).enumerate() {
            let t = &mesh.triangles()[triangle as usize];
            for (k, &vertex) in t.iter().enumerate() {
                let p = &mesh.positions()[vertex as usize];
                self.corners[k][0][lane] = p[0];
                self.corners[k][1][lane] = p[1];
                self.corners[k][2][lane] = p[2];
                // No vertex becomes zero, of which floats have two; the last few, being no numbers,
                // equal nothing.
                self.vertices[k][lane] = f32::from_bits(vertex.saturating_add(0x0080_0000));
                if let Some(fan) = fans.get(vertex as usize) {
                    self.certified[k] |= u32::from(fan.is_certified()) << lane;
                }
            }
        }
        let p = place.points(load::<S>(&self.corners[0]));
        let q = place.points(load::<S>(&self.corners[1]));
        let r = place.points(load::<S>(&self.corners[2]));
        for (k, placed) in [p, q, r].into_iter().enumerate() {
            store(placed, &mut self.corners[k]);
        }
        store(lowest(lowest(p, q), r), &mut self.min);
        store(highest(highest(p, q), r), &mut self.max);
        let (u, v) = (difference(q, p), difference(r, p));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        store(normal, &mut self.normal);
        store(highest(abs(u), abs(v)), &mut self.extent);
    }

    /// The corners of one of them.
    #[inline]
    pub(crate) fn triangle(&self, lane: usize) -> Triangle {
        let corner = |p: &Points| [p[0][lane], p[1][lane], p[2][lane]];
        [corner(&self.corners[0]), corner(&self.corners[1]), corner(&self.corners[2])]
    }

    /// The pairs whose boxes overlap: bit 8·j + i for triangle i of these and j of the others. `bounds`
    /// contains all of these.
    #[inline(always)]
    pub(crate) fn overlapping<S: Simd>(&self, others: &Self, bounds: &Bounds) -> u64 {
        let own = [load::<S>(&self.min), load::<S>(&self.max)];
        let lanes = (1 << self.len) - 1;
        let bounds =
            [bounds.min, bounds.max].map(|p| [S::splat(p.x), S::splat(p.y), S::splat(p.z)]);
        let mut rows = S::bits(overlap(bounds, [load(&others.min), load(&others.max)]));
        rows &= (1 << others.len) - 1;
        let mut pairs = 0;
        while rows != 0 {
            let row = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let other = [splat(&others.min, row), splat(&others.max, row)];
            let found = S::bits(overlap(own, other)) & lanes;
            pairs |= u64::from(found) << (LANES * row);
        }
        pairs
    }

    /// Those of some pairs that have no certified vertex in common.
    #[inline(always)]
    pub(crate) fn strangers<S: Simd>(&self, others: &Self, pairs: u64) -> u64 {
        let [p, q, r] = load::<S>(&self.vertices);
        let (mut left, mut pending) = (pairs, pairs);
        while pending != 0 {
            let row = pending.trailing_zeros() as usize / LANES % LANES;
            let shift = LANES * row;
            pending &= !(0xff << shift);
            let u = S::splat(others.if_certified(0, row));
            let v = S::splat(others.if_certified(1, row));
            let w = S::splat(others.if_certified(2, row));
            let shared = (p.eq(u) | q.eq(u) | r.eq(u))
                | (p.eq(v) | q.eq(v) | r.eq(v))
                | (p.eq(w) | q.eq(w) | r.eq(w));
            left &= !(u64::from(S::bits(shared)) << shift);
        }
        left
    }

    /// Whether triangle `i` of these and `j` of others have a vertex in common.
    #[inline]
    pub(crate) fn share_vertex(&self, i: usize, others: &Self, j: usize) -> bool {
        let [p, q, r] = [self.vertices[0][i], self.vertices[1][i], self.vertices[2][i]];
        (0..3).any(|k| {
            let v = others.vertices[k][j];
            // One that is no number may be any.
            (v == p) | (v == q) | (v == r) | v.is_nan()
        })
    }

    /// A vertex that is certified, or no number.
    #[inline(always)]
    fn if_certified(&self, corner: usize, lane: usize) -> f32 {
        let certified = self.certified[corner] >> lane & 1 != 0;
        if certified { self.vertices[corner][lane] } else { f32::NAN }
    }

    /// Those of [`Block::strangers`] that may still have a vertex in common: both of a pair have one
    /// that is not certified.
    #[inline(always)]
    pub(crate) fn doubtful(&self, others: &Self, pairs: u64) -> u64 {
        let doubtful =
            |b: &Self| u64::from(!(b.certified[0] & b.certified[1] & b.certified[2]) & 0xff);
        let (own, mut rows) = (doubtful(self), doubtful(others));
        let mut found = 0;
        while own != 0 && rows != 0 {
            found |= own << (LANES as u32 * rows.trailing_zeros());
            rows &= rows - 1;
        }
        pairs & found
    }

    /// Those of some pairs that may meet. `ONE_MESH` if the triangles may have vertices in common.
    #[inline(always)]
    pub(crate) fn undecided<S: Simd, const ONE_MESH: bool>(
        &self,
        others: &Self,
        pairs: u64,
    ) -> u64 {
        let own = self.planes::<S>();
        let own_corners = self.corners_in(load::<S>);
        let mut left = 0;
        let mut pending = pairs;
        while pending != 0 {
            let row = pending.trailing_zeros() as usize / LANES % LANES;
            let shift = LANES * row;
            let mut found = (pending >> shift) as u32 & 0xff;
            pending &= !(0xff << shift);
            let corners = others.corners_in(|p| splat::<S>(p, row));
            found &= !own.apart::<ONE_MESH>(&corners);
            if found != 0 {
                let plane = Planes {
                    corners,
                    normal: splat(&others.normal, row),
                    extent: splat(&others.extent, row),
                };
                found &= !plane.apart::<ONE_MESH>(&own_corners);
                left |= u64::from(found) << shift;
            }
        }
        left
    }

    #[inline(always)]
    fn corners_in<S: Simd>(&self, pick: impl Fn(&Points) -> [S; 3]) -> Corners<S> {
        let [p, q, r] = &self.corners;
        Corners { points: [pick(p), pick(q), pick(r)], vertices: pick(&self.vertices) }
    }

    #[inline(always)]
    fn planes<S: Simd>(&self) -> Planes<S> {
        Planes {
            corners: self.corners_in(load),
            normal: load(&self.normal),
            extent: load(&self.extent),
        }
    }
}

/// The corners of a triangle in each lane.
#[derive(Clone, Copy)]
struct Corners<S> {
    points: [[S; 3]; 3],
    vertices: [S; 3],
}

/// A triangle in each lane, with its plane.
struct Planes<S> {
    corners: Corners<S>,
    normal: [S; 3],
    extent: [S; 3],
}

impl<S: Simd> Planes<S> {
    /// A bit for each lane in which all corners that the triangles do not share are strictly on one side
    /// of the plane, and there is one.
    #[inline(always)]
    fn apart<const ONE_MESH: bool>(&self, of: &Corners<S>) -> u32 {
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

#[inline(always)]
fn load<S: Simd>(p: &Points) -> [S; 3] {
    [S::load(&p[0]), S::load(&p[1]), S::load(&p[2])]
}

#[inline(always)]
fn splat<S: Simd>(p: &Points, lane: usize) -> [S; 3] {
    [S::splat(p[0][lane]), S::splat(p[1][lane]), S::splat(p[2][lane])]
}

#[inline(always)]
fn store<S: Simd>(from: [S; 3], to: &mut Points) {
    for k in 0..3 {
        from[k].store(&mut to[k]);
    }
}

#[inline(always)]
fn difference<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn lowest<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0].min(q[0]), p[1].min(q[1]), p[2].min(q[2])]
}

#[inline(always)]
fn highest<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0].max(q[0]), p[1].max(q[1]), p[2].max(q[2])]
}

#[inline(always)]
fn abs<S: Simd>(p: [S; 3]) -> [S; 3] {
    [p[0].abs(), p[1].abs(), p[2].abs()]
}

/// Where the boxes of two sets, each by its smallest and largest corners, overlap.
#[inline(always)]
fn overlap<S: Simd>([a_min, a_max]: [[S; 3]; 2], [b_min, b_max]: [[S; 3]; 2]) -> S::Mask {
    let along = |k: usize| a_min[k].le(b_max[k]) & b_min[k].le(a_max[k]);
    along(0) & along(1) & along(2)
}

/// How many blocks are kept, a power of two.
const KEPT: usize = 8;

/// The blocks of the leaves last met: a leaf meets several others in a row.
pub(crate) struct Blocks {
    leaves: [u32; KEPT],
    blocks: [Block; KEPT],
}

impl Blocks {
    pub(crate) const EMPTY: Self =
        Self { leaves: [u32::MAX; KEPT], blocks: [const { Block::EMPTY }; KEPT] };

    /// The block of a leaf, the node `leaf`.
    #[inline(always)]
    pub(crate) fn get<'s, S: Simd>(
        &'s mut self,
        leaf: u32,
        mesh: Mesh<'_>,
        triangles: &[u32],
        place: &impl Placement,
        fans: &[Fan],
    ) -> &'s Block {
        let slot = leaf as usize % KEPT;
        if self.leaves[slot] != leaf {
            self.leaves[slot] = leaf;
            self.blocks[slot].fill::<S>(mesh, triangles, place, fans);
        }
        &self.blocks[slot]
    }
}
