//! The BVTT of two moving meshes, or of one and itself, and its traversal.

use super::MovingBvh;
use super::adjacency::{are_certainly_apart, impact_in_mesh};
use super::common_time::first_overlap;
use super::impact::{Impact, impact_in_steps, impact_of};
use super::leaf::Leaf;
use super::pair::MovingPair;
use crate::bvh::MAX_DEPTH;
use crate::bvtt::{
    BEFORE, Bvtt, MovingBlocks, MovingGroup, NodePair, PairBvtt, SelfBvtt, TrianglePair, Work,
};
use crate::simd::{LANES, Simd, Task, VECTORS, widest};
use crate::triangle::Adjacency;
use core::ops::ControlFlow;

/// Two meshes that move, or with `SELF` one and itself: its verbs tell which triangles meet on the way, and when first.
///
/// Nodes are compared at a common time: see the boxes of [`motion`](super).
#[derive(Clone, Copy, Debug)]
pub struct MovingBvtt<'a, const SELF: bool> {
    start: Bvtt<'a, SELF>,
    end: Bvtt<'a, SELF>,
}

/// Two triangles that meet, and when.
type Hit = (TrianglePair, Impact);

/// The visitor of pairs that meet: it breaks, or goes on with those that meet no later than a time.
type Visitor<'v> = dyn FnMut(Hit) -> ControlFlow<(), f64> + 'v;

/// The most pending node pairs. A step pops one and pushes at most four, each deeper in at least one tree unless it is a leaf there: a path
/// downwards has at most `MAX_DEPTH` steps.
const STACK: usize = 3 * MAX_DEPTH + 1;

/// How much later than the first time of overlap of two nodes that of two of their triangles may be computed to be earlier.
const ROUNDED: f64 = 1.0 / 281_474_976_710_656.0;

impl<'a> PairBvtt<'a> {
    /// Asks for two meshes that move in a world: which triangles meet on the way, and when first.
    ///
    /// Corners go in straight lines in that frame. In the frame of the first mesh the same poses at both ends are another motion, unless
    /// it rests.
    ///
    /// # Examples
    /// See [`MovingBvh`].
    #[must_use]
    pub fn moving(a: MovingBvh<'a>, b: MovingBvh<'a>) -> MovingBvtt<'a, false> {
        let query = |a, b| PairBvtt::in_world(a, b).in_own_frame();
        MovingBvtt { start: query(a.start, b.start), end: query(a.end, b.end) }
    }
}

impl<'a> SelfBvtt<'a> {
    /// Asks for one mesh that moves or deforms: which of its triangles meet on the way, and when first. Poses do not matter.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvh::*, bvtt::*, motion::*, *};
    /// let triangles = [[0, 1, 2], [3, 4, 5]];
    /// let points = |z| [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 1.0, z], [2.0, 1.0, z], [1.0, 2.0, z]];
    /// let (start, end) = (points(1.0), points(-1.0));
    /// let mesh = Mesh::new(&start, &triangles)?;
    /// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(2)], [0; 2]);
    /// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    /// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 4])?;
    /// // The same nodes over the positions at the end.
    /// let mut moved = [Node::EMPTY; node_bound(2)];
    /// moved[..bvh.nodes().len()].copy_from_slice(bvh.nodes());
    /// let moved = &mut moved[..bvh.nodes().len()];
    /// refit(mesh.with_positions(&end)?, moved, bvh.order(), Refit::default())?;
    /// let moved = Bvh::new_unchecked(mesh.with_positions(&end)?, moved, bvh.order());
    /// let side = |bvh| PosedBvh::new(bvh, &Pose::IDENTITY);
    /// let query = SelfBvtt::moving(MovingBvh::new(side(bvh)?, side(moved)?)?);
    /// assert_eq!(query.count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn moving(motion: MovingBvh<'a>) -> MovingBvtt<'a, true> {
        let query = |side: crate::bvtt::PosedBvh<'a>| SelfBvtt::new(side.bvh);
        MovingBvtt { start: query(motion.start), end: query(motion.end) }
    }
}

