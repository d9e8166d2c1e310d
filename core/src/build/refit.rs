//! Boxes for a deformed mesh, and how good a tree still is.
//!
//! The surface area heuristic: a random line meets a convex box with a probability proportional to
//! its area. It is usual to divide by the area of the root; dividing by the areas of the triangles'
//! own boxes instead makes the figure a cost per useful hit, which neither a mesh that spreads out
//! or folds up nor one that moves as a whole changes much.

use crate::bvh::Node;
use crate::{Aabb, Bvh, Mesh};

/// Rebuild once the [`quality()`] of a refitted tree is above this many times what it was when
/// built.
///
/// Measured on self-collision of 60,000 to 80,000 triangles, refitted against rebuilt. Where
/// triangles drift apart at random, the walk takes 1.9 times as long at a ratio of 1.12 and 3.5
/// times at 1.38. A swirl that shears them stops at 1.26, while the walk gets 1.55 times as long at
/// 1.22 and then 3.6 times. A sheet that is twisted, rolled up or crumpled reaches 1.42 at most,
/// and its walk never takes above 1.13 times as long: it is rebuilt once or twice without need.
///
/// # Examples
/// ```
/// use pfront_core::Mesh;
/// use pfront_core::build::{REBUILD_RATIO, BuildOptions, BvhStorage, morton, quality, refit};
/// # use pfront_core::Node;
/// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// # let (mut nodes, mut order, mut keys) = ([Node::EMPTY; 2], [0; 1], [0; 2]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut keys)?;
/// let (used, when_built) = (bvh.nodes().len(), quality(&bvh));
///
/// let moved = mesh.with_positions(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]])?;
/// let now = refit(moved, &mut nodes[..used], &order);
/// assert!(now <= REBUILD_RATIO * when_built, "time to rebuild");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub const REBUILD_RATIO: f32 = 1.2;

/// Fits the boxes of a tree to new positions of its mesh, in one pass from the last node to the
/// first; returns its [`quality()`].
///
/// `nodes` and `order` are those of a BVH of a mesh with the same triangles.
///
/// # Panics
/// If they are not: see [`Bvh::new`].
///
/// # Complexity
/// O(triangles).
pub fn refit(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32]) -> f32 {
    let mut areas = Areas::default();
    for index in (0..nodes.len()).rev().filter(|&index| index != 1) {
        let node = nodes[index];
        let first = node.first as usize;
        let aabb = if node.is_leaf() {
            areas.add_leaf(mesh, &order[first..first + node.count as usize])
        } else {
            areas.add_inner(nodes[first].aabb().union(&nodes[first + 1].aabb()))
        };
        nodes[index].set_aabb(&aabb);
    }
    areas.quality()
}

/// How many tests a random line is expected to need for each triangle whose box it meets: two box
/// tests in every inner node that it meets and a test of every triangle in a leaf that it meets.
/// Lower is better.
///
/// Finite and at least 0 for every tree. Where no triangle's box has an area, it is the tests for
/// each line that meets the root; where the root has none either, 0.
///
/// # Complexity
/// O(triangles).
#[must_use]
pub fn quality(bvh: &Bvh<'_>) -> f32 {
    let mut areas = Areas::default();
    for (_, node) in bvh.nodes().iter().enumerate().rev().filter(|&(index, _)| index != 1) {
        if node.is_leaf() {
            areas.add_leaf(bvh.mesh(), bvh.leaf_triangles(node));
        } else {
            areas.add_inner(node.aabb());
        }
    }
    areas.quality()
}

/// Half-areas summed over a tree from the last node to the root.
#[derive(Default)]
struct Areas {
    /// Times the tests that meeting the box entails.
    tests: f64,
    triangles: f64,
    /// Of the last node added.
    root: f64,
}

impl Areas {
    /// Returns the box of the triangles.
    // Unless inlined, the box comes back through memory, and a refit takes a sixth longer.
    #[inline(always)]
    fn add_leaf(&mut self, mesh: Mesh<'_>, triangles: &[u32]) -> Aabb {
        let (mut aabb, mut area) = (Aabb::EMPTY, 0.0);
        for &triangle in triangles {
            let of_one = Aabb::of(&mesh.triangle(triangle));
            area += half_area(&of_one);
            aabb = aabb.union(&of_one);
        }
        self.triangles += area;
        self.root = half_area(&aabb);
        self.tests += triangles.len() as f64 * self.root;
        aabb
    }

    fn add_inner(&mut self, aabb: Aabb) -> Aabb {
        self.root = half_area(&aabb);
        self.tests += 2.0 * self.root;
        aabb
    }

    fn quality(&self) -> f32 {
        let unit = if self.triangles > 0.0 { self.triangles } else { self.root };
        if unit > 0.0 { (self.tests / unit).min(f32::MAX.into()) as f32 } else { 0.0 }
    }
}

/// In f64, whose range holds the areas of all f32 boxes. An edge longer than [`f32::MAX`] counts as
/// that long.
fn half_area(aabb: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from((aabb.max[k] - aabb.min[k]).min(f32::MAX)));
    x * (y + z) + y * z
}
