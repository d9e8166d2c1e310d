//! BVHs in the compact layout.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::core::bvh::{
    Compact, CompactNode, CompactStorage, Index, check_scratch_bound, compact, compact_bound,
};
use pfront::{Bvh, Mesh};

/// The arrays of one.
pub(crate) struct Small<I> {
    nodes: Vec<CompactNode>,
    order: Vec<I>,
}

impl<I: Index> Small<I> {
    pub(crate) fn of(bvh: Bvh<'_>) -> Self {
        let mut nodes = vec![CompactNode::ZERO; compact_bound(bvh.nodes().len())];
        let mut order = vec![I::new(0); bvh.order().len()];
        let storage = CompactStorage { nodes: &mut nodes, order: &mut order };
        compact(bvh.mesh(), bvh.nodes(), bvh.order(), storage).unwrap();
        Self { nodes, order }
    }

    /// The BVH, as one from elsewhere: its boxes contain all that is below them.
    pub(crate) fn bvh<'a>(&'a self, mesh: Mesh<'a>) -> Bvh<'a, Compact<I>> {
        let mut scratch = vec![0; check_scratch_bound(self.order.len()).max(1)];
        Bvh::new_compact(mesh, &self.nodes, &self.order, &mut scratch).unwrap()
    }
}
