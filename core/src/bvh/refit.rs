//! Boxes for a deformed mesh, and how good a tree still is.
//!
//! The surface area heuristic: a random line meets a convex box with a probability proportional to
//! its area. It is usual to divide by the area of the root; dividing by the areas of the triangles'
//! own boxes instead makes the figure a cost per useful hit, which neither a mesh that spreads out
//! or folds up nor one that moves as a whole changes much.

use crate::bvh::Node;
use crate::index::{at, range, split};
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
/// use pfront_core::bvh::{REBUILD_RATIO, BuildOptions, BvhStorage, morton, quality, refit};
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
    Fit { mesh, order, join: None }.whole(nodes)
}

/// Runs two tasks, side by side if it can, each once, and returns when both are done.
pub type Join<'j> = dyn Fn(&mut (dyn FnMut() + Send), &mut (dyn FnMut() + Send)) + Sync + 'j;

/// [`refit`] in parts that `join` may run side by side, as `rayon::join` does. The boxes are the same;
/// the quality, a sum, may be rounded in another way.
///
/// # Panics
/// If `nodes` and `order` are not of a tree that [`sah()`](super::sah()) or
/// [`morton()`](super::morton()) has built for the same triangles: in those, all that lies below a node is
/// one run.
///
/// # Complexity
/// O(triangles), in parts of at most a few thousand.
///
/// # Examples
/// ```
/// # use pfront_core::{Mesh, Node, build::{refit, refit_with}};
/// # fn f(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32]) {
/// let one_after_the_other = refit_with(mesh, nodes, order, &|a, b| {
///     a();
///     b();
/// });
/// # }
/// ```
pub fn refit_with(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32], join: &Join<'_>) -> f32 {
    Fit { mesh, order, join: Some(join) }.whole(nodes)
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
    let Some(root) = bvh.root() else { return 0.0 };
    let mut areas = Areas::default();
    for (_, node) in bvh.nodes().iter().enumerate().rev().filter(|&(index, _)| index != 1) {
        if node.is_leaf() {
            areas.add_leaf(bvh.mesh(), bvh.leaf_triangles(node));
        } else {
            areas.add_inner(node.aabb());
        }
    }
    areas.quality(&root.aabb())
}

/// A run of fewer nodes is not worth dividing: it takes some 50 µs.
pub(super) const PART: usize = 4096;

struct Fit<'f> {
    mesh: Mesh<'f>,
    order: &'f [u32],
    join: Option<&'f Join<'f>>,
}

impl Fit<'_> {
    fn whole(&self, nodes: &mut [Node]) -> f32 {
        // Slot 1 is no node.
        let (upper, below) = nodes.split_at_mut(nodes.len().min(2));
        upper.first_mut().map_or(0.0, |root| self.tree(root, below, 2).quality(&root.aabb()))
    }

    /// Fits a node after all that lie `below` it, the first of which has the index `base`.
    fn tree(&self, node: &mut Node, below: &mut [Node], base: usize) -> Areas {
        let halves = self.halves(below, base);
        let mut areas = halves.unwrap_or_else(|| self.run(below, base));
        node.set_aabb(&self.fitted(node, below, base, &mut areas));
        areas
    }

    /// Fits what lies below a node as two trees, if there is enough of it.
    fn halves(&self, below: &mut [Node], base: usize) -> Option<Areas> {
        let join = self.join.filter(|_| below.len() > PART)?;
        let (left, rest) = below.split_first_mut()?;
        let (right, rest) = rest.split_first_mut()?;
        // What lies below the left one comes first; below a leaf lies nothing.
        let base = base + 2;
        let middle = if right.is_leaf() { rest.len() } else { right.first as usize - base };
        let (below_left, below_right) = split(rest, middle);
        let (mut of_left, mut of_right) = (Areas::default(), Areas::default());
        join(&mut || of_left = self.tree(left, below_left, base), &mut || {
            of_right = self.tree(right, below_right, base + middle);
        });
        Some(of_left.and(&of_right))
    }

    /// Fits nodes from the last to the first, the children of each being among them.
    fn run(&self, nodes: &mut [Node], base: usize) -> Areas {
        let mut areas = Areas::default();
        for index in (0..nodes.len()).rev() {
            let aabb = self.fitted(at(nodes, index as u32), nodes, base, &mut areas);
            if let Some(node) = nodes.get_mut(index) {
                node.set_aabb(&aabb);
            }
        }
        areas
    }

    /// The box of a node whose children are fitted.
    #[inline(always)]
    fn fitted(&self, node: &Node, nodes: &[Node], base: usize, areas: &mut Areas) -> Aabb {
        if node.is_leaf() {
            areas.add_leaf(self.mesh, range(self.order, node.first, node.count))
        } else {
            let left = node.first - base as u32;
            let [left, right] = [left, left + 1].map(|child| at(nodes, child).aabb());
            areas.add_inner(left.union(&right))
        }
    }
}

/// Half-areas summed over the nodes of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Areas {
    /// Times the tests that meeting the box entails.
    tests: f64,
    triangles: f64,
}

impl Areas {
    /// Returns the box of the triangles.
    // Unless inlined, the box comes back through memory, and a refit takes a sixth longer.
    #[inline(always)]
    pub(super) fn add_leaf(&mut self, mesh: Mesh<'_>, triangles: &[u32]) -> Aabb {
        let (mut aabb, mut area) = (Aabb::EMPTY, 0.0);
        for &triangle in triangles {
            let of_one = Aabb::of(&mesh.triangle(triangle));
            area += half_area(&of_one);
            aabb = aabb.union(&of_one);
        }
        self.triangles += area;
        self.tests += triangles.len() as f64 * half_area(&aabb);
        aabb
    }

    #[inline(always)]
    pub(super) fn add_inner(&mut self, aabb: Aabb) -> Aabb {
        self.tests += 2.0 * half_area(&aabb);
        aabb
    }

    pub(super) fn and(&self, other: &Self) -> Self {
        Self { tests: self.tests + other.tests, triangles: self.triangles + other.triangles }
    }

    pub(super) fn quality(&self, root: &Aabb) -> f32 {
        let unit = if self.triangles > 0.0 { self.triangles } else { half_area(root) };
        if unit > 0.0 { (self.tests / unit).min(f32::MAX.into()) as f32 } else { 0.0 }
    }
}

/// In f64, whose range holds the areas of all f32 boxes. An edge longer than [`f32::MAX`] counts as
/// that long.
fn half_area(aabb: &Aabb) -> f64 {
    let edge = |min: f32, max: f32| f64::from((max - min).min(f32::MAX));
    let ([a, b, c], [d, e, f]) = (aabb.min, aabb.max);
    let (x, y, z) = (edge(a, d), edge(b, e), edge(c, f));
    x * (y + z) + y * z
}
