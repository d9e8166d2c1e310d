//! The linear-time build along a Morton curve.
//!
//! Linear BVH after Lauterbach et al., "Fast BVH construction on GPUs" (2009): sort the triangles by
//! the interleaved bits of their centres, then split every run at its highest differing bit. What
//! differs: a key holds the triangle index below the code, so that keys are unique, equal codes
//! need no rule of their own, and sorted keys are the order.

use super::parts::{Parts, Room, nodes_of_tree, worth_dividing};
use super::radix::sort;
use super::{BuildOptions, BvhStorage, Leaves};
use crate::aabb::Bounds;
use crate::bvh::Join;
use crate::bvh::{MAX_DEPTH, Node, node_bound};
use crate::index::split;
use crate::{Aabb, Bvh, CapacityError, Mesh};
use glam::Vec3A;

/// Bits of a triangle index: [`MAX_TRIANGLES`](crate::mesh::MAX_TRIANGLES) fits.
const INDEX_BITS: u32 = 31;

/// Bits of a cell's number along one axis.
const AXIS_BITS: u32 = 11;
const LAST_CELL: u32 = (1 << AXIS_BITS) - 1;

const _: () = assert!(INDEX_BITS + 3 * AXIS_BITS == u64::BITS);

/// How many words of scratch [`morton()`] needs for so many triangles.
#[must_use]
pub const fn morton_scratch_bound(triangles: usize) -> usize {
    2 * triangles
}

/// Builds a BVH in linear time: several times faster than [`sah()`](super::sah()), and slower to
/// query.
///
/// # Errors
/// [`CapacityError`] if `storage` is below one order entry per triangle or the nodes that the tree has, or
/// `scratch` below [`morton_scratch_bound`].
///
/// [`node_bound`] nodes always are enough. Most trees take fewer, with leaves of 8 triangles about a fifth
/// of it; in less than the bound the build counts first, and the error tells how many it needs.
///
/// # Complexity
/// O(n).
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 2])?;
/// assert_eq!(bvh.order(), [0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn morton<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [u64],
) -> Result<Bvh<'a>, CapacityError> {
    build(mesh, options, storage, scratch, Parts::new(None))
}

/// [`morton()`] in parts that `join` may run side by side, as `rayon::join` does. The tree is the same
/// to the bit.
///
/// # Errors
/// As [`morton()`].
///
/// # Complexity
/// As [`morton()`], in parts of at most 16,384 triangles.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, morton_with};
/// # use pfront_core::{Mesh, Node};
/// # let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// # let (mut nodes, mut order, mut scratch) = ([Node::EMPTY; 2], [0; 1], [0; 2]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = morton_with(mesh, &BuildOptions::default(), storage, &mut scratch, &|a, b| {
///     a();
///     b();
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn morton_with<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [u64],
    join: &Join<'_>,
) -> Result<Bvh<'a>, CapacityError> {
    build(mesh, options, storage, scratch, Parts::new(Some(join)))
}

fn build<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [u64],
    parts: Parts<'_>,
) -> Result<Bvh<'a>, CapacityError> {
    let count = mesh.triangles().len();
    CapacityError::check("order", count, storage.order.len())?;
    CapacityError::check("scratch", morton_scratch_bound(count), scratch.len())?;
    if count == 0 {
        return Ok(storage.into_bvh(mesh, 0));
    }
    let (keys, spare) = split(split(scratch, 2 * count).0, count);
    let centres = write_centres(mesh, 0, keys, spare, parts);
    Curve::through(&centres).write_keys(0, keys, spare, parts);
    sort(keys, spare, INDEX_BITS..u64::BITS, parts);
    let mut hierarchy = Hierarchy { mesh, leaves: options.leaves(), parts };
    if storage.nodes.len() < node_bound(count) {
        let needed = nodes_of_tree(hierarchy.nodes_below(keys, 0));
        CapacityError::check("nodes", needed, storage.nodes.len())?;
        // Side by side, parts leave gaps.
        hierarchy.parts = Parts::new(None);
    }
    let (order, _) = split(storage.order, count);
    let room = Room::of_root(storage.nodes);
    let below = room.map_or(0, |room| hierarchy.tree(keys, order, 0, 0, room));
    Ok(storage.into_bvh(mesh, nodes_of_tree(below)))
}

#[inline(always)]
fn bounds(mesh: Mesh<'_>, triangle: u32) -> Bounds {
    let [a, b, c] = mesh.triangle(triangle).map(Vec3A::from_array);
    Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
}

/// Writes the centre of each triangle's box at half scale, so that neither it nor the difference of two
/// can overflow: x and y to `keys`, z to `spare`. Returns the box of them.
fn write_centres(
    mesh: Mesh<'_>,
    first: usize,
    keys: &mut [u64],
    spare: &mut [u64],
    parts: Parts<'_>,
) -> Bounds {
    let count = keys.len();
    if worth_dividing(count) {
        let (keys, right_keys) = split(keys, count / 2);
        let (spare, right_spare) = split(spare, count / 2);
        let (left, right) = parts.both(
            count,
            || write_centres(mesh, first, keys, spare, parts),
            || write_centres(mesh, first + count / 2, right_keys, right_spare, parts),
        );
        return left.union(&right);
    }
    let mut all = Bounds::EMPTY;
    for ((triangle, key), spare) in (first as u32..).zip(keys).zip(spare) {
        let Bounds { min, max } = bounds(mesh, triangle);
        let centre = min * 0.25 + max * 0.25;
        all = all.with(centre);
        let [x, y, z] = centre.to_array().map(|x| u64::from(x.to_bits()));
        (*key, *spare) = (x | y << 32, z);
    }
    all
}

