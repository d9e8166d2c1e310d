//! From wide BVHs to compact ones.

use super::compact::{Cells, Compact, CompactNode, Grid};
use super::layout::Index;
use super::{Bvh, BvhError, Node};
use crate::{CapacityError, Mesh};
use bytemuck::{must_cast, must_cast_slice_mut};
use core::fmt;

/// How many [`CompactNode`]s a BVH of so many [`Node`]s takes: as many, or two for a tree that is one leaf.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{CompactNode, compact_bound, node_bound};
/// assert_eq!(compact_bound(node_bound(1000)) * size_of::<CompactNode>(), 32_000);
/// ```
#[must_use]
pub const fn compact_bound(nodes: usize) -> usize {
    if nodes == 1 { 2 } else { nodes }
}

/// Where [`compact()`] writes a BVH.
#[derive(Debug)]
pub struct CompactStorage<'a, I = u32> {
    /// At least [`compact_bound`] nodes.
    pub nodes: &'a mut [CompactNode],
    /// At least one entry per triangle.
    pub order: &'a mut [I],
}

/// The same BVH in the compact layout: the same nodes with boxes hardly larger. Queries find the same pairs.
///
/// `nodes` and `order` are those of a BVH of `mesh`, the nodes in use only. Leaves should be well filled: see [`full_leaves`](crate::bvh::build::BuildOptions::full_leaves).
///
/// # Errors
/// [`CompactError`] if there are more triangles than `I` can number, or if `storage` is too small.
///
/// # Complexity
/// O(n).
///
/// # Examples
/// ```
/// use pfront_core::{Bvh, Mesh, Node, Pose, bvh::{Compact, CompactNode, CompactStorage, compact}, query::*};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
/// let wide = Bvh::new_unchecked(mesh, &root, &[0]);
///
/// let (mut nodes, mut order) = ([CompactNode::ZERO; 2], [0; 1]);
/// let storage = CompactStorage { nodes: &mut nodes, order: &mut order };
/// let bvh: Bvh<'_, Compact<u16>> = compact(mesh, wide.nodes(), wide.order(), storage)?;
/// assert_eq!(PairQuery::new(bvh, wide, Pose::IDENTITY)?.count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compact<'a, I: Index>(
    mesh: Mesh<'a>,
    nodes: &[Node],
    order: &[u32],
    storage: CompactStorage<'a, I>,
) -> Result<Bvh<'a, Compact<I>>, CompactError> {
    let (needed, triangles) = (compact_bound(nodes.len()), order.len());
    fits::<I>(triangles)?;
    let CompactStorage { nodes: slots, order: entries } = storage;
    CapacityError::check("nodes", needed, slots.len()).map_err(CompactError::Capacity)?;
    CapacityError::check("order", triangles, entries.len()).map_err(CompactError::Capacity)?;
    for (entry, &triangle) in entries.iter_mut().zip(order) {
        *entry = I::new(triangle);
    }
    if let Some(root) = nodes.first() {
        let cells = Cells::of(&root.aabb());
        for (slot, node) in slots.iter_mut().zip(nodes) {
            *slot = CompactNode::new(node, &cells);
        }
        if let Some(slot) = slots.get_mut(1) {
            *slot = cells.header();
        }
    }
    let (slots, entries): (&'a [CompactNode], &'a [I]) = (slots, entries);
    let slots = slots.get(..needed).unwrap_or_default();
    Ok(Bvh::new_compact_unchecked(mesh, slots, entries.get(..triangles).unwrap_or_default()))
}

