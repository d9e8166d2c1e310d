//! The triangles of a leaf, side by side.

use crate::index::at;
use crate::one_ring::OneRing;
use crate::simd::point8::{Points, abs, difference, highest, lanes, load, lowest, store};
use crate::simd::{LANES, Simd};
use crate::transform::Placement;
use crate::{Mesh, Triangle};

/// Up to eight triangles, placed, and their boxes and planes.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(super) len: usize,
    pub(super) corners: [Points; 3],
    /// Vertices as numbers that are equal as they are.
    pub(super) vertices: Points,
    /// For each corner, a bit for the triangles whose vertex there is certified.
    pub(super) certified: [u32; 3],
    pub(super) min: Points,
    pub(super) max: Points,
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
        fans: &[OneRing],
    ) {
        self.len = triangles.len().min(LANES);
        self.certified = [0; 3];
        for (lane, &triangle) in triangles.iter().take(LANES).enumerate() {
            let t = at(mesh.triangles(), triangle);
            for (k, &vertex) in t.iter().enumerate() {
                let p = at(mesh.positions(), vertex);
                self.corners[k][0][lane] = p[0];
                self.corners[k][1][lane] = p[1];
                self.corners[k][2][lane] = p[2];
                // No vertex that a mesh can have memory for becomes zero, of which floats have two. Some
                // above 2^30 become no numbers: they equal nothing, and pass for not certified.
                self.vertices[k][lane] = f32::from_bits(vertex.saturating_add(0x0080_0000));
                if let Some(fan) = fans.get(vertex as usize) {
                    self.certified[k] |= u32::from(fan.is_certified()) << lane;
                }
            }
        }
        if !fans.is_empty() {
            for (certified, numbers) in self.certified.iter_mut().zip(&self.vertices) {
                let mut found = 0;
                for at in lanes::<S>() {
                    let numbers = S::load(numbers, at);
                    found |= S::bits(numbers.eq(numbers)) << at;
                }
                *certified &= found;
            }
        }
        for at in lanes::<S>() {
            self.place::<S>(place, at);
        }
    }

    /// Apart, for both sides of a walk.
    #[inline(never)]
    fn fill_one_by_one(
        &mut self,
        mesh: Mesh<'_>,
        triangles: &[u32],
        place: &impl Placement,
        fans: &[OneRing],
    ) {
        self.fill::<f32>(mesh, triangles, place, fans);
    }

    /// Places the triangles in some lanes, and derives the rest.
    #[inline(always)]
    fn place<S: Simd>(&mut self, place: &impl Placement, at: usize) {
        let p = place.points(load::<S>(&self.corners[0], at));
        let q = place.points(load::<S>(&self.corners[1], at));
        let r = place.points(load::<S>(&self.corners[2], at));
        for (k, placed) in [p, q, r].into_iter().enumerate() {
            store(placed, &mut self.corners[k], at);
        }
        store(lowest(lowest(p, q), r), &mut self.min, at);
        store(highest(highest(p, q), r), &mut self.max, at);
        let (u, v) = (difference(q, p), difference(r, p));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        store(normal, &mut self.normal, at);
        store(highest(abs(u), abs(v)), &mut self.extent, at);
    }

    /// The corners of one of them.
    #[inline]
    pub(crate) fn triangle(&self, lane: u32) -> Triangle {
        let lane = lane as usize % LANES;
        let corner = |p: &Points| [p[0][lane], p[1][lane], p[2][lane]];
        [corner(&self.corners[0]), corner(&self.corners[1]), corner(&self.corners[2])]
    }

    /// Whether triangle `i` of these and `j` of others have a vertex in common.
    #[inline]
    pub(crate) fn share_vertex(&self, i: u32, others: &Self, j: u32) -> bool {
        let (i, j) = (i as usize % LANES, j as usize % LANES);
        let [p, q, r] = [self.vertices[0][i], self.vertices[1][i], self.vertices[2][i]];
        (0..3).any(|k| {
            let v = others.vertices[k][j];
            // One that is no number may be any.
            (v == p) | (v == q) | (v == r) | v.is_nan()
        })
    }
}

/// How many blocks are kept on either side. Where stacks are small, a walk rather fills some again.
const KEPT: usize = if cfg!(feature = "std") { 8 } else { 2 };

/// The blocks of the leaves last met: a leaf meets several others in a row.
pub(crate) struct Blocks {
    leaves: [u32; KEPT],
    blocks: [Block; KEPT],
}

impl Blocks {
    /// To begin with; all zero, which takes no constant. [`Blocks::forget`] comes next.
    pub(crate) const ZERO: Self =
        Self { leaves: [0; KEPT], blocks: [const { Block::EMPTY }; KEPT] };

    /// Keeps none.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        self.leaves = [u32::MAX; KEPT];
    }

    /// The block of a leaf, the node `leaf`.
    #[inline(always)]
    pub(crate) fn get<'s, S: Simd>(
        &'s mut self,
        leaf: u32,
        mesh: Mesh<'_>,
        triangles: &[u32],
        place: &impl Placement,
        fans: &[OneRing],
    ) -> &'s Block {
        let slot = leaf as usize % KEPT;
        if self.leaves[slot] != leaf {
            self.leaves[slot] = leaf;
            if S::WIDTH == 1 {
                self.blocks[slot].fill_one_by_one(mesh, triangles, place, fans);
            } else {
                self.blocks[slot].fill::<S>(mesh, triangles, place, fans);
            }
        }
        &self.blocks[slot]
    }
}
