//! One mesh.

use super::{Bvtt, SelfTree, walk};
use super::{Cursor, NodePair, Query, TrianglePair};
use crate::bvh::Layout;
use crate::one_ring::{Certified, OneRing};
use crate::triangle::{Accuracy, Adjacency, Contact, contact};
use crate::{Aabb, Bvh, Node};
use core::ops::ControlFlow;

/// One mesh against itself, each unordered pair of triangles once.
#[derive(Clone, Copy, Debug)]
pub struct SelfQuery<'a, L: Layout = Node> {
    bvh: Bvh<'a, L>,
    accuracy: Accuracy,
    adjacency: Adjacency,
    fans: &'a [OneRing],
    boxes_only: bool,
}

impl<'a, L: Layout> SelfQuery<'a, L> {
    /// Asks for all pairs under the shared-index rule, exactly.
    #[must_use]
    pub fn new(bvh: Bvh<'a, L>) -> Self {
        let (accuracy, adjacency) = (Accuracy::Exact, Adjacency::SharedIndexRule);
        Self { bvh, accuracy, adjacency, fans: &[], boxes_only: false }
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
        Self { fans: certified.of_mesh(self.bvh.mesh()), ..self }
    }

    /// Asks for all pairs of triangles whose boxes overlap, whatever else. With each box of a set given
    /// as a triangle through two opposite corners, that is the broad phase of the set.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{build::*, bvh::node_bound, query::*, *};
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

    fn tree(&self) -> SelfTree<'a, L> {
        let Self { bvh, accuracy, adjacency, fans, boxes_only } = *self;
        SelfTree { bvh, accuracy, inexact: accuracy.inexact(), adjacency, fans, boxes_only }
    }
}

impl<L: Layout> Query for SelfQuery<'_, L> {
    fn root(&self) -> Option<NodePair> {
        self.tree().root()
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        self.tree().children(n, |child, [a, b]| push(child, [(*a).into(), (*b).into()]))
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

    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        walk(&self.tree(), cursor, budget, &mut visit)
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        let [a, b] = [pair.a, pair.b].map(|t| self.bvh.mesh().triangle(t));
        contact(&a, &b)
    }
}
