//! Two meshes, one or both of them posed, or one mesh with itself.
//!
//! The self-collision of a mesh is a query about the mesh and itself in which each unordered pair of triangles counts
//! once: the node pair (n, n) has the children (l, l), (l, r) and (r, r), and a pair of different nodes branches as that
//! of two meshes does. Boxes of triangles that share a vertex overlap, so the traversal reaches all of these pairs; what
//! they share by index is left to [`Adjacency`], in the leaves.

use super::posed_bvh::{posed, root_bounds};
use super::{NodePair, PosedBvh, TrianglePair};
#[cfg(feature = "within")]
use crate::Distance;
use crate::aabb::Bounds;
use crate::one_ring::{Certified, OneRing, hub_of, is_marked};
use crate::pose::{Affine, Pose64, PoseError};
use crate::scalar::{IN_F64, WITHIN};
use crate::simd::VECTORS;
use crate::triangle::{Adjacency, Contact, intersects, intersects_in_f64, posed_contact};
use crate::{Bvh, Pose};
use glam::{DVec3, Vec3A};

/// Two meshes in one frame: that of the first ([`PairBvtt::new`]), or a world in which both are posed
/// ([`PairBvtt::in_world`]). The choice changes how vertices are rounded, and so which pairs intersect.
///
/// # Examples
/// ```
/// use pfront_core::{bvh::{self, *}, bvtt::*, *};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(1)], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let mut scratch = [0; 2];
/// let bvh = bvh::morton(mesh, &BuildOptions::default(), storage, &mut scratch)?;
/// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.5, 0.0, 0.0]))?;
/// assert_eq!(query.any(), Some(TrianglePair { a: 0, b: 0 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type PairBvtt<'a> = Bvtt<'a, false>;

/// One mesh against itself, each unordered pair of triangles once.
pub type SelfBvtt<'a> = Bvtt<'a, true>;

/// A [`PairBvtt`], or with `SELF` a [`SelfBvtt`].
#[derive(Clone, Copy, Debug)]
pub struct Bvtt<'a, const SELF: bool> {
    pub(super) a: PosedBvh<'a>,
    pub(super) b: PosedBvh<'a>,
    /// The poses in which the boxes of each side are compared. The box of a rotated box is larger, so the boxes of
    /// the second of two posed meshes are taken to the frame of the first where possible. Hits depend on corners alone.
    pub(super) box_poses: [Option<Affine>; 2],
    /// The pose of the first mesh as the second sees it, if one is turned against the other: boxes that overlap in the one
    /// frame are often apart in the other. These are the face axes of both boxes in the test of Gottschalk et al.
    /// (*OBBTree*, 1996). Without vectors, to pose a box takes as long as it saves.
    pub(super) first_seen: Option<Affine>,
    pub(super) adjacency: Adjacency,
    pub(super) rings: &'a [OneRing],
    /// Marks of the nodes below which all triangles share a vertex: see [`crate::one_ring`].
    fans: &'a [u32],
    pub(super) boxes_only: bool,
    error: Option<Vec3A>,
    /// Pairs at most so far apart are hits; 0 asks for those that intersect.
    distance: f32,
    /// Computed once, as fronts ask for it often, like `leaf_edge`.
    pub(super) root: Option<NodePair>,
    pub(super) leaf_edge: f32,
}

/// The vertices around which no two triangles of a mesh are a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shared<'a> {
    /// All of them.
    pub(super) none_is_hit: bool,
    pub(super) rings: &'a [OneRing],
}

impl Shared<'_> {
    #[inline(always)]
    pub(super) fn is_certified(self, vertex: u32) -> bool {
        self.none_is_hit || self.has_certified_ring(vertex)
    }

    #[inline(always)]
    pub(super) fn has_certified_ring(self, vertex: u32) -> bool {
        self.rings.get(vertex as usize).is_some_and(|ring| ring.is_certified())
    }
}

/// The shadows of two meshes as a query in f64 poses them, for a device that poses them by itself: both into the frame whose
/// origin is that of the first shadow as it is posed. See `PairBvtt::shadows`.
#[cfg(feature = "f64")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadows {
    /// The poses of both.
    pub poses: [Pose; 2],
    /// How far a corner of each, as [`Pose::apply`] poses it, may be from what it stands for, on each axis.
    pub padding: [[f32; 3]; 2],
    /// How far the difference of two coordinates of such corners may be from that of what they stand for.
    pub error: [f32; 3],
}