/// [`compact()`] in the memory of the wide BVH itself, from front to back: what is compact fills half of `nodes`
/// and the beginning of `order`, and no other memory is needed.
///
/// `nodes` and `order` are those of a BVH of `mesh`, the nodes in use only.
///
/// # Errors
/// [`CompactError::Triangles`]; nothing has changed then.
///
/// # Complexity
/// O(n).
///
/// # Examples
/// ```
/// use pfront_core::{Bvh, Mesh, Node, bvh::{Compact, CompactNode, compact_in_place}};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let mut nodes = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
/// let mut order = [0];
/// let bvh: Bvh<'_, Compact<u16>> = compact_in_place(mesh, &mut nodes, &mut order)?;
/// assert_eq!(bvh.order(), [0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compact_in_place<'a, I: Index>(
    mesh: Mesh<'a>,
    nodes: &'a mut [Node],
    order: &'a mut [u32],
) -> Result<Bvh<'a, Compact<I>>, CompactError> {
    let (count, triangles) = (nodes.len(), order.len());
    fits::<I>(triangles)?;
    let root = nodes.first().map(Node::aabb);
    let nodes: &'a mut [CompactNode] = must_cast_slice_mut(nodes);
    if let Some(root) = root {
        let cells = Cells::of(&root);
        // A wide node lies where two compact ones do, the first of which is not before its own place.
        for index in 0..count {
            let halves = [0, 1].map(|half| nodes.get(2 * index + half).copied());
            if let ([Some(a), Some(b)], Some(slot)) = (halves, nodes.get_mut(index)) {
                *slot = CompactNode::new(&must_cast([a, b]), &cells);
            }
        }
        if let Some(slot) = nodes.get_mut(1) {
            *slot = cells.header();
        }
    }
    let bytes: &'a mut [u8] = must_cast_slice_mut(order);
    for index in 0..triangles {
        let entry = bytes.get(4 * index..).and_then(<[u8]>::first_chunk);
        let entry = I::new(u32::from_ne_bytes(entry.copied().unwrap_or_default()));
        if let Some(to) =
            bytes.get_mut(size_of::<I>() * index..).and_then(|to| to.get_mut(..size_of::<I>()))
        {
            to.copy_from_slice(bytemuck::bytes_of(&entry));
        }
    }
    let (nodes, bytes): (&'a [CompactNode], &'a [u8]) = (nodes, bytes);
    let order = bytes.get(..size_of::<I>() * triangles).unwrap_or_default();
    // Aligned and divisible as it is, no cast fails.
    let order = bytemuck::try_cast_slice(order).unwrap_or_default();
    Ok(Bvh::new_compact_unchecked(
        mesh,
        nodes.get(..compact_bound(count)).unwrap_or_default(),
        order,
    ))
}

fn fits<I: Index>(triangles: usize) -> Result<(), CompactError> {
    if triangles > I::MOST {
        return Err(CompactError::Triangles { triangles, most: I::MOST });
    }
    Ok(())
}

impl<'a, I: Index> Bvh<'a, Compact<I>> {
    /// Adopts arrays from elsewhere, as [`Bvh::new`] does.
    ///
    /// # Errors
    /// [`BvhError`] names the first node or order entry at fault.
    ///
    /// # Complexity
    /// As [`Bvh::new`].
    pub fn new_compact(
        mesh: Mesh<'a>,
        nodes: &'a [CompactNode],
        order: &'a [I],
        scratch: &mut [u32],
    ) -> Result<Self, BvhError> {
        if !nodes.is_empty() && nodes.get(1).and_then(Cells::read).is_none() {
            return Err(BvhError::Grid);
        }
        let bvh = Self::new_compact_unchecked(mesh, nodes, order);
        bvh.check(scratch)?;
        Ok(bvh)
    }

    /// Makes a BVH of arrays that [`compact()`] or [`compact_in_place`] has written, or that [`Bvh::new_compact`]
    /// has accepted, without checking them.
    ///
    /// # Panics and wrong answers
    /// As [`Bvh::new_unchecked`].
    #[must_use]
    pub fn new_compact_unchecked(mesh: Mesh<'a>, nodes: &'a [CompactNode], order: &'a [I]) -> Self {
        let grid = nodes.get(1).and_then(Cells::read).map_or(Grid::NONE, Cells::grid);
        Self { mesh, nodes, order, grid }
    }
}

/// Why a BVH cannot be made compact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CompactError {
    /// More triangles than the order can number: take a wider [`Index`].
    Triangles {
        /// How many there are.
        triangles: usize,
        /// How many there may be.
        most: usize,
    },
    /// A buffer is too small.
    Capacity(CapacityError),
}

impl fmt::Display for CompactError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Triangles { triangles, most } => write!(
                f,
                "{triangles} triangles are more than the {most} that the order can number: take a wider index"
            ),
            Self::Capacity(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for CompactError {}