impl MovingBvtt<'_, true> {
    /// The same with another rule for neighbours.
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        let [start, end] = [self.start, self.end].map(|query| query.with_adjacency(adjacency));
        Self { start, end }
    }
}

impl<const SELF: bool> MovingBvtt<'_, SELF> {
    /// The root, if its boxes overlap at a time.
    #[must_use]
    pub fn root(&self) -> Option<NodePair> {
        if !self.start.has_roots() {
            return None;
        }
        self.first_overlap(NodePair::ROOT).map(|_| NodePair::ROOT)
    }

    /// Passes on the children of a node whose boxes overlap at a time, at most four. Returns the number of box tests: 0 for a leaf pair,
    /// which has no children.
    pub fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair)) -> u32 {
        self.descend(n, |child, _| push(child))
    }

    /// Calls `visit` for each pair of triangles below a node pair that meet, until it breaks. Adds its tests to `work`.
    ///
    /// The order is fixed for given BVHs, and otherwise arbitrary. Triangles of one mesh are numbered a < b.
    ///
    /// # Complexity
    /// Four box tests a node pair; for two triangles whose boxes overlap at a time some ten nanoseconds if they stay well apart or cross at the start,
    /// else some microseconds; no allocation, no recursion, bounded stack.
    pub fn visit_below(
        &self,
        n: NodePair,
        work: &mut Work,
        mut visit: impl FnMut(TrianglePair, Impact) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.traverse(n, work, f64::INFINITY, &mut |(pair, impact)| match visit(pair, impact) {
            ControlFlow::Continue(()) => ControlFlow::Continue(f64::INFINITY),
            ControlFlow::Break(()) => ControlFlow::Break(()),
        })
    }

    /// [`MovingBvtt::visit_below`] the root.
    pub fn visit(
        &self,
        visit: impl FnMut(TrianglePair, Impact) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match self.root() {
            Some(root) => self.visit_below(root, &mut Work::default(), visit),
            None => ControlFlow::Continue(()),
        }
    }

    /// The number of pairs that meet.
    #[must_use]
    pub fn count(&self) -> u64 {
        let mut count = 0;
        let _ = self.visit(|_, _| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Some pair that meets, if any does; the traversal stops at the first that it comes upon.
    #[must_use]
    pub fn any(&self) -> Option<TrianglePair> {
        let mut found = None;
        let _ = self.visit(|pair, _| {
            found = Some(pair);
            ControlFlow::Break(())
        });
        found
    }

    /// The pair that meets first, by `from` and then by the pair, if any does.
    ///
    /// # Complexity
    /// Node pairs that overlap first are visited first, and those that do so later than the answer are left out.
    #[must_use]
    pub fn first_impact(&self) -> Option<(TrianglePair, Impact)> {
        self.first_impact_below(self.root()?, &mut Work::default(), None)
    }

    /// [`MovingBvtt::first_impact`] below a node pair, or what is already known if nothing comes before it.
    #[must_use]
    pub fn first_impact_below(
        &self,
        n: NodePair,
        work: &mut Work,
        known: Option<(TrianglePair, Impact)>,
    ) -> Option<(TrianglePair, Impact)> {
        let mut best = known;
        let limit = |best: &Option<Hit>| best.map_or(f64::INFINITY, |(_, impact)| impact.from);
        let _ = self.traverse(n, work, limit(&known), &mut |hit| {
            let is_first = best.is_none_or(|best| (hit.1.from, hit.0) < (best.1.from, best.0));
            if is_first {
                best = Some(hit);
            }
            ControlFlow::Continue(limit(&best))
        });
        best
    }

    /// When two triangles meet first; `None` if they do not. Triangles of one mesh may be in either order.
    ///
    /// # Panics
    /// If an index is out of range.
    #[must_use]
    pub fn impact(&self, pair: TrianglePair) -> Option<Impact> {
        let pair = ordered::<SELF>(pair);
        let sides = self.leaves(pair);
        let sides = sides.each_ref();
        self.impact_of(pair, sides, first_overlap_of(sides)?)
    }

    fn leaves(&self, TrianglePair { a, b }: TrianglePair) -> [Leaf; 2] {
        let ends = [&self.start, &self.end];
        [Leaf::of(a, 0, ends), Leaf::of(b, 1, ends)]
    }

    /// When two triangles meet first whose boxes overlap first at a time.
    #[inline(always)]
    fn impact_of(&self, pair: TrianglePair, [p, q]: [&Leaf; 2], first: f64) -> Option<Impact> {
        let found = match self.indices(pair).filter(|&indices| share_a_vertex(indices)) {
            // Lanes have tried what separates most pairs.
            None if self.errors().is_none() => {
                let moving = MovingPair::new(&p.corners, &q.corners);
                impact_in_steps(&p.corners, &q.corners, &moving)
            }
            None => impact_of(&p.corners, &q.corners),
            Some(_) if self.start.adjacency() == Adjacency::SkipNeighbours => return None,
            Some(indices) if are_certainly_apart(indices, [&p.corners, &q.corners]) => return None,
            Some(_) => {
                let [start, end] = [&self.start, &self.end].map(|query| query.mesh_of(0));
                impact_in_mesh(start, end, pair.a, pair.b, self.start.adjacency())
            }
        };
        // Nearness may come before the boxes overlap, and would then depend on which of them are visited.
        let Impact { from, to } = found?;
        Some(Impact { from: from.max(first.min(to)), to })
    }

    /// The errors of corners in lanes at the start and at the end, if one of them is in f64.
    #[inline(always)]
    fn errors(&self) -> Option<[[f32; 3]; 2]> {
        match [&self.start, &self.end].map(Bvtt::error_of_lanes) {
            [None, None] => None,
            errors => Some(errors.map(Option::unwrap_or_default)),
        }
    }

    /// The vertices of two triangles of one mesh.
    #[inline(always)]
    fn indices(&self, pair: TrianglePair) -> Option<[&[u32; 3]; 2]> {
        let triangles = self.start.mesh_of(0).triangles();
        SELF.then(|| [&triangles[pair.a as usize], &triangles[pair.b as usize]])
    }

    /// The first time at which the boxes of both nodes overlap.
    #[inline]
    fn first_overlap(&self, n: NodePair) -> Option<f64> {
        first_overlap(&self.start.bounds(n), &self.end.bounds(n))
    }

    /// Passes on the children of a node pair that overlap at a time, and the first. Returns the number of box tests.
    #[inline]
    fn descend(&self, n: NodePair, mut push: impl FnMut(NodePair, f64)) -> u32 {
        let mut tests = 0;
        self.start.each_child(n, |child| {
            if SELF && child.a == child.b {
                push(child, 0.0);
                return;
            }
            tests += 1;
            if let Some(time) = self.first_overlap(child) {
                push(child, time);
            }
        });
        tests
    }

    /// Visits pairs below a node pair that meet no later than `limit`, or than the visitor says; nodes that overlap first come first.
    fn traverse(
        &self,
        n: NodePair,
        work: &mut Work,
        limit: f64,
        visit: &mut Visitor<'_>,
    ) -> ControlFlow<()> {
        let task = MovingTraversal { query: self, n, work, limit, visit };
        if VECTORS { widest(task) } else { task.run::<f32>() }
    }
}

/// The arguments of a traversal, as a [`Task`] that is compiled for each width of lanes.
struct MovingTraversal<'t, 'v, 'a, const SELF: bool> {
    query: &'t MovingBvtt<'a, SELF>,
    n: NodePair,
    work: &'t mut Work,
    limit: f64,
    visit: &'t mut Visitor<'v>,
}

