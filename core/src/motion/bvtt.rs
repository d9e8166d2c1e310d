//! The BVTT of two moving meshes, or of one and itself.

use super::MovingBvh;
use super::adjacency::{are_certainly_apart, impact_in_mesh};
use super::common_time::first_overlap;
use super::impact::{Impact, impact_in_steps, impact_of, impact_within};
use super::leaf::Leaf;
use super::pair::MovingPair;
#[cfg(feature = "within")]
use crate::Distance;
use crate::bvtt::{Bvtt, NodePair, PairBvtt, SelfBvtt, TrianglePair};
use crate::triangle::Adjacency;

/// Two meshes that move, or with `SELF` one and itself: its verbs tell which triangles meet on the way, and when first.
///
/// Nodes are compared at a common time: see the boxes of [`motion`](super).
#[derive(Clone, Copy, Debug)]
pub struct MovingBvtt<'a, const SELF: bool> {
    pub(super) start: Bvtt<'a, SELF>,
    pub(super) end: Bvtt<'a, SELF>,
}

/// Two triangles that meet, and when.
pub(super) type Hit = (TrianglePair, Impact);

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
        let query = |a, b| PairBvtt::in_world(a, b).in_own_frame().with_boxes_of_corners();
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
    /// assert_eq!(query.count(), [1, 1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn moving(motion: MovingBvh<'a>) -> MovingBvtt<'a, true> {
        let query =
            |side: crate::bvtt::PosedBvh<'a>| SelfBvtt::new(side.bvh).with_boxes_of_corners();
        MovingBvtt { start: query(motion.start), end: query(motion.end) }
    }
}

#[cfg(feature = "within")]
impl<'a> MovingBvtt<'a, false> {
    /// Asks for pairs of triangles that come within a distance while they move, in place of those that meet, as
    /// [`PairBvtt::within`] does at rest; 0 asks for those that meet again.
    ///
    /// Pairs that are not reported are farther apart all the time. The impact of one that is tells when it is within the distance, and is open
    /// where it comes as near as rounding takes and no nearer: integers decide only at the start and at the end.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, motion::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let at = |z| PosedBvh::new(bvh, &Pose::from_translation([0.0, 0.0, z]));
    /// let (rest, falling) = (MovingBvh::new(at(0.0)?, at(0.0)?)?, MovingBvh::new(at(1.0)?, at(0.25)?)?);
    /// let query = PairBvtt::moving(rest, falling);
    /// assert!(query.first_impact().is_none() && query.within(Distance::new(0.2)?).first_impact().is_none());
    /// let (_, impact) = query.within(Distance::new(0.625)?).first_impact().expect("it comes within it");
    /// assert!(impact.from <= 0.5 && 0.5 <= impact.to && impact.to < 0.500001);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn within(self, distance: Distance) -> Self {
        let end = |query: Bvtt<'a, false>| match distance.get() > 0.0 {
            true => query.within(distance).with_boxes_of_corners(),
            false => query.in_own_frame().with_boxes_of_corners(),
        };
        Self { start: end(self.start), end: end(self.end) }
    }
}

#[cfg(feature = "within")]
impl MovingBvtt<'_, true> {
    /// Asks for pairs that come within a distance while they move, as that of two meshes does. Triangles that share a vertex are decided by the rule
    /// for neighbours, whatever the distance.
    #[must_use]
    pub fn within(self, distance: Distance) -> Self {
        let [start, end] =
            [self.start, self.end].map(|query| query.within(distance).with_boxes_of_corners());
        Self { start, end }
    }
}

impl MovingBvtt<'_, true> {
    /// The same with another rule for neighbours.
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        let [start, end] = [self.start, self.end].map(|query| query.with_adjacency(adjacency));
        Self { start, end }
    }

    /// Asks for all pairs of triangles whose boxes overlap at a time, neighbours included, as [`SelfBvtt::boxes_only`] does for a mesh at rest:
    /// the broad phase of boxes that move. The impact of a pair begins with the first such time, and is open.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, motion::*, *};
    /// // A box at rest, and two that move, of which one passes it by.
    /// let start = [[0.0; 3], [1.0; 3], [3.0, 0.0, 0.0], [4.0, 1.0, 1.0], [0.0, 9.0, 0.0], [1.0, 10.0, 1.0]];
    /// let end = [[0.0; 3], [1.0; 3], [-1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [9.0, 0.0, 0.0], [10.0, 1.0, 1.0]];
    /// let boxes = Mesh::new(&start, &[[0, 1, 1], [2, 3, 3], [4, 5, 5]])?;
    /// # let root = |max| [Node { min: [-1.0, 0.0, 0.0], first: 0, max, count: 3 }];
    /// # let roots = [root([4.0, 10.0, 1.0]), root([10.0, 1.0, 1.0])];
    /// # let at_start = Bvh::new_unchecked(boxes, &roots[0], &[0, 1, 2]);
    /// # let at_end = Bvh::new_unchecked(boxes.with_positions(&end)?, &roots[1], &[0, 1, 2]);
    /// let side = |bvh| PosedBvh::new(bvh, &Pose::IDENTITY);
    /// let query = SelfBvtt::moving(MovingBvh::new(side(at_start)?, side(at_end)?)?).boxes_only();
    /// let (pair, impact) = query.first_impact().expect("two meet");
    /// assert_eq!((query.count(), pair), ([0, 1], TrianglePair { a: 0, b: 1 }));
    /// assert!(impact.from <= 0.5 && 0.499 < impact.from && !impact.is_proven());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn boxes_only(self) -> Self {
        Self { start: self.start.boxes_only(), end: self.end.boxes_only() }
    }
}

