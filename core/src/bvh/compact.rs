//! The compact layout: nodes of 16 bytes, with boxes on a grid of 65,536 cells along each axis.
//!
//! Quantised boxes as in Mahovsky & Wyvill, "Memory-conserving bounding volume hierarchies with coherent
//! raytracing" (2006), who refer each box to that of its parent. Here one grid serves the whole tree: decoding a
//! box takes no other node, so a traversal may start anywhere, as workers do from a front, and decode four at once.
//!
//! # Rounding
//! The cells of an axis are 2^e wide and begin at whole multiples of that, so corner number q of the grid is
//! (m + q)·2^e for an integer m. The width is such that |m| ≤ 2^23, and q < 2^16: the sum is an integer
//! below 2^24 in absolute value, which f32 holds, and so is its product with 2^e, which is no less than the
//! smallest subnormal number. Decoding therefore rounds nothing, whether products are fused or not; smallest
//! corners are rounded down to the grid and largest ones up, in integers. A decoded box contains the standard one
//! and, since rounding is monotone, what the standard one contains, decoded. Only at the end of the range may the
//! grid go on beyond [`f32::MAX`]: such a corner decodes to infinity and
//! counts as `f32::MAX`, so that posed boxes are never NaN.
//!
//! Boxes grow by less than a cell at each side: that is at most a 32,767th of the mesh, or, of one that lies far
//! from the origin, the distance of neighbouring floats there.
//!
//! # Memory
//! Siblings are aligned as in a standard tree, which leaves slot 1 free: it holds the grid. A leaf holds at most
//! [`MAX_LEAF_SIZE`](super::MAX_LEAF_SIZE) triangles, so its count takes 3 bits beside a flag and 28 bits for
//! the beginning of its range; children begin at even indices, which keeps that flag free.
//!
//! Indices stay `u32`, those of vertices and those of the order: 16 or 24 bits would save 1 or 2 of about 26 bytes a
//! triangle, mesh included, and cost every query a type parameter.
//!
//! A mesh that deforms keeps the standard layout, which refits write: its boxes may leave the grid, and another
//! grid means rounding all of them anew.

#[cfg(test)]
mod tests;

use super::{Bvh, BvhError, Layout, Node, TO_BITS, TreeNode};
use crate::aabb::Bounds;
use crate::index::{at_mut, part_mut};
use crate::simd::Box4;
use crate::{Aabb, CapacityError, Mesh};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3A, Vec4};

/// The most triangles of a compact BVH: 28 bits of a leaf say where its range begins.
const MAX_COMPACT_TRIANGLES: usize = 1 << 28;

/// Writes the nodes of a BVH in the compact layout: its boxes are hardly larger, and queries find the same pairs.
///
/// `nodes` and `order` are those in use of a BVH of `mesh`; `order` serves the compact BVH too. `storage` must hold
/// as many nodes, but at least 2: [`node_bound`](super::node_bound) is always enough.
///
/// # Errors
/// [`BvhError::Capacity`] if `storage` is too small, [`BvhError::TooMany`] if `order` has more than 2^28 entries.
///
/// # Panics and wrong answers
/// As [`Bvh::new_unchecked`], with nodes and an order that are not those of a BVH of `mesh`.
///
/// # Complexity
/// O(nodes).
///
/// # Examples
/// ```
/// use pfront_core::bvh::{CompactNode, compact, node_bound};
/// use pfront_core::{Bvh, Mesh, Node, Pose, bvtt::*};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
/// let standard = Bvh::new(mesh, &root, &[0], &mut [0])?;
///
/// let mut storage = [CompactNode::default(); node_bound(1)];
/// let compact = compact(mesh, &root, standard.order(), &mut storage)?;
/// assert_eq!(PairBvtt::new(compact, standard, Pose::IDENTITY)?.count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compact<'a>(
    mesh: Mesh<'a>,
    nodes: &[Node],
    order: &'a [u32],
    storage: &'a mut [CompactNode],
) -> Result<Bvh<'a, CompactNode>, BvhError> {
    let (found, most) = (order.len(), MAX_COMPACT_TRIANGLES);
    if found > most {
        return Err(BvhError::TooMany { array: "order", most, found });
    }
    let needed = if nodes.len() == 1 { CompactNode::LONE } else { nodes.len() };
    CapacityError::check("storage", needed, storage.len())?;
    let storage = part_mut(storage, ..needed);
    if let Some(root) = nodes.first() {
        let grid = Grid::new(&root.aabb());
        let (first, inverse_width) = (grid.first(), grid.width.map(inverse_width));
        for (slot, node) in storage.iter_mut().zip(nodes) {
            *slot = CompactNode::new(node, first, inverse_width);
        }
        *at_mut(storage, 1) = grid.header();
    }
    Ok(Bvh::new_unchecked(mesh, storage, order))
}

