//! One mesh with itself: each unordered pair of triangles once.
//!
//! The node pair (n, n) has the children (l, l), (l, r) and (r, r); a pair of different nodes branches as that of two
//! meshes does. Boxes of triangles that share a vertex overlap, so the traversal reaches all of these pairs; what they
//! share by index is left to [`Adjacency`], in the leaves.

use super::block::{BlockCache, Leaf};
use super::block_pairs::{PairSets, share_vertex};
use super::cursor::Budget;
use super::pair::meet;
use super::traversal::{Traverse, Visitor, traverse};
use super::{Bvtt, Cursor, NodePair, Query, TrianglePair, WideNode};
use crate::bvh::Layout;
use crate::index::at;
use crate::one_ring::{Certified, OneRing};
use crate::simd::{LANES, Simd};
use crate::triangle::{Accuracy, Adjacency, Contact, contact, intersects_in_mesh};
use crate::{Aabb, Bvh, Node};
use core::ops::ControlFlow;

/// One mesh against itself, each unordered pair of triangles once.
#[derive(Clone, Copy, Debug)]
pub struct SelfQuery<'a, L: Layout = Node> {
    bvh: Bvh<'a, L>,
    accuracy: Accuracy,
    adjacency: Adjacency,
    rings: &'a [OneRing],
    boxes_only: bool,
}

impl<'a, L: Layout> SelfQuery<'a, L> {
    /// Asks for all pairs under the shared-index rule, exactly.
    #[must_use]
    pub fn new(bvh: Bvh<'a, L>) -> Self {
        let (accuracy, adjacency) = (Accuracy::Exact, Adjacency::SharedIndexRule);
        Self { bvh, accuracy, adjacency, rings: &[], boxes_only: false }
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

    /// The same pairs, found sooner where many vertices are certified: see [`one_ring`](crate::one_ring).
    ///
    /// Certificates of another mesh are not used: both must borrow the same positions and triangles.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvh::*, bvtt::*, one_ring::*, *};
    /// let (points, triangles) = ([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]);
    /// let mesh = Mesh::new(&points, &triangles)?;
    /// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(1)], [0; 1]);
    /// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    /// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 2])?;
    /// let (mut history, mut scratch) = ([0; history_bound(3, 1)], [0; link_scratch_bound(3, 1)]);
    /// let mut rings = OneRings::new(3, &triangles, &mut history, &mut scratch)?;
    /// let certified = rings.certify(mesh, &CertifyOptions::default());
    /// assert_eq!(SelfQuery::new(bvh).with_certificates(certified).count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_certificates(self, certified: Certified<'a>) -> Self {
        Self { rings: certified.of_mesh(self.bvh.mesh()), ..self }
    }

    /// Asks for all pairs of triangles whose boxes overlap, neighbours included. With each box of a set given
    /// as a triangle through two opposite corners, that is the broad phase of the set.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvh::*, bvtt::*, *};
    /// let corners = [[0.0; 3], [2.0; 3], [1.0; 3], [3.0; 3], [2.5, 0.0, 0.0], [4.0, 0.9, 9.0]];
    /// let boxes = Mesh::new(&corners, &[[0, 1, 1], [2, 3, 3], [4, 5, 5]])?;
    /// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(3)], [0; 3]);
    /// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    /// let bvh = morton(boxes, &BuildOptions::default(), storage, &mut [0; 6])?;
    /// let query = SelfQuery::new(bvh).boxes_only();
    /// assert_eq!((query.count(), query.any()), (1, Some(TrianglePair { a: 0, b: 1 })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn boxes_only(self) -> Self {
        Self { boxes_only: true, ..self }
    }

    fn leaf(&self, node: u32) -> Leaf<'_> {
        let leaf = self.bvh.node(node);
        let (triangles, bounds) = (self.bvh.leaf_triangles(leaf), self.bvh.bounds(leaf).into());
        Leaf { mesh: self.bvh.mesh(), triangles, pose: None, bounds, rings: self.rings }
    }
}

impl<L: Layout> Bvtt for SelfQuery<'_, L> {
    fn root(&self) -> Option<NodePair> {
        self.bvh.root().map(|_| NodePair::ROOT)
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        let mut tests = 0;
        // (l, r) and (r, l) are the same pair.
        for child in n.split(&self.bvh, &self.bvh).filter(|child| n.a != n.b || child.a <= child.b)
        {
            let boxes = self.boxes(child);
            tests += u32::from(child.a != child.b);
            if boxes[0].overlaps(&boxes[1]) {
                push(child, boxes);
            }
        }
        tests
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        [n.a, n.b].map(|node| self.bvh.bounds(self.bvh.node(node)).into())
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        [n.a, n.b].map(|node| self.bvh.triangles_below(node))
    }

    fn leaf_edge(&self) -> f32 {
        self.bvh.leaf_edge()
    }
}

/// The pairs of a block with itself, each once: triangle j with those before it.
const BEFORE: u64 = 0x7f3f_1f0f_0703_0100;

impl<L: Layout> Traverse for SelfQuery<'_, L> {
    #[inline]
    fn is_leaf_pair(&self, n: NodePair) -> bool {
        self.bvh.node(n.a).is_leaf() && self.bvh.node(n.b).is_leaf()
    }

    #[inline(always)]
    fn descend(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32 {
        let a = WideNode::below(&self.bvh, n.a);
        if n.a == n.b {
            a.overlapping_self(push)
        } else {
            a.overlapping(&WideNode::below(&self.bvh, n.b), push)
        }
    }

    #[inline(always)]
    fn visit_leaf_pair<S: Simd>(
        &self,
        n: NodePair,
        [blocks_a, blocks_b]: &mut [BlockCache; 2],
        budget: &mut Budget,
        visit: &mut Visitor<'_>,
    ) -> ControlFlow<()> {
        let a = blocks_a.get::<S>(n.a, || self.leaf(n.a));
        let b = blocks_b.get::<S>(n.b, || self.leaf(n.b));
        let allowed = if n.a == n.b { budget.open() & BEFORE } else { budget.open() };
        let pairs = if self.boxes_only {
            let tested = a.box_pairs::<S>(b, allowed);
            PairSets { tested, left: tested, neighbours: 0 }
        } else {
            a.pairs::<S, true>(b, allowed)
        };
        let mesh = self.bvh.mesh();
        budget.decide(pairs.tested, pairs.left, |bit| {
            let (i, j) = (bit as usize % LANES, bit as usize / LANES % LANES);
            let (t, u) = (a.triangles[i], b.triangles[j]);
            let pair = TrianglePair { a: t.min(u), b: t.max(u) };
            let vertices = |triangle| at(mesh.triangles(), triangle);
            let hit = if self.boxes_only {
                true
            } else if pairs.neighbours >> bit & 1 != 0 && share_vertex(vertices(t), vertices(u)) {
                intersects_in_mesh(mesh, pair.a, pair.b, self.adjacency, self.accuracy)
            } else {
                meet(&a.triangle(i), &b.triangle(j), self.accuracy.inexact())
            };
            if hit { visit(pair) } else { ControlFlow::Continue(()) }
        })
    }
}

impl<L: Layout> Query for SelfQuery<'_, L> {
    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        traverse(self, cursor, budget, &mut visit)
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        let [a, b] = [pair.a, pair.b].map(|t| self.bvh.mesh().triangle(t));
        contact(&a, &b)
    }
}