/// The cells that the curve runs through.
struct Curve {
    origin: Vec3A,
    cells_per_unit: Vec3A,
}

impl Curve {
    fn through(centres: &Bounds) -> Self {
        let per_unit = Vec3A::splat(LAST_CELL as f32) / (centres.max - centres.min);
        let usable = per_unit.cmple(Vec3A::splat(f32::MAX));
        let cells_per_unit = Vec3A::select(usable, per_unit, Vec3A::ZERO);
        Self { origin: centres.min, cells_per_unit }
    }

    /// Replaces the centre of each triangle by its key: a Morton code above the index.
    fn write_keys(&self, first: usize, keys: &mut [u64], spare: &mut [u64], parts: Parts<'_>) {
        let count = keys.len();
        if worth_dividing(count) {
            let (keys, right_keys) = split(keys, count / 2);
            let (spare, right_spare) = split(spare, count / 2);
            parts.both(
                count,
                || self.write_keys(first, keys, spare, parts),
                || self.write_keys(first + count / 2, right_keys, right_spare, parts),
            );
            return;
        }
        // A float this large has no room for fractions: its lowest bits are the nearest cell.
        let to_bits = Vec3A::splat(8_388_608.0);
        for ((triangle, key), &mut spare) in (first as u32..).zip(keys).zip(spare) {
            let centre = [*key, *key >> 32, spare].map(|x| f32::from_bits(x as u32));
            let cell = (Vec3A::from_array(centre) - self.origin) * self.cells_per_unit;
            let [x, y, z] = (cell + to_bits).to_array().map(|cell| cell.to_bits() & LAST_CELL);
            let code = spread(x, y) << 1 | spread(0, z);
            *key = code << INDEX_BITS | u64::from(triangle);
        }
    }
}

/// Moves bit i of two 11-bit numbers to bit 3i + 1 and 3i: both at once, in the halves of a word.
fn spread(upper: u32, lower: u32) -> u64 {
    let both = |mask: u64| mask << 32 | mask;
    let x = u64::from(upper) << 32 | u64::from(lower);
    let x = (x | x << 16) & both(0x0700_00ff);
    let x = (x | x << 8) & both(0x0700_f00f);
    let x = (x | x << 4) & both(0x430c_30c3);
    let x = (x | x << 2) & both(0x4924_9249);
    x >> 31 | x & 0xffff_ffff
}

struct Hierarchy<'h> {
    mesh: Mesh<'h>,
    leaves: Leaves,
    parts: Parts<'h>,
}

impl Hierarchy<'_> {
    /// Divides a run of sorted keys at its highest differing bit, or, if it is short and leaves are to be full,
    /// near it or in the middle.
    ///
    /// Depth: the highest differing bit of a run is above that of both its parts, and there are 64 bits. So d levels
    /// down at least log2 of the run's length are left, and halving its leaves stays within MAX_DEPTH = 64; parts
    /// of one leaf each do if there are no more leaves than levels.
    fn halves<'k>(&self, keys: &'k [u64], depth: usize) -> (&'k [u64], &'k [u64]) {
        let (Some(first), Some(last)) = (keys.first(), keys.last()) else { return (keys, keys) };
        let highest = (1 << 63) >> ((first ^ last).leading_zeros() & 63);
        let mut middle = keys.partition_point(|key| key & highest == 0);
        if keys.len() <= self.leaves.aligned {
            if depth + self.leaves.of(keys.len()) > MAX_DEPTH {
                middle = keys.len() / 2;
            }
            middle = self.leaves.align(middle, keys.len());
        }
        keys.split_at_checked(middle).unwrap_or_default()
    }

    /// How many nodes lie below that of a run of sorted keys.
    fn nodes_below(&self, keys: &[u64], depth: usize) -> usize {
        if self.leaves.is_one(keys.len()) {
            return 0;
        }
        let (left, right) = self.halves(keys, depth);
        2 + self.nodes_below(left, depth + 1) + self.nodes_below(right, depth + 1)
    }

    /// Builds a node over sorted keys, whose part of the order begins at `first`; returns how many
    /// nodes lie below.
    ///
    /// Time: runs of about s keys are at
    /// most 64·n/s, and searching one takes log s, which adds up to O(n).
    fn tree(
        &self,
        keys: &[u64],
        order: &mut [u32],
        first: usize,
        depth: usize,
        room: Room<'_>,
    ) -> usize {
        let count = keys.len();
        if self.leaves.is_one(count) {
            let mut all = Bounds::EMPTY;
            for (entry, &key) in order.iter_mut().zip(keys) {
                *entry = (key & ((1 << INDEX_BITS) - 1)) as u32;
                all = all.union(&bounds(self.mesh, *entry));
            }
            let Aabb { min, max } = all.into();
            *room.node = Node { min, first: first as u32, max, count: count as u32 };
            return 0;
        }
        let (left, right) = self.halves(keys, depth);
        let middle = left.len();
        let (left_order, right_order) = split(order, middle);
        let used = self.parts.siblings(
            [middle, count - middle],
            room.below,
            room.base,
            |room| self.tree(left, left_order, first, depth + 1, room),
            |room| self.tree(right, right_order, first + middle, depth + 1, room),
        );
        if let [left, right, ..] = room.below {
            let [left, right] = [left, right].map(|child| Bounds::new(&child.aabb()));
            let Aabb { min, max } = left.union(&right).into();
            *room.node = Node { min, first: room.base as u32, max, count: 0 };
        }
        used
    }
}
