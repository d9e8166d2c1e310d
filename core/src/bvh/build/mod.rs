//! Building a BVH into the caller's slices.
//!
//! [`sah()`] gives the tree that queries traverse fastest; [`morton()`] is built several times faster, for meshes that
//! are rebuilt every frame. Both divide a run of triangles into two until it fits in a leaf: `tree` numbers the nodes
//! and bounds their depth, the builds say where to divide.
//!
//! Nothing is allocated. A build recurses, at most [`MAX_DEPTH`](super::MAX_DEPTH) levels; `core/tests/stack` measures
//! how much stack it takes, and `docs/embedding.md` has the bounds.

mod bins;
mod divide;
mod item;
mod morton;
mod radix;
mod sah;
mod steps;
#[cfg(test)]
mod tests;
mod tree;

pub use morton::morton;
pub use sah::sah;
pub use steps::SahSteps;

use crate::Node;
use crate::bvh::MAX_LEAF_SIZE;
use crate::parallel::Join;
use crate::{Bvh, CapacityError, Mesh};
use core::fmt;

/// How a BVH is built.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct BuildOptions<'j> {
    /// The most triangles one leaf may hold. A value outside 1 ..= [`MAX_LEAF_SIZE`] counts as the
    /// nearest one inside.
    pub leaf_size: u32,
    /// Runs parts of the build side by side. The tree is the same to the bit without. Not stored by serde.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub join: Option<&'j Join<'j>>,
}

impl Default for BuildOptions<'_> {
    fn default() -> Self {
        Self { leaf_size: MAX_LEAF_SIZE, join: None }
    }
}

impl fmt::Debug for BuildOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { leaf_size, join } = self;
        let mut out = f.debug_struct("BuildOptions");
        out.field("leaf_size", leaf_size).field("join", &join.is_some()).finish()
    }
}

/// The memory that a build writes the BVH to.
#[derive(Debug)]
pub struct BvhStorage<'a> {
    /// Room for the nodes of the tree: [`node_bound`](super::node_bound) always are enough, and needed to build parts
    /// side by side. Most trees with leaves of 8 triangles take a fifth of it.
    pub nodes: &'a mut [Node],
    /// At least one entry per triangle.
    pub order: &'a mut [u32],
}

impl<'a> BvhStorage<'a> {
    /// The finished tree over the first `used` nodes, or an error that says how many it needs.
    fn into_bvh(self, mesh: Mesh<'a>, used: usize) -> Result<Bvh<'a>, CapacityError> {
        CapacityError::check("nodes", used, self.nodes.len())?;
        let (nodes, order): (&'a [Node], &'a [u32]) = (self.nodes, self.order);
        let order = order.get(..mesh.triangles().len()).unwrap_or_default();
        Ok(Bvh::new_unchecked(mesh, nodes.get(..used).unwrap_or_default(), order))
    }
}
