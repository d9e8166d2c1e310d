//! Triangles of one side of a query near a point or a triangle of either side, and above it.

use super::PairBvtt;
use super::posed_bvh::{PosedBvh, posed};
use crate::aabb::Bounds;
use crate::bvh::MAX_DEPTH;
use core::ops::ControlFlow;
use glam::Vec3A;

impl<'a> PairBvtt<'a> {
    /// Both sides.
    #[inline]
    pub(crate) fn sides(&self) -> [&PosedBvh<'a>; 2] {
        [&self.a, &self.b]
    }

    /// Whether positions are posed and decided in f64.
    #[inline]
    pub(crate) fn is_f64(&self) -> bool {
        self.error().is_some()
    }

    /// A box that contains a posed triangle of a side, in the frame in which boxes are compared.
    pub(crate) fn box_of_triangle(&self, side: usize, triangle: u32) -> Bounds {
        let bounds = self.sides()[side].bvh.mesh().bounds(triangle);
        posed(self.box_poses[side].as_ref(), &bounds)
    }

    /// A box that contains the ray from a posed vertex of a side along an axis, in the same frame, which has the axes of the
    /// query if the first mesh is not posed.
    pub(crate) fn box_of_ray(&self, side: usize, vertex: u32, axis: usize) -> Bounds {
        let shadow = self.sides()[side].bvh.mesh().shadow();
        let point = Bounds::of(Vec3A::from_array(shadow[vertex as usize]));
        let mut ray = posed(self.box_poses[side].as_ref(), &point);
        ray.max[axis] = f32::INFINITY;
        ray
    }

    /// Visits the triangles of a side in leaves whose boxes overlap `bounds`, until `visit` breaks.
    pub(crate) fn visit_overlapping(
        &self,
        side: usize,
        bounds: &Bounds,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (bvh, pose) = (&self.sides()[side].bvh, self.box_poses[side].as_ref());
        // Each level above the current node has at most one right child waiting.
        let (mut waiting, mut len) = ([0; MAX_DEPTH + 1], 0);
        let mut next = bvh.root().map(|_| 0);
        while let Some(index) = next {
            let node = bvh.node(index);
            next = None;
            if posed(pose, &node.bounds()).overlaps(bounds) {
                if node.is_leaf() {
                    bvh.leaf_triangles(node).iter().try_for_each(|&triangle| visit(triangle))?;
                } else {
                    waiting[len] = node.left() + 1;
                    len += 1;
                    next = Some(node.left());
                }
            }
            if next.is_none() && len > 0 {
                len -= 1;
                next = Some(waiting[len]);
            }
        }
        ControlFlow::Continue(())
    }
}
