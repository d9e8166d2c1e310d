//! Boxes for a deformed mesh, and how good a tree still is.

use crate::bvh::Node;
use crate::{Aabb, Mesh};

/// Rebuild once the [`quality`] of a refitted tree is this many times what it was when built.
pub const REBUILD_RATIO: f32 = 1.5;

/// Fits the boxes of a tree to new positions of its mesh, in one pass from the last node to the
/// first; returns its [`quality`].
///
/// `nodes` and `order` are those of a BVH of a mesh with the same triangles.
///
/// # Panics
/// If they are not: see [`Bvh::new`](crate::Bvh::new).
///
/// # Complexity
/// O(triangles).
pub fn refit(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32]) -> f32 {
    refit_boxes(mesh, nodes, order);
    quality(nodes)
}

pub(super) fn refit_boxes(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32]) {
    for index in (0..nodes.len()).rev().filter(|&i| i != 1) {
        let node = nodes[index];
        let first = node.first as usize;
        let aabb = if node.is_leaf() {
            let run = &order[first..first + node.count as usize];
            run.iter().fold(Aabb::EMPTY, |b, &t| b.union(&Aabb::of(&mesh.triangle(t))))
        } else {
            nodes[first].aabb().union(&nodes[first + 1].aabb())
        };
        nodes[index].set_aabb(&aabb);
    }
}

/// How many tests a random line that meets the root box is expected to need: two box tests per
/// inner node and one triangle test per triangle, each weighted by the half-area of the node's box
/// over that of the root's (the surface area heuristic). Lower is better.
///
/// Finite and at least 0 for every tree. Where the root has no area, every node counts as met.
///
/// # Complexity
/// O(nodes).
#[must_use]
pub fn quality(nodes: &[Node]) -> f32 {
    let root = nodes.first().map_or(0.0, half_area);
    let mut sum = 0.0;
    for (_, node) in nodes.iter().enumerate().filter(|&(i, _)| i != 1) {
        let tests = if node.is_leaf() { f64::from(node.count) } else { 2.0 };
        sum += tests * (half_area(node) / root).min(1.0);
    }
    sum as f32
}

/// In f64, whose range holds the areas of every f32 box.
fn half_area(node: &Node) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(node.max[k]) - f64::from(node.min[k]));
    x * y + y * z + z * x
}
