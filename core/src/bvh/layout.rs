//! How the nodes and the order of a BVH lie in memory.
//!
//! One walk serves all layouts: it asks a node whether it is a leaf, for its children or its run of the order,
//! and for its box or those of four, and the compiler makes a walk of each layout, or pair of them, that a
//! program uses. A node has the same index in all layouts of a tree, so a front of one is a front of another.

use super::Node;
use crate::aabb::Bounds;
use crate::bvtt::Visit;
use crate::bvtt::{Cursor, PairQuery, SelfQuery};
use crate::index::StandIn;
use crate::simd::Boxes;
use bytemuck::Pod;
use core::fmt::Debug;
use core::ops::ControlFlow;

/// The layout of a BVH: [`Wide`] or [`Compact`](super::Compact).
#[expect(
    private_bounds,
    reason = "sealed: what walks need of a layout is the business of this crate"
)]
pub trait Layout: Walked {
    /// A node.
    type Node: TreeNode;
    /// An entry of the order.
    type Index: Index;
}

/// Nodes of 32 bytes with boxes in f32, and an order in `u32`: what builds make and refits keep up to date.
#[derive(Clone, Copy, Debug)]
pub enum Wide {}

impl Layout for Wide {
    type Node = Node;
    type Index = u32;
}

/// Numbers of triangles in 4 bytes, `u32`; in 2, `u16`; or in 3, `[u8; 3]`, the lowest first.
#[expect(private_bounds, reason = "sealed, like layouts")]
pub trait Index: StandIn + Pod + Debug {
    /// How many triangles can be numbered, and be in a compact BVH.
    const MOST: usize;

    /// The number.
    fn get(self) -> u32;

    /// A number below [`Index::MOST`].
    #[must_use]
    fn new(number: u32) -> Self;
}

impl Index for u32 {
    /// 2^28: a leaf has 28 bits to tell where its run begins.
    const MOST: usize = 1 << 28;

    #[inline(always)]
    fn get(self) -> u32 {
        self
    }

    #[inline]
    fn new(number: u32) -> Self {
        number
    }
}

impl Index for u16 {
    const MOST: usize = 1 << 16;

    #[inline(always)]
    fn get(self) -> u32 {
        self.into()
    }

    #[inline]
    fn new(number: u32) -> Self {
        number as Self
    }
}

impl Index for [u8; 3] {
    const MOST: usize = 1 << 24;

    #[inline(always)]
    fn get(self) -> u32 {
        let [low, middle, high] = self;
        u32::from_le_bytes([low, middle, high, 0])
    }

    #[inline]
    fn new(number: u32) -> Self {
        let [low, middle, high, _] = number.to_le_bytes();
        [low, middle, high]
    }
}

/// What a walk asks of a node.
pub(crate) trait TreeNode: StandIn + Copy + Debug {
    /// What all boxes of a tree have in common.
    type Grid: Copy + Debug;

    /// How many slots a tree of one node takes.
    const FEWEST: usize;

    fn is_leaf(&self) -> bool;

    /// Of an inner node, the index of its left child; the right one is next to it.
    fn left(&self) -> u32;

    /// Of a leaf, its run of the order: where it begins, and how long it is.
    fn run(&self) -> [u32; 2];

    /// The box, finite in every tree that can be posed.
    fn bounds(&self, grid: &Self::Grid) -> Bounds;

    /// Four boxes.
    fn boxes(grid: &Self::Grid, nodes: [&Self; 4]) -> Boxes;
}

impl TreeNode for Node {
    type Grid = ();

    const FEWEST: usize = 1;

    #[inline(always)]
    fn is_leaf(&self) -> bool {
        self.count != 0
    }

    #[inline(always)]
    fn left(&self) -> u32 {
        self.first
    }

    #[inline(always)]
    fn run(&self) -> [u32; 2] {
        [self.first, self.count]
    }

    #[inline(always)]
    fn bounds(&self, (): &()) -> Bounds {
        Bounds::new(&self.aabb())
    }

    #[inline(always)]
    fn boxes((): &(), nodes: [&Self; 4]) -> Boxes {
        Boxes::of_nodes(nodes)
    }
}

/// Where the walks of a layout are compiled.
///
/// Those of wide BVHs are functions without parameters for types, so that this crate holds them once, and
/// whoever asks for pairs of these need not compile any.
pub(crate) trait Walked: Copy + Debug + 'static {
    /// Walks of a mesh of this layout and another mesh.
    fn pair<B: Layout>(
        query: &PairQuery<'_, Self, B>,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()>
    where
        Self: Layout,
    {
        query.walk(cursor, budget, visit)
    }

    /// Walks of a wide mesh and one of this layout.
    fn wide_and(
        query: &PairQuery<'_, Wide, Self>,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()>
    where
        Self: Layout,
    {
        query.walk(cursor, budget, visit)
    }

    /// Walks of a mesh with itself.
    fn within(
        query: &SelfQuery<'_, Self>,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()>
    where
        Self: Layout,
    {
        query.walk(cursor, budget, visit)
    }
}

impl Walked for Wide {
    #[inline]
    fn pair<B: Layout>(
        query: &PairQuery<'_, Self, B>,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()> {
        B::wide_and(query, cursor, budget, visit)
    }

    fn wide_and(
        query: &PairQuery<'_, Self, Self>,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()> {
        query.walk(cursor, budget, visit)
    }

    fn within(
        query: &SelfQuery<'_, Self>,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()> {
        query.walk(cursor, budget, visit)
    }
}
