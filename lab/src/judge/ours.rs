//! The tests of pfront.

use super::Test;
use pfront::pfront_core::bvtt::{PairBvtt, Query};
use pfront::pfront_core::triangle::intersects;
use pfront::pfront_core::{Aabb, Triangle};
use pfront::{Accuracy, Bvh, Mesh, Node, Pose};

/// Ours: the triangle test at each accuracy, and what a query makes of the pair, which decides what it can
/// by certified tests in f32 vectors first.
pub const OURS: [Test; 4] = [
    Test { name: "Exact", meets: |a, b| intersects(a, b, Accuracy::Exact) },
    Test { name: "Exact, in a query", meets: in_query },
    Test { name: "Conservative", meets: |a, b| intersects(a, b, Accuracy::Conservative) },
    Test { name: "Fast", meets: |a, b| intersects(a, b, Accuracy::Fast) },
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
