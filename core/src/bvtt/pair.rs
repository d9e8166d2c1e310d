//! Two meshes, one or both of them posed.

use super::{Bvtt, PairTree, Side, Visit, walk};
use super::{Cursor, NodePair, Query, TrianglePair};
use crate::bvh::Layout;
use crate::pose::PoseError;
use crate::transform::{InPlace, Place, Placement};
use crate::triangle::{Accuracy, Contact, contact};
use crate::{Aabb, Bvh, Node, Pose};
use core::ops::ControlFlow;

/// A BVH and where it stands in the frame of a query. Copying is free.
///
/// # Examples
/// ```
/// use pfront_core::{query::*, *};
/// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// # let root = Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 };
/// # let bvh = Bvh::new_unchecked(mesh, std::slice::from_ref(&root), &[0]);
/// let here = Placed::new(bvh, &Pose::from_translation([8.0, 0.0, 0.0]))?;
/// let there = Placed::new(bvh, &Pose::from_translation([8.5, 0.0, 0.0]))?;
/// assert_eq!(PairQuery::in_world(here, there).count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a, L: Layout = Node>(Side<'a, Place, Place, L>);

impl<'a, L: Layout> Placed<'a, L> {
    /// In a pose. [`Pose::IDENTITY`] leaves every vertex as it is and costs a query nothing.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes the mesh out of range.
    pub fn new(bvh: Bvh<'a, L>, world_from_bvh: &Pose) -> Result<Self, PoseError> {
        if *world_from_bvh != Pose::IDENTITY {
            world_from_bvh.check(&bvh.aabb().unwrap_or(Aabb::EMPTY))?;
        }
        Ok(Self::new_unchecked(bvh, world_from_bvh))
    }

    /// Places a BVH in a pose that [`Placed::new`] or [`Pose::check`] has accepted for its mesh, without checking
    /// the pose again.
    ///
    /// # Wrong answers
    /// In another pose, queries may miss pairs.
    #[must_use]
    pub fn new_unchecked(bvh: Bvh<'a, L>, world_from_bvh: &Pose) -> Self {
        Self(Side::new(bvh, Place::new(world_from_bvh)))
    }

    /// A box that contains every posed vertex of every triangle, rounding included; `None` for an
    /// empty mesh. What a broad phase goes by.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        let bvh = &self.0.bvh;
        Some(self.0.place.bounds(&bvh.bounds(bvh.root()?)).into())
    }
}

/// Two meshes in one frame: that of the first ([`PairQuery::new`]), or a world in which both are posed
/// ([`PairQuery::in_world`]). The choice changes how vertices are rounded, and so what is found.
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
pub struct PairQuery<'a, A: Layout = Node, B: Layout = A> {
    tree: PairTree<Side<'a, Place, Place, A>, Side<'a, Place, Place, B>>,
    /// Asked for more than once, by whoever weighs a question before it is walked.
    root: Option<NodePair>,
    leaf_edge: f32,
}

impl<'a, A: Layout, B: Layout> PairQuery<'a, A, B> {
    /// Asks for `a` against `b` posed by `a_from_b`, exactly.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes `b` out of range.
    pub fn new(a: Bvh<'a, A>, b: Bvh<'a, B>, a_from_b: Pose) -> Result<Self, PoseError> {
        Ok(Self::of(Side::new(a, Place::InPlace), Placed::new(b, &a_from_b)?.0))
    }

    /// Asks for two meshes that are both posed into a third frame, exactly.
    #[must_use]
    pub fn in_world(a: Placed<'a, A>, b: Placed<'a, B>) -> Self {
        let (Placed(mut a), Placed(mut b)) = (a, b);
        if let (Place::Posed(place_a), Place::Posed(place_b)) = (&a.place, &b.place)
            && let (Some(root_a), Some(root_b)) = (a.bvh.root(), b.bvh.root())
            && let (of_a, of_b) = (a.bvh.bounds(root_a), b.bvh.bounds(root_b))
            && let Some(seen) = place_b.seen_from(&of_b, place_a, &of_a)
        {
            (a.view, b.view) = (Place::InPlace, Place::Posed(seen));
        }
        Self::of(a, b)
    }

    fn of(a: Side<'a, Place, Place, A>, b: Side<'a, Place, Place, B>) -> Self {
        let leaf_edge = a.bvh.leaf_edge().max(b.bvh.leaf_edge());
        let tree = PairTree { a, b, inexact: None };
        Self { root: tree.root(), tree, leaf_edge }
    }

    /// Walks with each side placed as it is, so that no box or corner has to ask.
    fn walk(&self, cursor: &mut Cursor, budget: u64, visit: &mut Visit<'_>) -> ControlFlow<()> {
        use Place::{InPlace as Still, Posed};
        if cfg!(not(feature = "std")) {
            // A fifth of the machine code.
            return walk(&self.tree, cursor, budget, visit);
        }
        let (a, b, here) = (&self.tree.a, &self.tree.b, InPlace);
        match (&a.place, &b.place, &a.view, &b.view) {
            (Still, Still, ..) => self.through(cursor, budget, visit, (here, here), (here, here)),
            (Still, Posed(b), ..) => self.through(cursor, budget, visit, (here, here), (b, b)),
            (Posed(a), Still, ..) => self.through(cursor, budget, visit, (a, a), (here, here)),
            (Posed(a), Posed(b), Still, Posed(seen)) => {
                self.through(cursor, budget, visit, (a, here), (b, seen))
            }
            (Posed(a), Posed(b), ..) => self.through(cursor, budget, visit, (a, a), (b, b)),
        }
    }

    /// Walks with the places and views of both sides.
    fn through<P: Placement, V: Placement, Q: Placement, W: Placement>(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        visit: &mut Visit<'_>,
        a: (P, V),
        b: (Q, W),
    ) -> ControlFlow<()> {
        let a = Side { bvh: self.tree.a.bvh, place: a.0, view: a.1 };
        let b = Side { bvh: self.tree.b.bvh, place: b.0, view: b.1 };
        walk(&PairTree { a, b, inexact: self.tree.inexact }, cursor, budget, visit)
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(mut self, accuracy: Accuracy) -> Self {
        self.tree.inexact = accuracy.inexact();
        self
    }
}

impl<A: Layout, B: Layout> Query for PairQuery<'_, A, B> {
    fn root(&self) -> Option<NodePair> {
        self.root
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        self.tree.children(n, |child, [a, b]| push(child, [(*a).into(), (*b).into()]))
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        let PairTree { a, b, .. } = &self.tree;
        [a.bounds(a.node(n.a)).into(), b.bounds(b.node(n.b)).into()]
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        [self.tree.a.bvh.triangles_below(n.a), self.tree.b.bvh.triangles_below(n.b)]
    }

    fn leaf_edge(&self) -> f32 {
        self.leaf_edge
    }

    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.walk(cursor, budget, &mut visit)
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        contact(&self.tree.a.triangle(pair.a), &self.tree.b.triangle(pair.b))
    }
}