impl<const SELF: bool> MovingBvtt<'_, SELF> {
    /// The root, if its boxes overlap at a time.
    #[must_use]
    pub fn root(&self) -> Option<NodePair> {
        self.first_overlap().map(|_| NodePair::ROOT)
    }

    /// The first time at which the boxes of the root overlap, or a little earlier: no pair of triangles has an impact that begins before it.
    #[must_use]
    pub fn first_overlap(&self) -> Option<f64> {
        let time = self.start.has_roots().then(|| self.overlap_of(NodePair::ROOT)).flatten()?;
        Some(before(time))
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

    pub(super) fn leaves(&self, TrianglePair { a, b }: TrianglePair) -> [Leaf; 2] {
        let ends = [&self.start, &self.end];
        [Leaf::of(a, 0, ends), Leaf::of(b, 1, ends)]
    }

    /// When two triangles meet first whose boxes overlap first at a time.
    #[inline(always)]
    pub(super) fn impact_of(
        &self,
        pair: TrianglePair,
        [p, q]: [&Leaf; 2],
        first: f64,
    ) -> Option<Impact> {
        if self.start.is_boxes_only() {
            return Some(Impact { from: first, to: f64::INFINITY });
        }
        let found = match self.indices(pair).filter(|&indices| share_a_vertex(indices)) {
            None if self.start.reach().is_some() => {
                impact_within(&p.corners, &q.corners, self.start.reach().unwrap_or_default())
            }
            // Lanes have tried what separates most pairs.
            None if self.distance_of_lanes().is_some() => {
                let moving = MovingPair::new(&p.corners, &q.corners, 0.0);
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

    /// How far boxes in lanes have to reach beyond corners at the start and at the end, for their errors if an end is in f64, and for a distance.
    #[inline(always)]
    pub(super) fn growth(&self) -> Option<[[f32; 3]; 2]> {
        let ends = [&self.start, &self.end];
        if self.start.reach().is_some() {
            return Some(ends.map(Bvtt::growth_of_second));
        }
        match ends.map(Bvtt::error_of_lanes) {
            [None, None] => None,
            errors => Some(errors.map(Option::unwrap_or_default)),
        }
    }

    /// The distance for which lanes compare triangles; none if they compare boxes only, as those of shadows.
    #[inline(always)]
    pub(super) fn distance_of_lanes(&self) -> Option<f32> {
        let is_shadow = [&self.start, &self.end].map(|end| end.error_of_lanes().is_some());
        let compares = is_shadow == [false; 2] && !self.start.is_boxes_only();
        compares.then(|| self.start.reach().unwrap_or_default())
    }

    /// The vertices of two triangles of one mesh.
    #[inline(always)]
    fn indices(&self, pair: TrianglePair) -> Option<[&[u32; 3]; 2]> {
        let triangles = self.start.mesh_of(0).triangles();
        SELF.then(|| [&triangles[pair.a as usize], &triangles[pair.b as usize]])
    }

    /// The first time at which the boxes of both nodes overlap.
    #[inline]
    fn overlap_of(&self, n: NodePair) -> Option<f64> {
        first_overlap(&self.start.bounds(n), &self.end.bounds(n))
    }

    /// Passes on the children of a node pair that overlap at a time, and the first. Returns the number of box tests.
    #[inline]
    pub(super) fn descend(&self, n: NodePair, mut push: impl FnMut(NodePair, f64)) -> u32 {
        let mut tests = 0;
        self.start.each_child(n, |child| {
            if SELF && child.a == child.b {
                push(child, 0.0);
                return;
            }
            tests += 1;
            if let Some(time) = self.overlap_of(child) {
                push(child, time);
            }
        });
        tests
    }
}

/// A time before which no triangles below two nodes meet whose boxes overlap first at `time`: that of two triangles may be computed to be a
/// little earlier.
#[inline(always)]
pub(super) fn before(time: f64) -> f64 {
    (time - 1.0 / 281_474_976_710_656.0).max(0.0)
}

/// The first time at which the boxes of two triangles overlap.
#[inline]
pub(super) fn first_overlap_of([p, q]: [&Leaf; 2]) -> Option<f64> {
    first_overlap(&[p.boxes[0], q.boxes[0]], &[p.boxes[1], q.boxes[1]])
}

/// Whether two triangles have a vertex in common, by index.
#[inline(always)]
fn share_a_vertex([&[p, q, r], other]: [&[u32; 3]; 2]) -> bool {
    // All at once: nine comparisons are cheaper than a jump that may be mispredicted.
    other.iter().fold(false, |shared, &v| shared | (v == p) | (v == q) | (v == r))
}

/// A pair of one mesh in ascending order.
pub(super) fn ordered<const SELF: bool>(TrianglePair { a, b }: TrianglePair) -> TrianglePair {
    if SELF && a > b { TrianglePair { a: b, b: a } } else { TrianglePair { a, b } }
}
