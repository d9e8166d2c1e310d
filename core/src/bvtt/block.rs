//! The triangles of a leaf in vector lanes.

use crate::index::{at, out_of_range};
use crate::one_ring::OneRing;
use crate::pose::Affine;
use crate::simd::point8::{Points, abs, difference, highest, lanes, load, lowest, store};
use crate::simd::{LANES, Simd, VECTORS};
use crate::{Aabb, Mesh, Triangle};

/// A leaf: its triangles, their pose, and the certificates of their vertices.
#[derive(Clone, Copy)]
pub(super) struct Leaf<'a> {
    pub(super) mesh: Mesh<'a>,
    pub(super) triangles: &'a [u32],
    pub(super) pose: Option<&'a Affine>,
    /// A box that contains the posed triangles.
    pub(super) bounds: Aabb,
    pub(super) rings: &'a [OneRing],
}

/// Up to eight posed triangles with their boxes and planes.
#[derive(Clone, Debug)]
pub(super) struct TriangleBlock {
    /// Indices of the triangles.
    pub(super) triangles: [u32; LANES],
    pub(super) len: usize,
    pub(super) corners: [Points; 3],
    /// The vertex of each corner as a float that equals no other vertex's, see [`vertex_key`].
    pub(super) vertices: Points,
    /// For each corner, the lanes whose vertex there is certified, as bits.
    pub(super) certified: [u32; 3],
    pub(super) min: Points,
    pub(super) max: Points,
    pub(super) normal: Points,
    /// For each axis, the larger extent of the two edges from the first corner.
    pub(super) extent: Points,
    /// A box that contains all triangles.
    pub(super) bounds: Aabb,
}

/// A float for each vertex index, equal only to itself, so that lanes of floats can compare vertices: normal numbers
/// from the smallest on, NaN above 2^31 − 2^24. A NaN equals nothing, and is decided vertex by vertex.
pub(super) fn vertex_key(vertex: u32) -> f32 {
    f32::from_bits(vertex.saturating_add(f32::MIN_POSITIVE.to_bits()))
}

impl TriangleBlock {
    fn empty() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            triangles: [0; LANES],
            len: 0,
            corners: [zero; 3],
            vertices: zero,
            certified: [0; 3],
            min: zero,
            max: zero,
            normal: zero,
            extent: zero,
            bounds: Aabb { min: [0.0; 3], max: [0.0; 3] },
        }
    }

    /// Loads, poses and prepares the triangles of a leaf.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, leaf: &Leaf<'_>) {
        if leaf.triangles.len() > LANES {
            out_of_range();
        }
        (self.len, self.bounds) = (leaf.triangles.len(), leaf.bounds);
        self.certified = [0; 3];
        // Lanes without a triangle stay zero, so that arithmetic on them is neither slow nor a trap.
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for (lane, &triangle) in leaf.triangles.iter().enumerate() {
            let lane = lane % LANES;
            self.triangles[lane] = triangle;
            let vertices = at(leaf.mesh.triangles(), triangle);
            for (k, &vertex) in vertices.iter().enumerate() {
                let [x, y, z] = *at(leaf.mesh.positions(), vertex);
                (corners[k][0][lane], corners[k][1][lane], corners[k][2][lane]) = (x, y, z);
                let key = vertex_key(vertex);
                self.vertices[k][lane] = key;
                if let Some(ring) = leaf.rings.get(vertex as usize) {
                    self.certified[k] |= u32::from(ring.is_certified() && !key.is_nan()) << lane;
                }
            }
        }
        for at in lanes::<S>() {
            let mut posed =
                [load::<S>(&corners[0], at), load(&corners[1], at), load(&corners[2], at)];
            if let Some(affine) = leaf.pose {
                posed = [affine.points(posed[0]), affine.points(posed[1]), affine.points(posed[2])];
            }
            self.derive(posed, at);
        }
    }

    /// [`TriangleBlock::fill`] without vectors: one copy for both sides, for firmware.
    #[inline(never)]
    fn fill_singly(&mut self, leaf: &Leaf<'_>) {
        self.fill::<f32>(leaf);
    }

    /// Stores posed corners and derives boxes and planes, in the lanes from `at` on.
    #[inline(always)]
    fn derive<S: Simd>(&mut self, [p, q, r]: [[S; 3]; 3], at: usize) {
        store(p, &mut self.corners[0], at);
        store(q, &mut self.corners[1], at);
        store(r, &mut self.corners[2], at);
        store(lowest(lowest(p, q), r), &mut self.min, at);
        store(highest(highest(p, q), r), &mut self.max, at);
        let (u, v) = (difference(q, p), difference(r, p));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        store(normal, &mut self.normal, at);
        store(highest(abs(u), abs(v)), &mut self.extent, at);
    }

    /// The posed corners in a lane.
    #[inline]
    pub(super) fn triangle(&self, lane: usize) -> Triangle {
        let lane = lane % LANES;
        self.corners.each_ref().map(|[x, y, z]| [x[lane], y[lane], z[lane]])
    }

    /// Lanes that hold a triangle.
    #[inline(always)]
    pub(super) fn lanes(&self) -> u32 {
        (1 << self.len) - 1
    }
}

/// How many blocks a [`BlockCache`] holds. Processors without vectors have small stacks.
const CACHED: usize = if VECTORS { 8 } else { 2 };

/// The blocks of the leaves that one side of a traversal visited last: a leaf is visited with several others in a row.
pub(super) struct BlockCache {
    leaves: [u32; CACHED],
    /// Set up when first used, since most small queries use few.
    blocks: [Option<TriangleBlock>; CACHED],
}

impl BlockCache {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { leaves: [u32::MAX; CACHED], blocks: core::array::from_fn(|_| None) }
    }

    /// The block of `leaf`, the node with index `node`.
    #[inline(always)]
    pub(super) fn get<'a, S: Simd>(
        &mut self,
        node: u32,
        leaf: impl FnOnce() -> Leaf<'a>,
    ) -> &TriangleBlock {
        let slot = node as usize % CACHED;
        let block = self.blocks[slot].get_or_insert_with(TriangleBlock::empty);
        if self.leaves[slot] != node {
            self.leaves[slot] = node;
            if S::WIDTH == 1 { block.fill_singly(&leaf()) } else { block.fill::<S>(&leaf()) }
        }
        block
    }
}
