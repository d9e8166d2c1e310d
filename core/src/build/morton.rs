//! The linear-time build along a Morton curve.
//!
//! Linear BVH after Lauterbach et al., "Fast BVH construction on GPUs" (2009): sort the triangles by
//! the interleaved bits of their centres, then split every run at its highest differing bit. What
//! differs: a key holds the triangle index below the code, so that keys are unique, equal codes
//! need no rule of their own, and sorted keys are the order.

use super::parts::{PART, Parts, Room, nodes_of_tree};
use super::radix::sort;
use super::{BuildOptions, BvhStorage, Join};
use crate::aabb::Bounds;
use crate::bvh::Node;
use crate::{Aabb, Bvh, CapacityError, Mesh};
use glam::Vec3A;

/// Bits of a triangle index: [`MAX_TRIANGLES`](crate::mesh::MAX_TRIANGLES) fits.
const INDEX_BITS: u32 = 31;

/// Bits of a centre along one axis.
const AXIS_BITS: u32 = 11;

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
/// [`CapacityError`] if `storage` is below [`node_bound`](crate::bvh::node_bound) nodes and one
/// order entry per triangle, or `scratch` below [`morton_scratch_bound`].
///
/// # Complexity
/// O(n).
///
/// # Examples
/// ```
/// use pfront_core::build::{BuildOptions, BvhStorage, morton};
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
/// use pfront_core::build::{BuildOptions, BvhStorage, morton_with};
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
    storage.check(count)?;
    CapacityError::check("scratch", morton_scratch_bound(count), scratch.len())?;
    if count == 0 {
        return Ok(storage.into_bvh(mesh, 0));
    }
    let (keys, spare) = scratch[..2 * count].split_at_mut(count);
    let curve = Curve::through(mesh, parts);
    curve.write_keys(0, keys, parts);
    sort(keys, spare, INDEX_BITS..u64::BITS, parts);
    let hierarchy = Hierarchy { mesh, max_leaf: options.max_leaf(), parts };
    let order = &mut storage.order[..count];
    let below = hierarchy.tree(keys, order, 0, Room::of_root(storage.nodes));
    Ok(storage.into_bvh(mesh, nodes_of_tree(below)))
}

#[inline(always)]
fn bounds(mesh: Mesh<'_>, triangle: u32) -> Bounds {
    let [a, b, c] = mesh.triangle(triangle).map(Vec3A::from_array);
    Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
}

/// The centre of a box at half scale, so that neither it nor the difference of two can overflow.
#[inline(always)]
fn centre(mesh: Mesh<'_>, triangle: u32) -> Vec3A {
    let Bounds { min, max } = bounds(mesh, triangle);
    min * 0.25 + max * 0.25
}

/// The cells that the curve runs through.
struct Curve<'m> {
    mesh: Mesh<'m>,
    origin: Vec3A,
    cells_per_unit: Vec3A,
}

impl<'m> Curve<'m> {
    fn through(mesh: Mesh<'m>, parts: Parts<'_>) -> Self {
        let Bounds { min, max } = centres(mesh, 0, mesh.triangles().len(), parts);
        let per_unit = Vec3A::splat((1 << AXIS_BITS) as f32) / (max - min);
        let usable = per_unit.cmple(Vec3A::splat(f32::MAX));
        let cells_per_unit = Vec3A::select(usable, per_unit, Vec3A::ZERO);
        Self { mesh, origin: min, cells_per_unit }
    }

    /// Puts the Morton code of each triangle's centre above its index.
    fn write_keys(&self, first: usize, keys: &mut [u64], parts: Parts<'_>) {
        let count = keys.len();
        if count > PART {
            let (left, right) = keys.split_at_mut(count / 2);
            parts.both(
                count,
                || self.write_keys(first, left, parts),
                || self.write_keys(first + count / 2, right, parts),
            );
            return;
        }
        let last = Vec3A::splat(((1 << AXIS_BITS) - 1) as f32);
        for (triangle, key) in (first as u32..).zip(keys) {
            let cell = (centre(self.mesh, triangle) - self.origin) * self.cells_per_unit;
            let [x, y, z] = cell.min(last).to_array().map(|cell| spread(cell as u32));
            *key = (x << 2 | y << 1 | z) << INDEX_BITS | u64::from(triangle);
        }
    }
}

/// The box of the centres of so many triangles.
fn centres(mesh: Mesh<'_>, first: usize, count: usize, parts: Parts<'_>) -> Bounds {
    if count <= PART {
        let triangles = first as u32..(first + count) as u32;
        return triangles.fold(Bounds::EMPTY, |all, triangle| all.with(centre(mesh, triangle)));
    }
    let half = count / 2;
    let (left, right) = parts.both(
        count,
        || centres(mesh, first, half, parts),
        || centres(mesh, first + half, count - half, parts),
    );
    left.union(&right)
}

/// Moves bit i of an 11-bit number to bit 3i.
fn spread(x: u32) -> u64 {
    let x = (x | x << 16) & 0x0700_00ff;
    let x = (x | x << 8) & 0x0700_f00f;
    let x = (x | x << 4) & 0x430c_30c3;
    u64::from((x | x << 2) & 0x4924_9249)
}

struct Hierarchy<'h> {
    mesh: Mesh<'h>,
    max_leaf: usize,
    parts: Parts<'h>,
}

impl Hierarchy<'_> {
    /// Builds a node over sorted keys, whose part of the order begins at `first`; returns how many
    /// nodes lie below.
    ///
    /// Depth: the highest differing bit of a run is above that of both its parts, and there are 64
    /// bits, so a leaf lies at most MAX_DEPTH = 64 below the root. Time: runs of about s keys are at
    /// most 64·n/s, and searching one takes log s, which adds up to O(n).
    fn tree(&self, keys: &[u64], order: &mut [u32], first: usize, room: Room<'_>) -> usize {
        let count = keys.len();
        if count <= self.max_leaf {
            let mut all = Bounds::EMPTY;
            for (entry, &key) in order.iter_mut().zip(keys) {
                *entry = (key & ((1 << INDEX_BITS) - 1)) as u32;
                all = all.union(&bounds(self.mesh, *entry));
            }
            let Aabb { min, max } = all.into();
            *room.node = Node { min, first: first as u32, max, count: count as u32 };
            return 0;
        }
        let highest = 1 << (keys[0] ^ keys[count - 1]).ilog2();
        let middle = keys.partition_point(|key| key & highest == 0);
        let (left, right) = keys.split_at(middle);
        let (left_order, right_order) = order.split_at_mut(middle);
        let used = self.parts.siblings(
            [middle, count - middle],
            room.below,
            room.base,
            |room| self.tree(left, left_order, first, room),
            |room| self.tree(right, right_order, first + middle, room),
        );
        let Aabb { min, max } = room.below[0].bounds().union(&room.below[1].bounds()).into();
        *room.node = Node { min, first: room.base as u32, max, count: 0 };
        used
    }
}
