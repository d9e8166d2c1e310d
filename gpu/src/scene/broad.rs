//! The broad phase: which boxes overlap, by a BVH over them that is built anew for each frame.
//!
//! A box is a triangle through two of its opposite corners, so that what the core has for triangles does
//! for boxes.

use crate::Error;
use pfront_core::bvh::node_bound;
use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
use pfront_core::bvtt::{Query, SelfQuery};
use pfront_core::{Aabb, Mesh, Node};
use std::ops::ControlFlow;

/// Buffers to use again.
#[derive(Clone, Debug, Default)]
pub(super) struct Broad {
    /// Smallest and largest corner of each box.
    corners: Vec<[f32; 3]>,
    diagonals: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    scratch: Vec<u64>,
    pairs: Vec<[u32; 2]>,
}

impl Broad {
    /// Finds the pairs of boxes that overlap, by their numbers, the lower first.
    ///
    /// # Complexity
    /// O(n + pairs) for n boxes of about the same size.
    pub(super) fn update(&mut self, boxes: impl Iterator<Item = Aabb>) -> Result<(), Error> {
        self.corners.clear();
        self.corners.extend(boxes.flat_map(|aabb| [aabb.min, aabb.max]));
        let n = self.corners.len() / 2;
        let diagonal = |i: u32| [2 * i, 2 * i + 1, 2 * i + 1];
        self.diagonals.truncate(n);
        self.diagonals.extend((self.diagonals.len() as u32..n as u32).map(diagonal));
        self.nodes.resize(node_bound(n), Node::EMPTY);
        self.order.resize(n, 0);
        self.scratch.resize(2 * n, 0);
        let mesh = Mesh::new(&self.corners, &self.diagonals)?;
        let storage = BvhStorage { nodes: &mut self.nodes, order: &mut self.order };
        let bvh = morton(
            mesh,
            &BuildOptions { leaf_size: 2, ..BuildOptions::default() },
            storage,
            &mut self.scratch,
        )?;
        let query = SelfQuery::new(bvh).boxes_only();
        self.pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            self.pairs.push([pair.a, pair.b]);
            ControlFlow::Continue(())
        });
        Ok(())
    }

    pub(super) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }
}
