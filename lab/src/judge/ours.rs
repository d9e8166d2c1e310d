//! The tests of pfront.

use super::Test;
use pfront::pfront_core::bvtt::{PairBvtt, Query};
use pfront::pfront_core::triangle::intersects;
use pfront::pfront_core::{Aabb, Triangle};
use pfront::{Bvh, Mesh, Node, Pose};

/// The triangle test, and what a query makes of the pair, which decides what it can by certified tests in f32 vectors
/// first.
pub const OURS: [Test; 2] = [
    Test { name: "Exact", meets: intersects },
    Test { name: "Exact, in a query", meets: in_query },
];

/// Asks a query about two meshes of one triangle each.
fn in_query(a: &Triangle, b: &Triangle) -> bool {
    let leaves = [a, b].map(|corners| {
        let Aabb { min, max } = Aabb::of(corners);
        [Node { min, max, first: 0, count: 1 }]
    });
    let bvh = |i: usize, corners| {
        Bvh::new_unchecked(Mesh::new_unchecked(corners, &[[0, 1, 2]]), &leaves[i], &[0])
    };
    let query = PairBvtt::new(bvh(0, a), bvh(1, b), Pose::IDENTITY);
    query.is_ok_and(|query| query.count() > 0)
}
