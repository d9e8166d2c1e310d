//! Triangles of one side of a query, or of a posed mesh, in leaves whose boxes are near a point, a triangle or a segment.

use super::PairBvtt;
use super::posed_bvh::{PosedBvh, posed};
use crate::Bvh;
use crate::aabb::Bounds;
use crate::bvh::MAX_DEPTH;
use crate::pose::Affine;
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
        visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (bvh, pose) = (&self.sides()[side].bvh, self.box_poses[side].as_ref());
        visit_leaves(bvh, pose, |found| found.overlaps(bounds), visit)
    }
}

impl PosedBvh<'_> {
    /// Visits the triangles in leaves that `reaches` by their boxes, as they are posed, until `visit` breaks.
    pub(crate) fn visit_reached(
        &self,
        reaches: impl FnMut(&Bounds) -> bool,
        visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        visit_leaves(&self.bvh, self.pose.as_ref(), reaches, visit)
    }

    /// The corners of a triangle as they are posed, in f32 or in f64.
    pub(crate) fn corners(&self, triangle: u32) -> [[f64; 3]; 3] {
        match self.is_f64() {
            false => self.triangle(triangle).map(|corner| corner.map(f64::from)),
            true => self.triangle_f64(triangle),
        }
    }
}

/// Visits the triangles of leaves below nodes that `reaches` by their posed boxes, until `visit` breaks.
#[inline]
fn visit_leaves(
    bvh: &Bvh<'_>,
    pose: Option<&Affine>,
    mut reaches: impl FnMut(&Bounds) -> bool,
    mut visit: impl FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    // Each level above the current node has at most one right child waiting.
    let (mut waiting, mut len) = ([0; MAX_DEPTH + 1], 0);
    let mut next = bvh.root().map(|_| 0);
    while let Some(index) = next {
        let node = bvh.node(index);
        next = None;
        if reaches(&posed(pose, &node.bounds())) {
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