/// A BVH node of the compact layout: 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CompactNode {
    /// Smallest corner of the box, in cells of the grid.
    pub min: [u16; 3],
    /// Largest corner of the box, in cells of the grid.
    pub max: [u16; 3],
    /// Inner node: index of its left child, which is even. Leaf: bit 0 set; bits 1 to 3 the number of its triangles
    /// less one; from bit 4 on the index of its first entry in the order.
    pub link: u32,
}

impl Layout for CompactNode {}

/// The grid of an axis begins and ends within so many cells of 0.
const FARTHEST: i32 = 1 << 23;
/// The number of the last corner.
const LAST: i32 = u16::MAX as i32;
/// Bits of the logarithm of a width in the header.
const WIDTH_BITS: u32 = 10;
/// The exponent of an f64 minus that logarithm: 0 stands for the smallest subnormal f32.
const WIDTH_BIAS: u32 = 1023 - 149;
/// The greatest width of a cell: 2^127.
const WIDEST: f32 = f32::from_bits(0x7f00_0000);

impl CompactNode {
    /// A standard node on a grid that contains it. Slot 1 of a standard tree has infinite coordinates.
    fn new(node: &Node, [i, j, k]: [i32; 3], [u, v, w]: [f64; 3]) -> Self {
        let leaf = node.first << 4 | node.count.wrapping_sub(1) << 1 | 1;
        let ([a, b, c], [d, e, f]) = (node.min, node.max);
        let number = |corner: i32, first: i32| corner.saturating_sub(first).clamp(0, LAST) as u16;
        Self {
            min: [number(below(a, u), i), number(below(b, v), j), number(below(c, w), k)],
            max: [number(above(d, u), i), number(above(e, v), j), number(above(f, w), k)],
            link: if node.is_leaf() { leaf } else { node.first },
        }
    }
}

/// How many cells of a width there are to 1.
fn inverse_width(width: f32) -> f64 {
    1.0 / f64::from(width)
}

/// The last corner at or below a coordinate, counted from 0.
#[inline]
fn below(x: f32, inverse_width: f64) -> i32 {
    // The product is exact: its factor is a power of two, and it is within the range of f64.
    let x = f64::from(x) * inverse_width;
    let whole = x as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > x))
}

/// The first corner at or above a coordinate.
#[inline]
fn above(x: f32, inverse_width: f64) -> i32 {
    below(-x, inverse_width).saturating_neg()
}

/// The grid of a tree: corner q of an axis is ([`TO_BITS`] + q + `offset`)·`width`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    offset: [f32; 3],
    width: [f32; 3],
}

impl Grid {
    /// The finest grid that contains a box.
    fn new(root: &Aabb) -> Self {
        let axis = |k: usize| {
            // In narrower cells the extent is 2^16 of them, or the farthest corner beyond FARTHEST.
            let (min, max) = (f64::from(root.min[k]), f64::from(root.max[k]));
            let farthest = min.abs().max(max.abs());
            let least = ((max - min) / f64::from(LAST + 1)).max(farthest / f64::from(FARTHEST));
            let power = f64::from_bits(least.to_bits() >> 52 << 52) as f32;
            let mut width = power.clamp(f32::from_bits(1), WIDEST);
            loop {
                let inverse_width = inverse_width(width);
                let (first, last) =
                    (below(root.min[k], inverse_width), above(root.max[k], inverse_width));
                let extent = last.saturating_sub(first);
                let fits = first >= -FARTHEST && last <= FARTHEST && extent <= LAST;
                if fits || width >= WIDEST {
                    return (first as f32 - TO_BITS, width);
                }
                width *= 2.0;
            }
        };
        let axes = [axis(0), axis(1), axis(2)];
        Self { offset: axes.map(|(offset, _)| offset), width: axes.map(|(_, width)| width) }
    }

