//! Building a BVH into the caller's slices, and keeping it fit while the mesh deforms.
//!
//! [`sah()`] gives the tree that queries walk fastest; [`morton()`] is built four times faster, for
//! those who rebuild every frame; [`refit()`] keeps the tree and moves its boxes. [`sah_with`],
//! [`morton_with`] and [`refit_with`] do the same on as many threads as the caller has. Where few vertices
//! have moved, [`refit_moved()`] looks only at what is near them.
//!
//! Nothing is allocated. A build recurses, at most 64 levels. By SAH it takes up to 72 KiB of stack, or 96 in parts
//! that `join` runs, and without the feature `std` 64; in Morton order 64, and without `std` 16, or on a Cortex-M4
//! 8 KiB or 0.3 KiB a level. `core/tests/stack` measures it.

mod bins;
mod divide;
mod item;
mod morton;
mod parts;
mod radix;
mod sah;
#[cfg(test)]
mod tests;

pub use item::SahItem;
pub use morton::{morton, morton_scratch_bound, morton_with};
pub use sah::{sah, sah_scratch_bound, sah_with};

use crate::bvh::{MAX_LEAF_SIZE, Node, node_bound};
use crate::{Bvh, CapacityError, Mesh};
use core::num::NonZeroUsize;

/// How a BVH is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The most triangles one leaf may hold. A value outside 1 ..= [`MAX_LEAF_SIZE`] counts as the
    /// nearest one inside.
    pub leaf_size: u32,
    /// Whether most leaves hold that many: a seventh to a fifth fewer nodes in leaves of four or eight. By SAH,
    /// walks of two meshes then take 3 to 10 % longer and of one with itself 5 to 7 % less; in Morton order, 6 to
    /// 17 % longer. Builds on a GPU take no notice.
    pub full_leaves: bool,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { leaf_size: 8, full_leaves: false }
    }
}

impl BuildOptions {
    /// How the triangles of a node are divided.
    fn leaves(self) -> Leaves {
        let most = NonZeroUsize::new(self.leaf_size.min(MAX_LEAF_SIZE) as usize)
            .unwrap_or(NonZeroUsize::MIN);
        Leaves { most, aligned: if self.full_leaves { ALIGNED * most.get() } else { 0 } }
    }
}

/// With [`BuildOptions::full_leaves`], nodes of so many leaves or fewer are divided between leaves.
///
/// What is above them is divided where it is best, so that about one leaf in six is not full. With 16, compact
/// nodes of the bunny in leaves of four take 8.2 bytes a triangle instead of 8.4, and walks 0.6 % more box tests.
const ALIGNED: usize = 8;

/// How many triangles leaves hold.
#[derive(Clone, Copy)]
struct Leaves {
    /// At most.
    most: NonZeroUsize,
    /// Up to so many triangles are divided between full leaves.
    aligned: usize,
}

impl Leaves {
    /// How many of them hold so many triangles, if all but one are full.
    fn of(self, triangles: usize) -> usize {
        (triangles + self.most.get() - 1) / self.most
    }

    /// Whether so many triangles are a leaf.
    fn is_one(self, triangles: usize) -> bool {
        triangles <= self.most.get()
    }

    /// How many of `count` triangles, more than one leaf holds, go to the left where `middle` would be best:
    /// the nearest number with which all leaves but one can be full, if either side is small enough.
    fn align(self, middle: usize, count: usize) -> usize {
        if count > self.aligned && middle.min(count - middle) >= self.aligned / 2 {
            return middle;
        }
        let size = self.most.get();
        // Either side may have the leaf that is not full.
        let nearest = |rest: usize| {
            let (least, most) = (usize::from(rest == 0), (count - 1 - rest) / self.most);
            let full = (middle + size / 2).saturating_sub(rest) / self.most;
            full.min(most).max(least) * size + rest
        };
        let (on_right, on_left) = (nearest(0), nearest(count % self.most));
        if on_left.abs_diff(middle) < on_right.abs_diff(middle) { on_left } else { on_right }
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
        Bvh::new_unchecked(mesh, all_nodes.get(..nodes).unwrap_or_default(), order)
    }
}
