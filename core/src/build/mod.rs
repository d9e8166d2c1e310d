//! Building a BVH into the caller's slices, and keeping it fit while the mesh deforms.
//!
//! [`sah()`] gives the tree that queries walk fastest; [`morton()`] is built four times faster, for
//! those who rebuild every frame; [`refit()`] keeps the tree and moves its boxes. [`sah_with`],
//! [`morton_with`] and [`refit_with`] do the same on as many threads as the caller has. Where few vertices
//! have moved, [`refit_moved()`] looks only at what is near them.
//!
//! Nothing is allocated. A build recurses, at most 64 levels, and takes up to 64 KiB of stack;
//! [`morton()`] without the feature `std` 8 KiB, or 0.3 KiB a level, on a Cortex-M4.

mod bins;
mod divide;
mod item;
mod morton;
pub(crate) mod moved;
mod parts;
mod radix;
mod refit;
mod sah;
mod survey;
#[cfg(test)]
mod tests;

pub use item::SahItem;
pub use morton::{morton, morton_scratch_bound, morton_with};
pub use moved::{Moved, mark_moved, moved_bound};
pub use refit::{Join, REBUILD_RATIO, quality, refit, refit_with};
pub use sah::{sah, sah_scratch_bound, sah_with};
pub use survey::{Below, refit_moved, survey, survey_bound};

use crate::bvh::{MAX_LEAF_SIZE, Node, node_bound};
use crate::{Bvh, CapacityError, Mesh};

/// How a BVH is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The most triangles one leaf may hold. A value outside 1 ..= [`MAX_LEAF_SIZE`] counts as the
    /// nearest one inside.
    pub leaf_size: u32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { leaf_size: 8 }
    }
}

impl BuildOptions {
    fn max_leaf(self) -> usize {
        self.leaf_size.clamp(1, MAX_LEAF_SIZE) as usize
    }
}

/// Where a build writes the BVH.
#[derive(Debug)]
pub struct BvhStorage<'a> {
    /// At least [`node_bound`] nodes; for [`morton()`], as many as the tree has.
    pub nodes: &'a mut [Node],
    /// At least one entry per triangle.
    pub order: &'a mut [u32],
}

impl<'a> BvhStorage<'a> {
    fn check(&self, triangles: usize) -> Result<(), CapacityError> {
        CapacityError::check("nodes", node_bound(triangles), self.nodes.len())?;
        CapacityError::check("order", triangles, self.order.len())
    }

    /// The finished tree over the first `nodes` nodes.
    fn into_bvh(self, mesh: Mesh<'a>, nodes: usize) -> Bvh<'a> {
        let (all_nodes, all_order): (&'a [Node], &'a [u32]) = (self.nodes, self.order);
        let order = all_order.get(..mesh.triangles().len()).unwrap_or_default();
        Bvh::trusted(mesh, all_nodes.get(..nodes).unwrap_or_default(), order)
    }
}