impl<'a> PairBvtt<'a> {
    /// Asks for `a` against `b` posed by `a_from_b`, exactly. If one of the three is in f64, positions are posed and pairs
    /// decided there.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes `b` out of range.
    pub fn new(a: Bvh<'a>, b: Bvh<'a>, a_from_b: Pose) -> Result<Self, PoseError> {
        Ok(Self::in_world(PosedBvh::unposed(a), PosedBvh::new(b, &a_from_b)?))
    }

    /// [`PairBvtt::new`] with a pose in f64.
    ///
    /// # Errors
    /// As [`PairBvtt::new`].
    #[cfg(feature = "f64")]
    pub fn in_f64(a: Bvh<'a>, b: Bvh<'a>, a_from_b: &Pose64) -> Result<Self, PoseError> {
        Ok(Self::in_world(PosedBvh::unposed(a), PosedBvh::in_f64(b, a_from_b)?))
    }

    /// Asks for two meshes that are both posed into a third frame, exactly.
    #[must_use]
    pub fn in_world(a: PosedBvh<'a>, b: PosedBvh<'a>) -> Self {
        Self::in_frame(a, b, None)
    }

    /// Asks for all pairs at most `distance` apart in the frame of the query, in place of those that intersect: exactly, and 0 asks
    /// for those again.
    ///
    /// The boxes of the second mesh are compared grown by the distance. Triangle pairs are decided eight at a time where f32
    /// certifies them, and by integers else.
    ///
    /// # Complexity
    /// As without, with as many more pairs as there are boxes that overlap when they are grown.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.0, 0.0, 0.25]))?;
    /// assert_eq!(query.within(Distance::new(0.25)?).count(), 1);
    /// assert_eq!(query.within(Distance::new(0.2)?).count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "within")]
    #[must_use]
    pub fn within(self, distance: Distance) -> Self {
        let is_asked = self.distance == distance.get();
        let distance = (distance.get() > 0.0).then_some(distance.get());
        if is_asked { self } else { Self::in_frame(self.a, self.b, distance) }
    }

    /// The same with boxes that stand in the frame of the query, where distances are and motions go in straight lines.
    #[cfg(any(feature = "within", feature = "motion"))]
    pub(crate) fn in_own_frame(&self) -> Self {
        Self::in_frame(self.a, self.b, Some(0.0))
    }

    /// Compares boxes in the frame that suits them, or in that of the query and grown by a distance.
    fn in_frame(a: PosedBvh<'a>, b: PosedBvh<'a>, within: Option<f32>) -> Self {
        let mut query = Self { distance: within.unwrap_or(0.0), ..Self::of_sides(a, b) };
        let (Some(root_a), Some(root_b)) = (a.bvh.root(), b.bvh.root()) else { return query };
        let (of_a, of_b) = (root_a.bounds(), root_b.bounds());
        if a.is_f64() || b.is_f64() {
            let poses = query.pose_shadows();
            query.box_poses = poses.map(Some);
            // Boxes need all of the paddings, corners no more than 13/16 of each.
            query.error = Some(poses[0].padding().max(poses[1].padding()) * 1.75);
        }
        match within {
            None => into_frame_of_first(&mut query.box_poses, &of_b),
            Some(distance) if distance > 0.0 => grow(&mut query.box_poses, &of_b, distance),
            Some(_) => {}
        }
        if VECTORS && let Some(pose_b) = &query.b.pose {
            let pose_a = query.a.pose.unwrap_or_else(|| Affine::identity(&of_a));
            query.first_seen = pose_a.seen_from(&of_a, pose_b).filter(Affine::is_turned);
            if let Some(distance) = query.reach() {
                let growth = pose_b.growth_in_own_frame(distance);
                query.first_seen = query.first_seen.map(|seen| seen.grown(growth));
            }
            if pose_a.moves_nothing() {
                query.a.pose = None;
            }
        }
        let [own, other] = query.bounds(NodePair::ROOT);
        query.root = own.overlaps(&other).then_some(NodePair::ROOT);
        query
    }

    /// Poses both shadows in the frame whose origin is that of the first as it is posed. Returns their poses.
    fn pose_shadows(&mut self) -> [Affine; 2] {
        let (pose_a, pose_b) = (self.a.as_pose64(), self.b.as_pose64());
        let zero = DVec3::from_array(pose_a.apply(self.a.bvh.mesh().origin()));
        [self.a.pose_shadow(pose_a, zero), self.b.pose_shadow(pose_b, zero)]
    }

