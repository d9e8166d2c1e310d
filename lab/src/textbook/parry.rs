//! The test of parry3d for two triangles, as for all its convex shapes: GJK.
//!
//! It panics where its arithmetic overflows (coordinates near the ends of the range of f32). The panic is
//! caught, without a word on standard error, and passes for "they meet".

use parry3d::math::{Pose, Vec3};
use parry3d::query::details::intersection_test_support_map_support_map;
use parry3d::shape::Triangle as Shape;
use pfront::pfront_core::Triangle;
use std::cell::Cell;
use std::panic;
use std::sync::Once;

thread_local! {
    static IS_ASKED: Cell<bool> = const { Cell::new(false) };
}

pub(super) fn meet(a: &Triangle, b: &Triangle) -> bool {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !IS_ASKED.get() {
                usual(info);
            }
        }));
    });
    let [a, b] = [a, b].map(|t| t.map(Vec3::from_array));
    let [a, b] = [a, b].map(|[p, q, r]| Shape::new(p, q, r));
    IS_ASKED.set(true);
    let found =
        panic::catch_unwind(|| intersection_test_support_map_support_map(&Pose::IDENTITY, &a, &b));
    IS_ASKED.set(false);
    found.unwrap_or(true)
}