impl<const SELF: bool> Task for MovingTraversal<'_, '_, '_, SELF> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> ControlFlow<()> {
        let (mut stack, mut len) = ([(self.n, 0.0); STACK], 1);
        let mut blocks = [MovingBlocks::new(), MovingBlocks::new()];
        let mut group = MovingGroup::new();
        while len > 0 {
            len -= 1;
            let (n, time) = stack[len];
            if time - ROUNDED > self.limit {
                continue;
            }
            let first = len;
            let tests = self.query.descend(n, |child, time| {
                let mut at = len;
                stack[at] = (child, time);
                len += 1;
                while at > first && stack[at - 1].1 < time {
                    stack.swap(at - 1, at);
                    at -= 1;
                }
            });
            self.work.box_tests += u64::from(tests);
            if tests == 0 {
                self.visit_leaf_pair::<S>(n, &mut blocks, &mut group)?;
            }
        }
        self.visit_group(&mut group)
    }
}

impl<const SELF: bool> MovingTraversal<'_, '_, '_, SELF> {
    /// Visits the pairs of triangles of two leaves, or leaves them to the group.
    #[inline(always)]
    fn visit_leaf_pair<S: Simd>(
        &mut self,
        n: NodePair,
        [blocks_a, blocks_b]: &mut [MovingBlocks; 2],
        group: &mut MovingGroup,
    ) -> ControlFlow<()> {
        let MovingBvtt { start, end } = self.query;
        let a = blocks_a.get::<S, SELF>(n.a, 0, [start, end]);
        let b = blocks_b.get::<S, SELF>(n.b, 1, [start, end]);
        let allowed = if SELF && n.a == n.b { BEFORE } else { u64::MAX };
        let errors = self.query.errors();
        let pairs = a.cull::<S, SELF>(b, allowed, start.adjacency(), errors);
        self.work.triangle_tests += u64::from(pairs.overlapping.count_ones());
        let alone = if errors.is_some() { pairs.open } else { pairs.may_share_vertex };
        let (mut left, mut rest) = (pairs.hits | alone, pairs.open & !alone);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let pair = a.pair(b, [bit, bit / LANES]);
            if pairs.hits >> bit & 1 != 0 {
                self.take(ordered::<SELF>(pair), Impact { from: 0.0, to: 0.0 })?;
            } else {
                self.decide(pair)?;
            }
        }
        while rest != 0 {
            rest = group.gather(a, b, rest);
            if group.is_full() {
                self.visit_group(group)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits the gathered pairs.
    #[inline(never)]
    fn visit_group(&mut self, group: &mut MovingGroup) -> ControlFlow<()> {
        let (pairs, mut left) = group.flush();
        while left != 0 {
            self.decide(pairs[left.trailing_zeros() as usize % LANES])?;
            left &= left - 1;
        }
        ControlFlow::Continue(())
    }

    /// Visits two triangles if they meet no later than the limit.
    #[inline(never)]
    fn decide(&mut self, pair: TrianglePair) -> ControlFlow<()> {
        let pair = ordered::<SELF>(pair);
        let sides = self.query.leaves(pair);
        let sides = sides.each_ref();
        let first = first_overlap_of(sides).filter(|first| first - ROUNDED <= self.limit);
        match first.and_then(|first| self.query.impact_of(pair, sides, first)) {
            Some(impact) => self.take(pair, impact),
            None => ControlFlow::Continue(()),
        }
    }

    fn take(&mut self, pair: TrianglePair, impact: Impact) -> ControlFlow<()> {
        self.limit = match (self.visit)((pair, impact)) {
            ControlFlow::Continue(limit) => limit,
            ControlFlow::Break(()) => return ControlFlow::Break(()),
        };
        ControlFlow::Continue(())
    }
}

/// The first time at which the boxes of two triangles overlap.
#[inline]
fn first_overlap_of([p, q]: [&Leaf; 2]) -> Option<f64> {
    first_overlap(&[p.boxes[0], q.boxes[0]], &[p.boxes[1], q.boxes[1]])
}

/// Whether two triangles have a vertex in common, by index.
#[inline(always)]
fn share_a_vertex([&[p, q, r], other]: [&[u32; 3]; 2]) -> bool {
    // All at once: nine comparisons are cheaper than a jump that may be mispredicted.
    other.iter().fold(false, |shared, &v| shared | (v == p) | (v == q) | (v == r))
}

/// A pair of one mesh in ascending order.
fn ordered<const SELF: bool>(TrianglePair { a, b }: TrianglePair) -> TrianglePair {
    if SELF && a > b { TrianglePair { a: b, b: a } } else { TrianglePair { a, b } }
}