    /// The shadows of both meshes, and their error, if the query is in f64.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::in_f64(bvh, bvh, &Pose64::from_translation([0.1, 0.0, 0.0]))?;
    /// let shadows = query.shadows().expect("it is in f64");
    /// assert_eq!(shadows.poses[1].apply([0.0; 3]), [0.1, 0.0, 0.0]);
    /// assert!(shadows.error[0] > 0.0 && shadows.error[0] < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "f64")]
    #[must_use]
    pub fn shadows(&self) -> Option<Shadows> {
        let (error, mut posed) = (self.error()?.to_array(), *self);
        let poses = posed.pose_shadows();
        let padding = poses.map(|pose| pose.padding().to_array());
        Some(Shadows { poses: poses.map(Affine::to_pose), padding, error })
    }

    /// Whether two triangles meet, or are within the distance that is asked for, exactly.
    ///
    /// # Panics
    /// If an index is out of range.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.0, 0.0, 1e-45]))?;
    /// assert!(!query.intersects(TrianglePair { a: 0, b: 0 }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn intersects(&self, pair: TrianglePair) -> bool {
        #[cfg(feature = "within")]
        if let Some(distance) = self.reach() {
            return self.are_within(pair, distance);
        }
        match self.error() {
            None => intersects(&self.a.triangle(pair.a), &self.b.triangle(pair.b)),
            Some(_) => {
                intersects_in_f64(&self.a.triangle_f64(pair.a), &self.b.triangle_f64(pair.b))
            }
        }
    }
}

/// Grows the boxes of the second side, whose bounds these are, by a distance.
fn grow(poses: &mut [Option<Affine>; 2], of_b: &Bounds, distance: f32) {
    let [_, pose_b] = poses;
    let unposed = || Affine::identity(of_b);
    *pose_b = Some(pose_b.unwrap_or_else(unposed).grown(Vec3A::splat(distance)));
}

/// Replaces the poses of boxes by that of the second mesh as the first sees it, where possible.
#[inline]
pub(super) fn into_frame_of_first(poses: &mut [Option<Affine>; 2], of_b: &Bounds) {
    if let [Some(pose_a), Some(pose_b)] = poses
        && let Some(seen) = pose_b.seen_from(of_b, pose_a)
    {
        *poses = [None, Some(seen)];
    }
}

impl<'a> SelfBvtt<'a> {
    /// Asks for all pairs under the shared-index rule, exactly.
    #[must_use]
    pub fn new(bvh: Bvh<'a>) -> Self {
        let side = PosedBvh::unposed(bvh);
        let query = Self { root: bvh.root().map(|_| NodePair::ROOT), ..Self::of_sides(side, side) };
        if !bvh.mesh().is_f64() {
            return query;
        }
        let shadow = Affine::identity(&root_bounds(&bvh));
        // Nothing is posed, so that corners are off by a sixteenth of the padding each.
        let error = Some(shadow.padding() * 0.25);
        Self { error, box_poses: [Some(shadow); 2], ..query }
    }

