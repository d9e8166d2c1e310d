//! The start or the end of a motion, as the traversal of motions sees it.

use super::{Bvtt, PosedBvh};
use crate::Mesh;
use crate::aabb::Bounds;
use crate::triangle::Adjacency;
use glam::Vec3A;

impl<'a, const SELF: bool> Bvtt<'a, SELF> {
    /// Whether both meshes have triangles.
    pub(crate) fn has_roots(&self) -> bool {
        self.a.bvh.root().is_some() && self.b.bvh.root().is_some()
    }

    fn side(&self, side: usize) -> &PosedBvh<'a> {
        if side == 0 { &self.a } else { &self.b }
    }

    pub(crate) fn mesh_of(&self, side: usize) -> Mesh<'a> {
        self.side(side).bvh.mesh()
    }

    pub(crate) fn triangles_of_leaf(&self, side: usize, node: u32) -> &'a [u32] {
        let bvh = &self.side(side).bvh;
        bvh.leaf_triangles(bvh.node(node))
    }

    /// The corners of a triangle of one side as they are posed, whatever they are posed in.
    pub(crate) fn corners_in_f64(&self, side: usize, triangle: u32) -> [[f64; 3]; 3] {
        let side = self.side(side);
        match self.error() {
            None => side.triangle(triangle).map(|p| p.map(f64::from)),
            Some(_) => side.triangle_f64(triangle),
        }
    }

    /// A box that contains a triangle of one side, in the frame of the query, or one that moves with it.
    #[inline]
    pub(crate) fn bounds_of_triangle(&self, side: usize, triangle: u32) -> Bounds {
        let [p, q, r] = self.side(side).triangle(triangle).map(Vec3A::from_array);
        // The error is that of two corners.
        let error = self.error().unwrap_or(Vec3A::ZERO);
        Bounds { min: p.min(q).min(r) - error, max: p.max(q).max(r) + error }
    }

    pub(crate) fn adjacency(&self) -> Adjacency {
        self.adjacency
    }
}
