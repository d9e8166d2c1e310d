//! A triangle of a leaf at both ends of a motion.

use super::MovingTriangle;
use crate::aabb::Bounds;
use crate::bvtt::Bvtt;

/// A triangle of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) corners: MovingTriangle,
    /// Its box at the start and at the end.
    pub(super) boxes: [Bounds; 2],
}

impl Leaf {
    /// A triangle of one side of two queries, at the start and at the end.
    #[inline]
    pub(super) fn of<const SELF: bool>(
        triangle: u32,
        side: usize,
        [start, end]: [&Bvtt<'_, SELF>; 2],
    ) -> Self {
        let (start, at_start) = start.corners_and_box(side, triangle);
        let (end, at_end) = end.corners_and_box(side, triangle);
        Self { corners: [start, end], boxes: [at_start, at_end] }
    }
}