    /// Asks for all pairs at most `distance` apart, as [`PairBvtt::within`] does. Triangles that share a vertex are decided by
    /// the rule for neighbours, whatever the distance; all others by their distance, so that neighbours of neighbours are hits
    /// from an edge's length on. With [`SelfBvtt::boxes_only`], the boxes of two triangles have to be as near on each axis.
    ///
    /// # Complexity
    /// As that of [`PairBvtt::within`].
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2], [3, 4, 5]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.5], count: 2 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0, 1]);
    /// // Two triangles, one 0.5 above the other.
    /// let query = SelfBvtt::new(bvh);
    /// assert_eq!((query.count(), query.within(Distance::new(0.5)?).count()), (0, 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "within")]
    #[must_use]
    pub fn within(self, distance: Distance) -> Self {
        let (bvh, distance) = (self.a.bvh, distance.get());
        let mut box_poses = Self::new(bvh).box_poses;
        if distance > 0.0 {
            grow(&mut box_poses, &root_bounds(&bvh), distance);
        }
        Self { box_poses, distance, ..self }
    }

    /// The same with another rule for neighbours.
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        Self { adjacency, ..self }
    }

    /// Where two triangles of the mesh meet, told of the posed mesh: the segment is posed, and the normals are those
    /// of the posed triangles. The pose decides nothing, so that a body that moves keeps the contacts with itself.
    ///
    /// # Panics
    /// If an index is out of range.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// let points = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.5, 0.0], [1.0, 1.0, 1.0], [1.0; 3]];
    /// let mesh = Mesh::new(&points, &[[0, 1, 2], [3, 4, 5]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [2.0, 2.0, 1.0], count: 2 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0, 1]);
    /// let up = Pose64::from_translation([0.0, 0.0, 7.0]);
    /// let contact = SelfBvtt::new(bvh).posed_contact(TrianglePair { a: 0, b: 1 }, &up);
    /// assert_eq!(contact.map(|contact| contact.segment), Some([[0.5, 0.5, 7.0]; 2]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn posed_contact(&self, pair: TrianglePair, pose: &Pose64) -> Option<Contact<f64>> {
        let [a, b] = [pair.a, pair.b].map(|triangle| self.a.bvh.mesh().triangle_f64(triangle));
        posed_contact(&a, &b, pose)
    }

    /// The true pairs, found sooner where many vertices are certified: see [`one_ring`](crate::one_ring).
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
    /// let (mut history, mut scratch) = ([0; history_bound(3)], [0; link_scratch_bound(3, 1)]);
    /// let mut rings = OneRings::new(3, &triangles, &mut history, &mut scratch)?;
    /// let certified = rings.certify(mesh, None);
    /// assert_eq!(SelfBvtt::new(bvh).with_certificates(certified).count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_certificates(self, certified: Certified<'a>) -> Self {
        let (rings, fans) = (certified.of_mesh(self.a.bvh.mesh()), certified.fans_of(&self.a.bvh));
        Self { rings, fans: if self.boxes_only { &[] } else { fans }, ..self }
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
    /// let query = SelfBvtt::new(bvh).boxes_only();
    /// assert_eq!((query.count(), query.any()), (1, Some(TrianglePair { a: 0, b: 1 })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn boxes_only(self) -> Self {
        Self { boxes_only: true, fans: &[], ..self }
    }
}

impl<'a, const SELF: bool> Bvtt<'a, SELF> {
    /// A query without a root.
    fn of_sides(a: PosedBvh<'a>, b: PosedBvh<'a>) -> Self {
        Self {
            a,
            b,
            box_poses: [a.pose, b.pose],
            first_seen: None,
            adjacency: Adjacency::SharedIndexRule,
            rings: &[],
            fans: &[],
            boxes_only: false,
            error: None,
            distance: 0.0,
            root: None,
            leaf_edge: a.bvh.leaf_edge().max(b.bvh.leaf_edge()),
        }
    }

    /// The distance within which pairs are hits, if that is what is asked.
    #[inline(always)]
    pub(crate) fn reach(&self) -> Option<f32> {
        if WITHIN && self.distance > 0.0 { Some(self.distance) } else { None }
    }

    /// If positions or poses in f64 decide: how far the difference of two coordinates in lanes may be from that of the positions
    /// posed in f64.
    #[inline(always)]
    pub(super) fn error(&self) -> Option<Vec3A> {
        if IN_F64 { self.error } else { None }
    }

    /// Whether all triangles below both nodes share a certified vertex, so that no two of them are a hit.
    #[inline(always)]
    pub(super) fn is_in_certified_fan(&self, n: NodePair) -> bool {
        let is_marked = |node| is_marked(self.fans, node);
        SELF && !self.fans.is_empty()
            && is_marked(n.a)
            && is_marked(n.b)
            && self.share_certified_hub(n)
    }

    /// Whether the triangles below two nodes, of which each has one hub, have the same, and it is certified.
    #[cold]
    fn share_certified_hub(&self, n: NodePair) -> bool {
        let [a, b] = [n.a, n.b].map(|node| hub_of(&self.a.bvh, self.rings, node));
        a == b && a.is_some_and(|hub| self.shared().is_certified(hub))
    }

    /// The vertices of one mesh around which no two triangles are a hit.
    #[inline(always)]
    pub(super) fn shared(&self) -> Shared<'a> {
        Shared { none_is_hit: self.adjacency == Adjacency::SkipNeighbours, rings: self.rings }
    }

    /// The boxes of both nodes in the frame in which all boxes are compared.
    pub(crate) fn bounds(&self, n: NodePair) -> [Bounds; 2] {
        let Self { a, b, box_poses: [pose_a, pose_b], .. } = self;
        [
            posed(pose_a.as_ref(), &a.bvh.node(n.a).bounds()),
            posed(pose_b.as_ref(), &b.bvh.node(n.b).bounds()),
        ]
    }
}
