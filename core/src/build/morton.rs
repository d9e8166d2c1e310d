//! The linear-time build along a Morton curve.
//!
//! Linear BVH after Lauterbach et al., "Fast BVH construction on GPUs" (2009): sort the triangles by
//! the interleaved bits of their centres, then split every run at its highest differing bit. What
//! differs: a key holds the triangle index below the code, so that keys are unique, equal codes
//! need no rule of their own, and sorted keys are the order.

use super::{BuildOptions, BvhStorage, Slots, refit};
use crate::bvh::{MAX_DEPTH, Node};
use crate::{Aabb, Bvh, CapacityError, Mesh};

/// Bits of a triangle index: [`MAX_TRIANGLES`](crate::mesh::MAX_TRIANGLES) fits.
const INDEX_BITS: u32 = 31;

/// Bits of a centre along one axis, and of one digit of the sort.
const DIGIT_BITS: u32 = 11;

const _: () = assert!(INDEX_BITS + 3 * DIGIT_BITS == u64::BITS);

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
    let count = mesh.triangles().len();
    storage.check(count)?;
    CapacityError::check("scratch", morton_scratch_bound(count), scratch.len())?;
    if count == 0 {
        return Ok(storage.into_bvh(mesh, 0));
    }
    let (keys, spare) = scratch[..2 * count].split_at_mut(count);
    write_keys(mesh, keys);
    // Three passes end in the other array.
    sort_pass(keys, spare, INDEX_BITS);
    sort_pass(spare, keys, INDEX_BITS + DIGIT_BITS);
    sort_pass(keys, spare, INDEX_BITS + 2 * DIGIT_BITS);
    for (entry, &key) in storage.order.iter_mut().zip(&*spare) {
        *entry = (key & ((1 << INDEX_BITS) - 1)) as u32;
    }
    let nodes = write_hierarchy(spare, options.max_leaf(), storage.nodes);
    refit(mesh, &mut storage.nodes[..nodes], storage.order);
    Ok(storage.into_bvh(mesh, nodes))
}

/// The centre of a box at half scale, so that neither it nor the difference of two can overflow.
fn centre(aabb: &Aabb) -> [f32; 3] {
    [0, 1, 2].map(|k| aabb.min[k] * 0.25 + aabb.max[k] * 0.25)
}

/// Puts the Morton code of each triangle's centre above its index.
fn write_keys(mesh: Mesh<'_>, keys: &mut [u64]) {
    let centre = |triangle| centre(&Aabb::of(&mesh.triangle(triangle)));
    let range = (0..keys.len() as u32).fold(Aabb::EMPTY, |range, triangle| {
        let c = centre(triangle);
        range.union(&Aabb { min: c, max: c })
    });
    let cells = (1 << DIGIT_BITS) as f32;
    let cells_per_unit = [0, 1, 2].map(|k| {
        let per_unit = cells / (range.max[k] - range.min[k]);
        if per_unit.is_finite() { per_unit } else { 0.0 }
    });
    for (triangle, key) in (0..).zip(keys) {
        let c = centre(triangle);
        let [x, y, z] = [0, 1, 2].map(|k| {
            let cell = ((c[k] - range.min[k]) * cells_per_unit[k]) as u32;
            spread(cell.min((1 << DIGIT_BITS) - 1))
        });
        *key = (x << 2 | y << 1 | z) << INDEX_BITS | u64::from(triangle);
    }
}

/// Moves bit i of an 11-bit number to bit 3i.
fn spread(x: u32) -> u64 {
    let x = (x | x << 16) & 0x0700_00ff;
    let x = (x | x << 8) & 0x0700_f00f;
    let x = (x | x << 4) & 0x430c_30c3;
    u64::from((x | x << 2) & 0x4924_9249)
}

/// One stable counting sort by the digit at `shift`.
fn sort_pass(from: &[u64], to: &mut [u64], shift: u32) {
    const DIGITS: usize = 1 << DIGIT_BITS;
    let digit = |key: u64| (key >> shift) as usize % DIGITS;
    let mut ends = [0_u32; DIGITS];
    for &key in from {
        ends[digit(key)] += 1;
    }
    let mut start = 0;
    for end in &mut ends {
        start += core::mem::replace(end, start);
    }
    for &key in from {
        let next = &mut ends[digit(key)];
        to[*next as usize] = key;
        *next += 1;
    }
}

/// Writes children and leaf runs for sorted keys, boxes left open; returns the nodes used.
///
/// Depth: the highest differing bit of a run is above that of both its parts, and there are 64
/// bits, so a leaf lies at most MAX_DEPTH = 64 below the root. Time: runs of about s keys are at
/// most 64·n/s, and searching one takes log s, which adds up to O(n).
fn write_hierarchy(keys: &[u64], max_leaf: usize, nodes: &mut [Node]) -> usize {
    let mut slots = Slots::new();
    // One right sibling waits for each level above the current node.
    let mut waiting = [(0, 0, 0); MAX_DEPTH];
    let mut len = 0;
    let (mut node, mut first, mut end) = (0, 0, keys.len());
    nodes[1] = Node::EMPTY;
    loop {
        if end - first <= max_leaf {
            nodes[node] = Node { first: first as u32, count: (end - first) as u32, ..Node::EMPTY };
            if len == 0 {
                return slots.nodes();
            }
            len -= 1;
            (node, first, end) = waiting[len];
        } else {
            let left = slots.pair();
            nodes[node] = Node { first: left as u32, ..Node::EMPTY };
            let highest = 1 << (keys[first] ^ keys[end - 1]).ilog2();
            let middle = first + keys[first..end].partition_point(|key| key & highest == 0);
            waiting[len] = (left + 1, middle, end);
            len += 1;
            (node, end) = (left, middle);
        }
    }
}
