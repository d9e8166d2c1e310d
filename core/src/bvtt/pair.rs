//! Two meshes, one or both of them posed.

use super::block::{BlockCache, Leaf};
use super::cursor::Budget;
use super::traversal::{Traverse, Visitor, traverse};
use super::{Bvtt, Cursor, NodePair, Query, TrianglePair, WideNode};
use crate::aabb::Bounds;
use crate::bvh::Layout;
use crate::pose::{Affine, PoseError};
use crate::simd::{LANES, Simd};
use crate::triangle::{Accuracy, Contact, Inexact, contact, intersects_exactly};
use crate::{Aabb, Bvh, Node, Pose, Triangle};
use core::ops::ControlFlow;
use glam::Vec3A;

/// A BVH in a pose, one side of a [`PairQuery`]. Copying is free.
///
/// # Examples
/// ```
/// use pfront_core::{bvtt::*, *};
/// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// # let root = Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 };
/// # let bvh = Bvh::new_unchecked(mesh, std::slice::from_ref(&root), &[0]);
/// let here = PosedBvh::new(bvh, &Pose::from_translation([8.0, 0.0, 0.0]))?;
/// let there = PosedBvh::new(bvh, &Pose::from_translation([8.5, 0.0, 0.0]))?;
/// assert_eq!(PairQuery::in_world(here, there).count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PosedBvh<'a, L: Layout = Node> {
    bvh: Bvh<'a, L>,
    /// The pose of the corners; `None` is the identity.
    pose: Option<Affine>,
}

impl<'a, L: Layout> PosedBvh<'a, L> {
    /// Poses a BVH. [`Pose::IDENTITY`] leaves every vertex as it is and costs a query nothing.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes the mesh out of range.
    pub fn new(bvh: Bvh<'a, L>, world_from_bvh: &Pose) -> Result<Self, PoseError> {
        if *world_from_bvh != Pose::IDENTITY {
            world_from_bvh.check(&bvh.aabb().unwrap_or(Aabb::EMPTY))?;
        }
        Ok(Self::new_unchecked(bvh, world_from_bvh))
    }

    /// Poses a BVH as [`PosedBvh::new`] or [`Pose::check`] has accepted it. In a pose that they refuse a query may
    /// miss pairs.
    #[must_use]
    pub fn new_unchecked(bvh: Bvh<'a, L>, world_from_bvh: &Pose) -> Self {
        let bounds = bvh.root().map_or(Bounds::EMPTY, |root| bvh.bounds(root));
        Self { bvh, pose: Affine::new(world_from_bvh, &bounds) }
    }

    /// A box that contains every posed vertex of every triangle, rounding included; `None` for an
    /// empty mesh. For broad phases.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        Some(posed(self.pose.as_ref(), &self.bvh.bounds(self.bvh.root()?)).into())
    }

    fn leaf(&self, node: u32) -> Leaf<'_> {
        let (leaf, pose) = (self.bvh.node(node), self.pose.as_ref());
        let bounds = posed(pose, &self.bvh.bounds(leaf)).into();
        let triangles = self.bvh.leaf_triangles(leaf);
        Leaf { mesh: self.bvh.mesh(), triangles, pose, bounds, rings: &[] }
    }

    fn triangle(&self, triangle: u32) -> Triangle {
        let corners = self.bvh.mesh().triangle(triangle);
        let Some(pose) = self.pose else { return corners };
        corners.map(|p| pose.point(Vec3A::from_array(p)).to_array())
    }
}

fn posed(pose: Option<&Affine>, bounds: &Bounds) -> Bounds {
    pose.map_or(*bounds, |pose| pose.bounds(bounds))
}

/// Two meshes in one frame: that of the first ([`PairQuery::new`]), or a world in which both are posed
/// ([`PairQuery::in_world`]). The choice changes how vertices are rounded, and so which pairs intersect.
///
/// # Examples
/// ```
/// use pfront_core::{bvh::{self, *}, bvtt::*, *};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(1)], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let mut scratch = [0; bvh::morton_scratch_bound(1)];
/// let bvh = bvh::morton(mesh, &BuildOptions::default(), storage, &mut scratch)?;
/// let query = PairQuery::new(bvh, bvh, Pose::from_translation([0.5, 0.0, 0.0]))?;
/// assert_eq!(query.any(), Some(TrianglePair { a: 0, b: 0 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PairQuery<'a, A: Layout = Node, B: Layout = A> {
    a: PosedBvh<'a, A>,
    b: PosedBvh<'a, B>,
    /// The poses in which the boxes of each side are compared. The box of a rotated box is larger, so the boxes of
    /// the second of two posed meshes are taken to the frame of the first where possible. Hits depend on corners alone.
    boxes: [Option<Affine>; 2],
    inexact: Option<Inexact>,
    /// Computed once, as fronts ask for it often, like `leaf_edge`.
    root: Option<NodePair>,
    leaf_edge: f32,
}

