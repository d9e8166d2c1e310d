//! The bounding volume test tree (BVTT), its one traversal, and the queries that it answers.
//!
//! A BVTT node is a pair of BVH nodes whose boxes overlap; its children are the overlapping pairs of
//! their children (Zhang & Kim 2014, section 2.1). The tree is never stored. There are two of them: of
//! two meshes ([`PairBvtt`]) and of one mesh with itself ([`SelfBvtt`]).
//!
//! # How a leaf pair is decided
//! 1. `traversal` pops node pairs from a [`Cursor`] and tests the boxes of their descendants, up to a leaf pair.
//! 2. `block` loads the triangles of both leaves into vector lanes, at most eight a side, and poses them.
//! 3. `cull` compares their boxes, and rejects pairs that share a vertex whose one-ring is certified. The others are tested by
//!    `planes`, eight at a time: whether a supporting plane separates them and, if none does, whether they intersect.
//! 4. [`Cursor`] goes through the hits, and the pairs that f32 left open, in the order of their bits, as far as the
//!    budget reaches, and notes where to resume.
//! 5. [`crate::triangle`] decides what is open by signs of orientation determinants from `exact`. Triangles of one
//!    mesh that share vertices follow a rule of their own there.
//!
//! # Within a distance
//! A query for pairs at most a distance apart passes through the same steps, with the boxes of its second side grown by the distance.
//! In place of `cull`, `near` rejects triangles that a plane holds farther apart, and gathers the other pairs of a leaf pair until
//! all lanes have one; `nearest` finds near points of each and proves what they show. Open pairs go to
//! [`crate::triangle::within`], which tests whether they intersect and, if not, their features in integers.
//!
//! # While both move
//! The traversal of motions is in `motion`. Its leaf pairs are decided by `moving` in place of `cull`, at both ends of the motion,
//! and what that leaves open is gathered by `moving_lanes` until all lanes have a pair.
//!
//! `wide_node` has the boxes of a step of the traversal, `posed_bvh` one side of a query, `trees` how queries are made, and
//! `query` the verbs of the public interface.
//!
//! # In f64
//! Lanes and boxes see only shadows of positions in f64 (see [`Mesh::from_f64`](crate::Mesh::from_f64)), in a frame whose origin
//! is that of the first shadow as it is posed: large translations cancel in f64, before they are rounded to f32. Boxes are padded
//! by how far a shadow may be from what it stands for, and lanes certify signs by a bound that allows for it. All other pairs are
//! decided by the positions themselves, posed in f64.
//!
//! # Where we depart from the paper
//! The traversal descends two levels at a time, all pairs of up to four nodes and four others, since a
//! single box test is too small for a vector unit. Box tests, and so costs, are counted on these pairs.

mod any;
#[cfg(feature = "within")]
mod apart;
mod block;
mod cull;
mod cursor;
#[cfg(feature = "within")]
mod distance;
mod meet;
#[cfg(feature = "motion")]
mod motion;
#[cfg(feature = "motion")]
mod moving;
#[cfg(feature = "motion")]
mod moving_lanes;
mod near;
mod nearest;
mod planes;
mod posed_bvh;
mod query;
#[cfg(feature = "relation")]
mod reach;
#[cfg(test)]
mod tests;
mod traversal;
mod trees;
mod wide_node;

pub use any::AnyBvtt;
pub use cursor::{Cursor, Work};
#[cfg(feature = "within")]
pub use distance::{Gap, Search};
#[cfg(feature = "motion")]
pub(crate) use moving::MovingBlocks;
#[cfg(feature = "motion")]
pub(crate) use moving_lanes::MovingGroup;
pub use posed_bvh::PosedBvh;
pub(crate) use query::Estimated;
pub use query::Query;
#[cfg(feature = "motion")]
pub(crate) use traversal::BEFORE;
#[cfg(feature = "f64")]
pub use trees::Shadows;
pub use trees::{Bvtt, PairBvtt, SelfBvtt};

/// A BVTT node: a node of the first BVH and one of the second.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct NodePair {
    /// Index of the node of the first BVH.
    pub a: u32,
    /// Index of the node of the second BVH; of the same BVH in self-collision.
    pub b: u32,
}

impl NodePair {
    /// The pair of roots.
    pub(crate) const ROOT: Self = Self { a: 0, b: 0 };
}

/// Two triangles that intersect: indices into the triangles of the first and the second mesh, or of one
/// mesh with `a < b`. Pairs are ordered by `a`, then by `b`.
#[repr(C)]
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    bytemuck::Pod,
    bytemuck::Zeroable,
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TrianglePair {
    /// Triangle of the first mesh.
    pub a: u32,
    /// Triangle of the second mesh.
    pub b: u32,
}
