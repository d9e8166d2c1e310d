//! Queries over borrowed meshes, in memory the caller already has.
//!
//! [`PairQuery`] and [`SelfQuery`] say what is asked; a [`Cursor`] says how far the answer has come.
//! The verbs are those of [`Query`].

use crate::pose::{InPlace, Placement, PoseError, Posed};
use crate::triangle::{Accuracy, Adjacency, Contact, contact};
use crate::walk::{Bvtt, PairTree, SelfTree, walk};
use crate::{Aabb, Bvh, Pose};
use core::ops::ControlFlow;

pub use crate::walk::{Cursor, NodePair, TrianglePair, Work};

/// What can be asked of two meshes, or of one.
pub trait Query {
    /// A cursor before the first triangle pair.
    fn start(&self) -> Cursor {
        Cursor::new(self.root())
    }

    /// Goes on from `cursor`, calling `visit` for each triangle pair that meets, until it breaks or
    /// all have been visited. The pair at which it broke counts as visited.
    ///
    /// The order is fixed for given BVHs, and otherwise arbitrary.
    ///
    /// # Complexity
    /// One box test a BVTT node and one triangle test a pair of overlapping triangle boxes; no
    /// allocation, no recursion, below 8 KiB of stack.
    fn visit(
        &self,
        cursor: &mut Cursor,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// Where a pair that a visit reported meets; in the frame of the first mesh. `None` for a pair
    /// that does not meet.
    ///
    /// # Panics
    /// If the indices are not of these meshes.
    fn contact(&self, pair: TrianglePair) -> Option<Contact>;

    /// The root of the BVTT, if its boxes overlap.
    fn root(&self) -> Option<NodePair>;

    /// Hands on the children of a BVTT node that overlap; returns the number of box tests, 0 for a
    /// pair of leaves, which has none.
    ///
    /// # Panics
    /// If `n` is not a node of this query; so do the next two.
    fn expand(&self, n: NodePair, push: &mut dyn FnMut(NodePair)) -> u32;

    /// The boxes of a BVTT node, both in the frame of the first mesh.
    fn boxes(&self, n: NodePair) -> [Aabb; 2];

    /// How many triangles lie below each side of a BVTT node.
    ///
    /// # Complexity
    /// O(depth).
    fn triangles_below(&self, n: NodePair) -> [u32; 2];

    /// About the edge of a leaf's box: the scale below which overlaps say nothing.
    fn leaf_edge(&self) -> f32;

    /// Goes on from `cursor` into `out` and returns how many pairs it wrote. It stops when `out` is
    /// full or nothing is left: nothing is ever dropped, and when [`Cursor::is_done`] all pages
    /// together are the whole answer. Only the last page may be empty, if `out` is not.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::{*, query::*};
    /// # fn pages(query: &impl Query) -> usize {
    /// let mut page = [TrianglePair::default(); 16];
    /// let mut cursor = query.start();
    /// let mut total = 0;
    /// while !cursor.is_done() {
    ///     let n = query.page(&mut cursor, &mut page);
    ///     total += page[..n].len();
    /// }
    /// # total }
    /// ```
    fn page(&self, cursor: &mut Cursor, out: &mut [TrianglePair]) -> usize {
        let mut len = 0;
        if out.is_empty() {
            return 0;
        }
        // Whether it broke or ended, the cursor knows.
        let _ = self.visit(cursor, |pair| {
            out[len] = pair;
            len += 1;
            if len == out.len() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        len
    }

    /// How many pairs meet.
    fn count(&self) -> u64 {
        let mut count = 0;
        let _ = self.visit(&mut self.start(), |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Some pair that meets; the walk stops at the first.
    fn any(&self) -> Option<TrianglePair> {
        let mut found = None;
        let _ = self.visit(&mut self.start(), |pair| {
            found = Some(pair);
            ControlFlow::Break(())
        });
        found
    }
}

/// Two meshes, the second in the pose `a_from_b`.
///
/// # Examples
/// ```
/// use pfront_core::{build::{self, *}, bvh::node_bound, query::*, *};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(1)], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let mut scratch = [0; build::morton_scratch_bound(1)];
/// let bvh = build::morton(mesh, &BuildOptions::default(), storage, &mut scratch)?;
/// let query = PairQuery::new(bvh, bvh, Pose::from_translation([0.5, 0.0, 0.0]))?;
/// assert_eq!(query.any(), Some(TrianglePair { a: 0, b: 0 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PairQuery<'a> {
    a: Bvh<'a>,
    b: Bvh<'a>,
    a_from_b: Pose,
    accuracy: Accuracy,
}

impl<'a> PairQuery<'a> {
    /// Asks for `a` against `b` posed by `a_from_b`, exactly.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes `b` out of range.
    pub fn new(a: Bvh<'a>, b: Bvh<'a>, a_from_b: Pose) -> Result<Self, PoseError> {
        if let Some(root) = b.root()
            && a_from_b != Pose::IDENTITY
        {
            a_from_b.check(&root.aabb())?;
        }
        Ok(Self { a, b, a_from_b, accuracy: Accuracy::Exact })
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    fn in_place(&self) -> Option<PairTree<'a, InPlace>> {
        let Self { a, b, accuracy, .. } = *self;
        (self.a_from_b == Pose::IDENTITY).then_some(PairTree { a, b, place: InPlace, accuracy })
    }

    fn posed(&self) -> PairTree<'a, Posed> {
        let Self { a, b, accuracy, .. } = *self;
        PairTree { a, b, place: Posed::new(&self.a_from_b), accuracy }
    }
}

impl Query for PairQuery<'_> {
    fn root(&self) -> Option<NodePair> {
        match self.in_place() {
            Some(tree) => tree.root(),
            None => self.posed().root(),
        }
    }

    fn expand(&self, n: NodePair, push: &mut dyn FnMut(NodePair)) -> u32 {
        match self.in_place() {
            Some(tree) => tree.children(n, push),
            None => self.posed().children(n, push),
        }
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        let [a, b] = [&self.a.nodes()[n.a as usize], &self.b.nodes()[n.b as usize]];
        let placed = match self.in_place() {
            Some(_) => b.aabb(),
            None => Posed::new(&self.a_from_b).bounds(&b.bounds()).into(),
        };
        [a.aabb(), placed]
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        [self.a.triangles_below(n.a), self.b.triangles_below(n.b)]
    }

    fn leaf_edge(&self) -> f32 {
        self.a.leaf_edge().max(self.b.leaf_edge())
    }

    fn visit(
        &self,
        cursor: &mut Cursor,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match self.in_place() {
            Some(tree) => walk(&tree, cursor, visit),
            None => walk(&self.posed(), cursor, visit),
        }
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        contact(&self.a.mesh().triangle(pair.a), &self.posed().placed_triangle(pair.b))
    }
}

/// One mesh against itself, each unordered pair of triangles once.
#[derive(Clone, Copy, Debug)]
pub struct SelfQuery<'a> {
    bvh: Bvh<'a>,
    accuracy: Accuracy,
    adjacency: Adjacency,
}

impl<'a> SelfQuery<'a> {
    /// Asks for all pairs under the shared-index rule, exactly.
    #[must_use]
    pub fn new(bvh: Bvh<'a>) -> Self {
        Self { bvh, accuracy: Accuracy::Exact, adjacency: Adjacency::SharedIndexRule }
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    /// The same with another rule for neighbours.
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        Self { adjacency, ..self }
    }

    fn tree(&self) -> SelfTree<'a> {
        let Self { bvh, accuracy, adjacency } = *self;
        SelfTree { bvh, accuracy, adjacency }
    }
}

impl Query for SelfQuery<'_> {
    fn root(&self) -> Option<NodePair> {
        self.tree().root()
    }

    fn expand(&self, n: NodePair, push: &mut dyn FnMut(NodePair)) -> u32 {
        self.tree().children(n, push)
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        [n.a, n.b].map(|node| self.bvh.nodes()[node as usize].aabb())
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        [n.a, n.b].map(|node| self.bvh.triangles_below(node))
    }

    fn leaf_edge(&self) -> f32 {
        self.bvh.leaf_edge()
    }

    fn visit(
        &self,
        cursor: &mut Cursor,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        walk(&self.tree(), cursor, visit)
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        let [a, b] = [pair.a, pair.b].map(|t| self.bvh.mesh().triangle(t));
        contact(&a, &b)
    }
}
