//! A triangle of the SAH build: its index and its box, as a node.

use crate::Node;
use crate::aabb::Bounds;
use glam::{Vec3A, Vec4};

/// The bits of 1.0, added to an index. Arithmetic runs over all four lanes, and is slow on subnormal numbers, which the
/// bits of an index would be.
const NORMAL: u32 = 1_f32.to_bits();

/// A triangle as an item of a run.
#[inline(always)]
pub(super) fn item(triangle: u32, bounds: &Bounds) -> Node {
    let Bounds { min, max } = bounds;
    Node { min: min.to_array(), first: triangle + NORMAL, max: max.to_array(), count: 0 }
}

pub(super) fn triangle(item: &Node) -> u32 {
    item.first - NORMAL
}

/// The box of an item, loaded whole.
#[inline(always)]
pub(super) fn bounds(item: &Node) -> Bounds {
    let [min, max]: [Vec4; 2] = bytemuck::must_cast(*item);
    Bounds { min: Vec3A::from_vec4(min), max: Vec3A::from_vec4(max) }
}
