//! What parry3d does for two triangles, as for all its convex shapes: GJK.

use parry3d::math::{Pose, Vec3};
use parry3d::query::details::intersection_test_support_map_support_map;
use parry3d::shape::Triangle as Shape;
use pfront::core::Triangle;

pub(super) fn meet(a: &Triangle, b: &Triangle) -> bool {
    let [a, b] = [a, b].map(|t| t.map(Vec3::from_array));
    let [a, b] = [a, b].map(|[p, q, r]| Shape::new(p, q, r));
    intersection_test_support_map_support_map(&Pose::IDENTITY, &a, &b)
}
