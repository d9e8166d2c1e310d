//! The triangles of a leaf at both ends of a motion.

use super::MovingTriangle;
use crate::aabb::Bounds;
use crate::bvh::MAX_LEAF_SIZE;
use crate::bvtt::Bvtt;

/// A triangle of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) triangle: u32,
    pub(super) corners: MovingTriangle,
    /// Its box at the start and at the end.
    pub(super) boxes: [Bounds; 2],
}

impl Leaf {
    /// A triangle of one side of two queries, at the start and at the end.
    pub(super) fn of<const SELF: bool>(
        triangle: u32,
        side: usize,
        ends: [&Bvtt<'_, SELF>; 2],
    ) -> Self {
        let corners = ends.map(|query| query.corners_in_f64(side, triangle));
        let boxes = ends.map(|query| query.bounds_of_triangle(side, triangle));
        Self { triangle, corners, boxes }
    }
}

/// The triangles of the leaf that was asked for last, since a traversal comes upon the same leaf many times in a row.
pub(super) struct LeafCache {
    node: Option<u32>,
    len: usize,
    triangles: [Leaf; MAX_LEAF_SIZE as usize],
}

impl LeafCache {
    pub(super) fn new() -> Self {
        let none = Leaf { triangle: 0, corners: [[[0.0; 3]; 3]; 2], boxes: [Bounds::EMPTY; 2] };
        Self { node: None, len: 0, triangles: [none; MAX_LEAF_SIZE as usize] }
    }

    /// The triangles of a leaf of one side of two queries, at the start and at the end.
    pub(super) fn get<const SELF: bool>(
        &mut self,
        node: u32,
        side: usize,
        ends: [&Bvtt<'_, SELF>; 2],
    ) -> &[Leaf] {
        if self.node != Some(node) {
            let triangles = ends[0].triangles_of_leaf(side, node);
            self.len = triangles.len();
            for (slot, &triangle) in self.triangles.iter_mut().zip(triangles) {
                *slot = Leaf::of(triangle, side, ends);
            }
            self.node = Some(node);
        }
        &self.triangles[..self.len]
    }
}
