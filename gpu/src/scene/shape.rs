//! Shapes: the mesh and BVH of a body.

use crate::model::{below, reference};
use pfront_core::{Aabb, Bvh, Mesh, Node};

/// A first front pairs at most so many nodes: one level on, that is the larger starting front of the
/// paper's GPU algorithm.
pub(super) const MOST_PAIRS: usize = 4096;

/// A mesh with its BVH, kept by the host: any number of bodies share it, each with an instance on the
/// device.
///
/// Takes 12 bytes a vertex, 16 a triangle and 32 a node.
#[derive(Clone, Debug)]
pub struct Shape {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    depth: u32,
    /// The nodes of each of the first levels, leaves above it included, as a front holds them.
    levels: Vec<Vec<u32>>,
}

impl Shape {
    /// Copies a mesh with its BVH.
    ///
    /// # Complexity
    /// O(triangles).
    #[must_use]
    pub fn new(bvh: Bvh<'_>) -> Self {
        Self {
            positions: bvh.mesh().positions().to_vec(),
            triangles: bvh.mesh().triangles().to_vec(),
            nodes: bvh.nodes().to_vec(),
            order: bvh.order().to_vec(),
            depth: bvh.depth() as u32,
            levels: levels(bvh.nodes()),
        }
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh::new_unchecked(&self.positions, &self.triangles)
    }

    /// Its BVH, of which the box of the root alone is that of the mesh once vertices have moved: the
    /// device refits the others.
    pub(super) fn bvh(&self) -> Bvh<'_> {
        Bvh::new_unchecked(self.mesh(), &self.nodes, &self.order)
    }

    /// Moves the vertices, as many as there are, within `bounds`.
    pub(super) fn set_positions(&mut self, positions: &[[f32; 3]], bounds: &Aabb) {
        self.positions.copy_from_slice(positions);
        if let Some(root) = self.nodes.first_mut() {
            (root.min, root.max) = (bounds.min, bounds.max);
        }
    }

    /// The nodes of a level, or of the last one there is, as a front holds them; and how many levels
    /// lie below, of which a leaf on its own counts as one.
    pub(super) fn level(&self, level: usize) -> (&[u32], u32) {
        let level = level.min(self.levels.len().saturating_sub(1));
        let nodes = self.levels.get(level).map_or(&[][..], Vec::as_slice);
        (nodes, (self.depth - level as u32).max(1))
    }
}

/// From the root on, as long as a level paired with its own does not exceed [`MOST_PAIRS`].
fn levels(nodes: &[Node]) -> Vec<Vec<u32>> {
    let mut level: Vec<u32> = (0..nodes.len().min(1) as u32).collect();
    let mut levels = Vec::new();
    while !level.is_empty() && level.len().pow(2) <= MOST_PAIRS {
        levels.push(level.iter().map(|&index| reference(nodes, index)).collect());
        let next = below(nodes, &level);
        if next.len() == level.len() {
            break;
        }
        level = next;
    }
    levels
}