impl<'a, A: Layout, B: Layout> PairQuery<'a, A, B> {
    /// Asks for `a` against `b` posed by `a_from_b`, exactly.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes `b` out of range.
    pub fn new(a: Bvh<'a, A>, b: Bvh<'a, B>, a_from_b: Pose) -> Result<Self, PoseError> {
        let a = PosedBvh { bvh: a, pose: None };
        Ok(Self::in_world(a, PosedBvh::new(b, &a_from_b)?))
    }

    /// Asks for two meshes that are both posed into a third frame, exactly.
    #[must_use]
    pub fn in_world(a: PosedBvh<'a, A>, b: PosedBvh<'a, B>) -> Self {
        let mut boxes = [a.pose, b.pose];
        if let ([Some(pose_a), Some(pose_b)], Some(root_a), Some(root_b)) =
            (&boxes, a.bvh.root(), b.bvh.root())
        {
            let (of_a, of_b) = (a.bvh.bounds(root_a), b.bvh.bounds(root_b));
            if let Some(seen) = pose_b.seen_from(&of_b, pose_a, &of_a) {
                boxes = [None, Some(seen)];
            }
        }
        let leaf_edge = a.bvh.leaf_edge().max(b.bvh.leaf_edge());
        let mut query = Self { a, b, boxes, inexact: None, root: None, leaf_edge };
        if a.bvh.root().is_some() && b.bvh.root().is_some() {
            let [own, other] = query.bounds(NodePair::ROOT);
            query.root = own.overlaps(&other).then_some(NodePair::ROOT);
        }
        query
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { inexact: accuracy.inexact(), ..self }
    }

    fn bounds(&self, n: NodePair) -> [Bounds; 2] {
        let Self { a, b, boxes: [of_a, of_b], .. } = self;
        [
            posed(of_a.as_ref(), &a.bvh.bounds(a.bvh.node(n.a))),
            posed(of_b.as_ref(), &b.bvh.bounds(b.bvh.node(n.b))),
        ]
    }
}

impl<A: Layout, B: Layout> Bvtt for PairQuery<'_, A, B> {
    fn root(&self) -> Option<NodePair> {
        self.root
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        let mut tests = 0;
        for child in n.split(&self.a.bvh, &self.b.bvh) {
            tests += 1;
            let [a, b] = self.bounds(child);
            if a.overlaps(&b) {
                push(child, [a.into(), b.into()]);
            }
        }
        tests
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        self.bounds(n).map(Aabb::from)
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        [self.a.bvh.triangles_below(n.a), self.b.bvh.triangles_below(n.b)]
    }

    fn leaf_edge(&self) -> f32 {
        self.leaf_edge
    }
}

impl<A: Layout, B: Layout> Traverse for PairQuery<'_, A, B> {
    #[inline]
    fn is_leaf_pair(&self, n: NodePair) -> bool {
        self.a.bvh.node(n.a).is_leaf() && self.b.bvh.node(n.b).is_leaf()
    }

    #[inline(always)]
    fn descend(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32 {
        let mut wide = [WideNode::below(&self.a.bvh, n.a), WideNode::below(&self.b.bvh, n.b)];
        for (wide, pose) in wide.iter_mut().zip(&self.boxes) {
            if let Some(pose) = pose {
                wide.boxes = pose.boxes(&wide.boxes);
            }
        }
        let [a, b] = &wide;
        a.overlapping(b, push)
    }

    #[inline(always)]
    fn visit_leaf_pair<S: Simd>(
        &self,
        n: NodePair,
        [blocks_a, blocks_b]: &mut [BlockCache; 2],
        budget: &mut Budget,
        visit: &mut Visitor<'_>,
    ) -> ControlFlow<()> {
        let a = blocks_a.get::<S>(n.a, || self.a.leaf(n.a));
        let b = blocks_b.get::<S>(n.b, || self.b.leaf(n.b));
        let pairs = a.pairs::<S, false>(b, budget.open());
        budget.decide(pairs.tested, pairs.left, |bit| {
            let (i, j) = (bit as usize % LANES, bit as usize / LANES % LANES);
            if meet(&a.triangle(i), &b.triangle(j), self.inexact) {
                visit(TrianglePair { a: a.triangles[i], b: b.triangles[j] })
            } else {
                ControlFlow::Continue(())
            }
        })
    }
}

/// Whether two triangles that share no vertex intersect.
#[inline(always)]
pub(super) fn meet(a: &Triangle, b: &Triangle, inexact: Option<Inexact>) -> bool {
    match inexact {
        None => intersects_exactly(a, b),
        Some(meet) => meet(a, b),
    }
}

impl<A: Layout, B: Layout> Query for PairQuery<'_, A, B> {
    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        traverse(self, cursor, budget, &mut visit)
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        contact(&self.a.triangle(pair.a), &self.b.triangle(pair.b))
    }
}
