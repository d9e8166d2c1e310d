//! The triangles of a leaf in vector lanes.

use super::PosedBvh;
use super::trees::Shared;
use crate::Triangle;
use crate::aabb::Bounds;
use crate::bvh::MAX_LEAF_SIZE;
use crate::simd::point8::{
    Points, abs, chunk_starts, cross, difference, highest, load, lowest, store,
};
use crate::simd::{LANES, Simd, VECTORS};
use glam::Vec3A;

const _: () = assert!(LANES == MAX_LEAF_SIZE as usize, "a block holds a leaf");

/// Up to eight posed triangles with their boxes and planes.
#[derive(Clone, Debug)]
pub(super) struct TriangleBlock {
    /// The leaf that was loaded, as the index of its node.
    node: u32,
    /// Indices of the triangles.
    pub(super) triangles: [u32; LANES],
    pub(super) len: usize,
    pub(super) corners: [Points; 3],
    /// The vertex of each corner as a float that equals no other vertex's, see [`vertex_key`]; of triangles of one mesh only.
    pub(super) vertices: Points,
    /// For each corner, the lanes whose vertex there is certified, as bits.
    pub(super) certified: [u32; 3],
    pub(super) min: Points,
    pub(super) max: Points,
    pub(super) normal: Points,
    /// For each axis, the larger extent of the two edges from the first corner.
    pub(super) extent: Points,
    /// A box that contains all triangles.
    pub(super) bounds: Bounds,
}

/// A float for each vertex index, so that lanes of floats can compare vertices. Different vertices have different keys. A
/// key is NaN, which does not even equal itself, for some indices above 2^31 − 2^24: such a vertex counts as not
/// certified, and whether it is shared is left to [`intersects_in_mesh`](crate::triangle::intersects_in_mesh), which
/// compares indices.
pub(super) fn vertex_key(vertex: u32) -> f32 {
    f32::from_bits(vertex.saturating_add(f32::MIN_POSITIVE.to_bits()))
}

impl TriangleBlock {
    fn empty() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            node: u32::MAX,
            triangles: [0; LANES],
            len: 0,
            corners: [zero; 3],
            vertices: zero,
            certified: [0; 3],
            min: zero,
            max: zero,
            normal: zero,
            extent: zero,
            bounds: Bounds::of(Vec3A::ZERO),
        }
    }

    /// Loads, poses and prepares the triangles of the leaf with index `node`. With `SELF`, vertices are certified as `shared` says.
    #[inline(always)]
    fn fill<S: Simd, const SELF: bool>(
        &mut self,
        node: u32,
        side: &PosedBvh<'_>,
        shared: Shared<'_>,
    ) {
        let (leaf, mesh) = (side.bvh.node(node), side.bvh.mesh());
        let triangles = side.bvh.leaf_triangles(leaf);
        (self.node, self.len) = (node, triangles.len());
        self.bounds = side.bounds(leaf);
        let mut certified = [0; 3];
        // Lanes without a triangle hold a posed origin, so that arithmetic on them is neither slow nor a trap.
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for (lane, &triangle) in triangles.iter().enumerate() {
            let lane = lane % LANES;
            self.triangles[lane] = triangle;
            let vertices = &mesh.triangles()[triangle as usize];
            for (k, &vertex) in vertices.iter().enumerate() {
                let [x, y, z] = mesh.shadow()[vertex as usize];
                (corners[k][0][lane], corners[k][1][lane], corners[k][2][lane]) = (x, y, z);
                if SELF {
                    self.vertices[k][lane] = vertex_key(vertex);
                    certified[k] |= u32::from(shared.has_certified_ring(vertex)) << lane;
                }
            }
        }
        if SELF {
            self.certify::<S>(if shared.none_is_hit { [u32::MAX; 3] } else { certified });
        }
        for lane in chunk_starts::<S>() {
            let mut posed =
                [load::<S>(&corners[0], lane), load(&corners[1], lane), load(&corners[2], lane)];
            if let Some(affine) = &side.pose {
                posed = [affine.points(posed[0]), affine.points(posed[1]), affine.points(posed[2])];
            }
            self.derive(posed, lane);
        }
    }

    /// Certifies vertices, but none whose key is NaN.
    #[inline(always)]
    fn certify<S: Simd>(&mut self, mut certified: [u32; 3]) {
        for (keys, certified) in self.vertices.iter().zip(&mut certified) {
            let mut known = 0;
            for at in chunk_starts::<S>() {
                let keys = S::load(keys, at);
                known |= S::bits(keys.eq(keys)) << at;
            }
            *certified &= known;
        }
        self.certified = certified;
    }

    /// Stores posed corners and derives boxes and planes, in the lanes from `lane` on.
    #[inline(always)]
    fn derive<S: Simd>(&mut self, [p, q, r]: [[S; 3]; 3], lane: usize) {
        store(p, &mut self.corners[0], lane);
        store(q, &mut self.corners[1], lane);
        store(r, &mut self.corners[2], lane);
        store(lowest(lowest(p, q), r), &mut self.min, lane);
        store(highest(highest(p, q), r), &mut self.max, lane);
        let (u, v) = (difference(q, p), difference(r, p));
        store(cross(u, v), &mut self.normal, lane);
        store(highest(abs(u), abs(v)), &mut self.extent, lane);
    }

    /// The smallest and the largest corner of a box that contains all triangles, in every lane.
    #[inline(always)]
    pub(super) fn around<S: Simd>(&self) -> [[S; 3]; 2] {
        let Bounds { min, max } = self.bounds;
        [
            [S::splat(min.x), S::splat(min.y), S::splat(min.z)],
            [S::splat(max.x), S::splat(max.y), S::splat(max.z)],
        ]
    }

    /// The posed corners in a lane.
    #[inline]
    pub(super) fn triangle(&self, lane: usize) -> Triangle {
        let lane = lane % LANES;
        self.corners.each_ref().map(|[x, y, z]| [x[lane], y[lane], z[lane]])
    }

    /// Lanes that hold a triangle, as bits.
    #[inline(always)]
    pub(super) fn occupied_mask(&self) -> u32 {
        (1 << self.len) - 1
    }
}

/// How many blocks a [`BlockCache`] holds. A policy: both sides together take 13 KiB of stack.
/// Processors without vectors have small stacks.
const CACHED: usize = if VECTORS { 8 } else { 2 };

/// The blocks of the leaves that one side of a traversal visited last: a leaf is visited with several others in a row.
/// Blocks are set up when first used, since most small queries use few.
pub(super) struct BlockCache([Option<TriangleBlock>; CACHED]);

impl BlockCache {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self(core::array::from_fn(|_| None))
    }

    /// The block of the leaf with index `node`.
    #[inline(always)]
    pub(super) fn get<S: Simd, const SELF: bool>(
        &mut self,
        node: u32,
        side: &PosedBvh<'_>,
        shared: Shared<'_>,
    ) -> &TriangleBlock {
        let block = self.0[node as usize % CACHED].get_or_insert_with(TriangleBlock::empty);
        if block.node != node {
            block.fill::<S, SELF>(node, side, shared);
        }
        block
    }
}
