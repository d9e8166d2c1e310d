//! BVHs in the compact layout.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::{Bvh, Mesh};
use pfront_core::bvh::{CompactNode, compact, node_bound};

/// The arrays of a compact BVH.
pub(crate) struct Compact {
    nodes: Vec<CompactNode>,
    order: Vec<u32>,
}

impl Compact {
    pub(crate) fn of(bvh: Bvh<'_>) -> Self {
        let mut nodes = vec![CompactNode::default(); node_bound(bvh.order().len())];
        let used = compact(bvh.mesh(), bvh.nodes(), bvh.order(), &mut nodes).unwrap().nodes().len();
        nodes.truncate(used);
        Self { nodes, order: bvh.order().to_vec() }
    }

    /// The BVH, checked as one from elsewhere: its boxes contain all that is below them.
    pub(crate) fn bvh<'a>(&'a self, mesh: Mesh<'a>) -> Bvh<'a, CompactNode> {
        let mut scratch = vec![0; self.order.len().div_ceil(32).max(1)];
        Bvh::new(mesh, &self.nodes, &self.order, &mut scratch).unwrap()
    }
}
