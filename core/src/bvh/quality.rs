//! How good a refitted tree still is.
//!
//! The surface area heuristic (Goldsmith & Salmon 1987): a random line meets a convex box with a probability
//! proportional to its area. So the area of a node over the mean area of the triangles' boxes in it is the number of
//! triangles that are expected to meet the node.
//!
//! Where we depart: each node is judged by the triangles below it instead of by all or by the root, and counts as met
//! by these at least and by all triangles of the mesh at most. So a triangle far away, whose ancestors are larger than
//! everything else together, does not hide what happens among the others.

use crate::Node;
use crate::aabb::Bounds;
use crate::{Aabb, Bvh, Mesh};

/// Rebuild a tree once its [`quality()`] is above this many times what it was when built. A policy: a query then takes about a
/// fifth longer than it could.
///
/// # Examples
/// ```
/// use pfront_core::Mesh;
/// use pfront_core::bvh::{REBUILD_RATIO, BuildOptions, BvhStorage, Refit, morton, quality, refit};
/// # use pfront_core::Node;
/// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// # let (mut nodes, mut order, mut keys) = ([Node::EMPTY; 2], [0; 1], [0; 2]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut keys)?;
/// let (used, when_built) = (bvh.nodes().len(), quality(&bvh));
///
/// let moved = mesh.with_positions(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]])?;
/// let now = refit(moved, &mut nodes[..used], &order, Refit::default())?;
/// assert!(now <= REBUILD_RATIO * when_built, "time to rebuild");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub const REBUILD_RATIO: f32 = 1.2;

/// The number of tests that a triangle of the mesh is expected to need to find those near it: two box tests in every inner node
/// that it meets and a test of every triangle in a leaf that it meets. Lower is better.
///
/// Finite and at least 0 for every tree, 0 for an empty one. A node whose triangles all have boxes without area counts
/// as met by every triangle of the mesh.
///
/// # Complexity
/// O(triangles).
#[must_use]
pub fn quality(bvh: &Bvh<'_>) -> f32 {
    bvh.root().map_or(0.0, |root| expected_tests(bvh, root).quality(bvh.mesh()))
}

fn expected_tests(bvh: &Bvh<'_>, node: &Node) -> ExpectedTests {
    if node.is_leaf() {
        return ExpectedTests::of_leaf(bvh.mesh(), bvh.leaf_triangles(node)).1;
    }
    let [left, right] =
        [0, 1].map(|side| expected_tests(bvh, &bvh.nodes()[(node.first + side) as usize]));
    left.and(&right).with_node(&Bounds::new(&node.aabb()), 2, bvh.mesh())
}

/// The tests in a node and all below it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ExpectedTests {
    /// Half-areas of the triangles' boxes, summed.
    area: f64,
    triangles: u32,
    /// Summed over the nodes.
    tests: f32,
}

impl ExpectedTests {
    pub(super) const NONE: Self = Self { area: 0.0, triangles: 0, tests: 0.0 };

    /// A leaf, and the box of its triangles.
    #[inline(always)]
    pub(super) fn of_leaf(mesh: Mesh<'_>, triangles: &[u32]) -> (Aabb, Self) {
        let (mut all, mut area) = (Bounds::EMPTY, 0.0);
        for &triangle in triangles {
            let bounds = mesh.bounds(triangle);
            area += bounds.half_area();
            all = all.union(&bounds);
        }
        let count = triangles.len() as u32;
        let expected_tests = Self { area, triangles: count, tests: 0.0 };
        (all.into(), expected_tests.with_node(&all, count, mesh))
    }

    pub(super) fn and(&self, other: &Self) -> Self {
        Self {
            area: self.area + other.area,
            triangles: self.triangles + other.triangles,
            tests: self.tests + other.tests,
        }
    }

    /// Adds the node above, where a triangle that meets its box is tested so many times.
    #[inline(always)]
    pub(super) fn with_node(self, bounds: &Bounds, tests: u32, mesh: Mesh<'_>) -> Self {
        let (own, all) = (self.triangles as f32, mesh.triangles().len() as f32);
        let expected =
            if self.area > 0.0 { (bounds.half_area() / self.area) as f32 * own } else { all };
        // Nothing is NaN: `f32::max` and `min`, which provide for it, take longer.
        let meeting = if expected > own { expected } else { own };
        let meeting = if meeting < all { meeting } else { all };
        Self { tests: self.tests + meeting * tests as f32, ..self }
    }

    pub(super) fn quality(&self, mesh: Mesh<'_>) -> f32 {
        self.tests / mesh.triangles().len() as f32
    }
}