    /// The corners that are number 0, counted from the origin.
    fn first(&self) -> [i32; 3] {
        self.offset.map(|offset| (offset + TO_BITS) as i32)
    }

    /// The grid as slot 1 of a tree.
    fn header(&self) -> CompactNode {
        let [x, y, z] = self.first().map(i32::cast_unsigned);
        let widths = self.width.iter().rev().fold(0, |bits, &width| {
            let exponent = (f64::from(width).to_bits() >> 52) as u32;
            bits << WIDTH_BITS | (exponent - WIDTH_BIAS)
        });
        bytemuck::must_cast([x, y, z, widths])
    }

    /// Reads slot 1 of a tree; `None` if that holds no grid.
    fn read(header: &CompactNode) -> Option<Self> {
        let [x, y, z, mut widths]: [u32; 4] = bytemuck::must_cast(*header);
        let mut grid = Self { offset: [0.0; 3], width: [0.0; 3] };
        for (k, first) in [x, y, z].map(u32::cast_signed).into_iter().enumerate() {
            let exponent = (widths & ((1 << WIDTH_BITS) - 1)) + WIDTH_BIAS;
            widths >>= WIDTH_BITS;
            grid.offset[k] = first as f32 - TO_BITS;
            grid.width[k] = f64::from_bits(u64::from(exponent) << 52) as f32;
            if !(-FARTHEST..=FARTHEST).contains(&first) || grid.width[k] > WIDEST {
                return None;
            }
        }
        (widths == 0).then_some(grid)
    }
}

/// [`TO_BITS`] + q.
#[inline(always)]
fn with_bits(q: u32) -> f32 {
    f32::from_bits(TO_BITS.to_bits() | q)
}

impl TreeNode for CompactNode {
    type Grid = Grid;

    /// The root, and the grid.
    const LONE: usize = 2;

    fn grid(nodes: &[Self]) -> Option<Grid> {
        if nodes.is_empty() {
            return Some(Grid { offset: [0.0; 3], width: [0.0; 3] });
        }
        nodes.get(1).and_then(Grid::read)
    }

    #[inline(always)]
    fn is_leaf(&self) -> bool {
        self.link & 1 != 0
    }

    #[inline(always)]
    fn left(&self) -> u32 {
        self.link
    }

    #[inline(always)]
    fn leaf_range(&self) -> [u32; 2] {
        [self.link >> 4, (self.link >> 1 & 7) + 1]
    }

    #[inline]
    fn bounds(&self, grid: &Grid) -> Bounds {
        let Box4 { min, max } = Self::boxes(grid, [self; 4]);
        let [min, max] = [min, max].map(|[x, y, z]| Vec3A::new(x.x, y.x, z.x));
        Bounds { min, max }
    }

    #[inline(always)]
    fn boxes(grid: &Grid, nodes: [&Self; 4]) -> Box4 {
        // Whole nodes in registers; then of all four the first word, the second, the third: two coordinates each.
        let [a, b, c, d]: [Vec4; 4] = nodes.map(|node| bytemuck::must_cast(*node));
        let words = Mat4::from_cols(a, b, c, d).transpose();
        let both = |word: Vec4| {
            let words: [u32; 4] = bytemuck::must_cast(word);
            let (low, high) =
                (words.map(|w| with_bits(w & 0xffff)), words.map(|w| with_bits(w >> 16)));
            let [low, high] = [Vec4::from_array(low), Vec4::from_array(high)];
            if cfg!(target_endian = "little") { [low, high] } else { [high, low] }
        };
        let [[a, b], [c, d], [e, f]] = [both(words.x_axis), both(words.y_axis), both(words.z_axis)];
        let corner =
            |k: usize, q: Vec4| (q + Vec4::splat(grid.offset[k])) * Vec4::splat(grid.width[k]);
        // A pose must not meet infinity, see the module.
        let (low, high) = (Vec4::splat(-f32::MAX), Vec4::splat(f32::MAX));
        Box4 {
            min: [corner(0, a), corner(1, b), corner(2, c)].map(|x| x.max(low)),
            max: [corner(0, d), corner(1, e), corner(2, f)].map(|x| x.min(high)),
        }
    }
}
