//! The top-down build by the surface area heuristic.
//!
//! Binned SAH after Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007),
//! on items that carry their box, so that every pass runs over memory in sequence. What differs:
//! depth is bounded, and no finite input can mislead it. A split that could exceed [`MAX_DEPTH`], or
//! that the heuristic cannot find (equal centres, areas that are 0), becomes a median split, which
//! always halves.

use super::bins::{AreaScale, best_split};
use super::divide::{split_across, split_at};
use super::item::{Run, SahItem, load};
use super::parts::{Parts, Room, nodes_of_tree};
use super::{BuildOptions, BvhStorage, Leaves};
use crate::bvh::Join;
use crate::bvh::{MAX_DEPTH, Node};
use crate::{Bvh, CapacityError, Mesh};

/// How many items of scratch [`sah()`] needs for so many triangles.
#[must_use]
pub const fn sah_scratch_bound(triangles: usize) -> usize {
    triangles
}

/// Builds a BVH by binned SAH.
///
/// # Errors
/// [`CapacityError`] if `storage` is below [`node_bound`](crate::bvh::node_bound) nodes and one
/// order entry per triangle, or `scratch` below [`sah_scratch_bound`].
///
/// # Complexity
/// O(n log n) for usual meshes, O(n · [`MAX_DEPTH`]) for any.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, SahItem, sah};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = sah(mesh, &BuildOptions::default(), storage, &mut [SahItem::default()])?;
/// assert_eq!(bvh.aabb().map(|root| root.max), Some([1.0, 1.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sah<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [SahItem],
) -> Result<Bvh<'a>, CapacityError> {
    build(mesh, options, storage, scratch, Parts::new(None))
}

/// [`sah()`] in parts that `join` may run side by side, as `rayon::join` does. The tree is the same to
/// the bit.
///
/// # Errors
/// As [`sah()`].
///
/// # Complexity
/// As [`sah()`]. Every pass over the triangles of a node is in parts of at most 16,384, down to nodes
/// that have so few.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, SahItem, sah_with};
/// # use pfront_core::{Mesh, Node};
/// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// # let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// # let mut scratch = [SahItem::default()];
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = sah_with(mesh, &BuildOptions::default(), storage, &mut scratch, &|a, b| {
///     a();
///     b();
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sah_with<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [SahItem],
    join: &Join<'_>,
) -> Result<Bvh<'a>, CapacityError> {
    build(mesh, options, storage, scratch, Parts::new(Some(join)))
}

fn build<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [SahItem],
    parts: Parts<'_>,
) -> Result<Bvh<'a>, CapacityError> {
    let count = mesh.triangles().len();
    storage.check(count)?;
    CapacityError::check("scratch", sah_scratch_bound(count), scratch.len())?;
    let items = &mut scratch[..count];
    if items.is_empty() {
        return Ok(storage.into_bvh(mesh, 0));
    }
    let run = load(mesh, 0, items, parts);
    let scale = AreaScale::new(&run.bounds);
    let builder = Builder { leaves: options.leaves(), scale, parts };
    let growth = Growth { items, run, depth: 0, order: &mut storage.order[..count], first: 0 };
    let below = Room::of_root(storage.nodes).map_or(0, |room| builder.tree(growth, room));
    Ok(storage.into_bvh(mesh, nodes_of_tree(below)))
}

/// A node to be built.
struct Growth<'t> {
    items: &'t mut [SahItem],
    run: Run,
    depth: usize,
    /// The run's part of the order, which begins at `first`.
    order: &'t mut [u32],
    first: usize,
}

struct Builder<'b> {
    leaves: Leaves,
    scale: AreaScale,
    parts: Parts<'b>,
}

impl Builder<'_> {
    /// Returns how many nodes lie below.
    fn tree(&self, growth: Growth<'_>, room: Room<'_>) -> usize {
        let Growth { items, run, depth, order, first } = growth;
        let (min, max) = (run.bounds.min.to_array(), run.bounds.max.to_array());
        if self.leaves.is_one(run.count) {
            for (entry, item) in order.iter_mut().zip(items) {
                *entry = item.triangle();
            }
            *room.node = Node { min, first: first as u32, max, count: run.count as u32 };
            return 0;
        }
        *room.node = Node { min, first: room.base as u32, max, count: 0 };
        let [on_left, on_right] = self.split(items, &run, depth);
        let (depth, middle) = (depth + 1, on_left.count);
        let (left, right) = items.split_at_mut(middle);
        let (left_order, right_order) = order.split_at_mut(middle);
        self.parts.siblings(
            [middle, on_right.count],
            room.below,
            room.base,
            |room| {
                let (items, order) = (&mut *left, &mut *left_order);
                self.tree(Growth { items, run: on_left, depth, order, first }, room)
            },
            |room| {
                let (items, order, first) = (&mut *right, &mut *right_order, first + middle);
                self.tree(Growth { items, run: on_right, depth, order, first }, room)
            },
        )
    }

    /// Reorders a run into two. Apart, so that the bins are not on the stack of every level below.
    #[inline(never)]
    fn split(&self, items: &mut [SahItem], run: &Run, depth: usize) -> [Run; 2] {
        // Halving the run down to single triangles takes `levels` more levels. SAH may not use a
        // level up unless they still fit below it; a median split needs them to fit below this
        // node, which holds at the root (31 ≤ MAX_DEPTH) and is handed down by either split.
        let levels = usize::BITS - (run.count - 1).leading_zeros();
        if (levels as usize) < MAX_DEPTH - depth
            && let Some(split) = best_split(items, &run.centres, self.scale, self.parts)
        {
            let runs = split.divide(items, self.parts);
            let middle = self.leaves.align(runs[0].count, run.count);
            if middle == runs[0].count { runs } else { split_across(split.axis, items, middle) }
        } else if (levels as usize) < MAX_DEPTH - depth {
            split_at(items, &run.centres, self.leaves.align(run.count / 2, run.count))
        } else {
            split_at(items, &run.centres, run.count / 2)
        }
    }
}
