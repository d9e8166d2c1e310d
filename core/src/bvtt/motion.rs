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

    /// The same with boxes of nodes that contain all those of their triangles, as [`Bvtt::corners_and_box`] has them.
    ///
    /// Boxes of the second side that reach as far as a distance d are off by three roundings of d, and those of its triangles by two; so nodes
    /// reach 2^-20 d farther.
    pub(crate) fn with_boxes_of_corners(mut self) -> Self {
        if let Some(distance) = self.reach() {
            let [_, pose] = &mut self.box_poses;
            *pose = pose.map(|pose| pose.grown(Vec3A::splat(distance * (1.0 / 1_048_576.0))));
        }
        if let Some(error) = self.error() {
            self.box_poses = self.box_poses.map(|pose| pose.map(|pose| pose.grown(error)));
        }
        self
    }

    pub(crate) fn is_boxes_only(&self) -> bool {
        SELF && self.boxes_only
    }

    pub(super) fn side(&self, side: usize) -> &PosedBvh<'a> {
        if side == 0 { &self.a } else { &self.b }
    }

    pub(crate) fn mesh_of(&self, side: usize) -> Mesh<'a> {
        self.side(side).bvh.mesh()
    }

    /// How far the difference of two corners in lanes may be from that of what they stand for, if they are shadows.
    pub(crate) fn error_of_lanes(&self) -> Option<[f32; 3]> {
        self.error().map(|error| error.to_array())
    }

    /// How far boxes of the second side reach on each axis, with the distance, if one is asked for.
    pub(crate) fn growth_of_second(&self) -> [f32; 3] {
        self.box_poses[1].map_or([0.0; 3], |pose| pose.padding().to_array())
    }

    /// The corners of a triangle of one side as they are posed, whatever they are posed in, and a box that contains them in the frame of the query
    /// or one that moves with it; that of the second side contains all that is within the distance.
    #[inline]
    pub(crate) fn corners_and_box(&self, side: usize, triangle: u32) -> ([[f64; 3]; 3], Bounds) {
        let reach = self.reach().filter(|_| side == 1);
        let side = self.side(side);
        let [p, q, r] = side.triangle(triangle);
        let [p, q, r] = [Vec3A::from_array(p), Vec3A::from_array(q), Vec3A::from_array(r)];
        let bounds = |error| {
            let bounds = Bounds { min: p.min(q).min(r) - error, max: p.max(q).max(r) + error };
            reach.map_or(bounds, |distance| around(&bounds, distance))
        };
        match self.error() {
            None => {
                let in_f64 = |p: Vec3A| p.as_dvec3().to_array();
                ([in_f64(p), in_f64(q), in_f64(r)], bounds(Vec3A::ZERO))
            }
            // The error is that of two corners.
            Some(error) => (side.triangle_f64(triangle), bounds(error)),
        }
    }

    pub(crate) fn adjacency(&self) -> Adjacency {
        self.adjacency
    }
}

/// A box that contains all that is so near another, rounded outwards.
fn around(bounds: &Bounds, distance: f32) -> Bounds {
    let rounded = |v: Vec3A, to: fn(f32) -> f32| Vec3A::from_array(v.to_array().map(to));
    Bounds {
        min: rounded(bounds.min - distance, f32::next_down),
        max: rounded(bounds.max + distance, f32::next_up),
    }
}
