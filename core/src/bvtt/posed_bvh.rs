//! A BVH in a pose: one side of a query.

use super::in_f64::{F64, Posed64, Side, check, place};
use crate::aabb::Bounds;
use crate::bvh::Layout;
use crate::pose::{Affine, Pose64, PoseError};
use crate::{Aabb, Bvh, Node, Pose, Triangle};
use glam::{DVec3, Vec3A};

/// A BVH in a pose, one side of a [`PairBvtt`](super::PairBvtt). Copying is free.
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
/// assert_eq!(PairBvtt::in_world(here, there).count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PosedBvh<'a, L: Layout = Node> {
    pub(super) bvh: Bvh<'a, L>,
    /// The pose of the corners; `None` is the identity. If there is another in f64, that of the shadow.
    pub(super) pose: Option<Affine>,
    /// If the mesh or the pose is in f64, or the other one of a query.
    pub(super) exact: Option<Posed64>,
}

impl<'a, L: Layout> PosedBvh<'a, L> {
    /// Poses a BVH. [`Pose::IDENTITY`] leaves every vertex as it is and costs a query nothing.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes the mesh out of range.
    pub fn new(bvh: Bvh<'a, L>, world_from_bvh: &Pose) -> Result<Self, PoseError> {
        match bvh.mesh().f64() {
            None if *world_from_bvh == Pose::IDENTITY => {}
            None => world_from_bvh.check(&bvh.aabb().unwrap_or(Aabb::EMPTY))?,
            Some(f64) => (f64.check)(bvh.mesh(), &root_bounds(&bvh), world_from_bvh)?,
        }
        Ok(Self::new_unchecked(bvh, world_from_bvh))
    }

    /// Poses a BVH as [`PosedBvh::new`] or [`Pose::check`] has accepted it. In a pose that they refuse a query may
    /// miss pairs.
    #[must_use]
    pub fn new_unchecked(bvh: Bvh<'a, L>, world_from_bvh: &Pose) -> Self {
        let (mut new, bounds) = (Self::unposed(bvh), root_bounds(&bvh));
        match bvh.mesh().f64() {
            None => new.pose = Affine::new(world_from_bvh, &bounds),
            Some(f64) => (f64.pose)(new.side(&bounds), world_from_bvh),
        }
        new
    }

    /// Poses a BVH in f64, in which its query is then asked, whatever the other side.
    ///
    /// # Errors
    /// As [`PosedBvh::new`].
    pub fn in_f64(bvh: Bvh<'a, L>, world_from_bvh: &Pose64) -> Result<Self, PoseError> {
        check(bvh.mesh(), &root_bounds(&bvh), world_from_bvh)?;
        Ok(Self::in_f64_unchecked(bvh, world_from_bvh))
    }

    /// Poses a BVH as [`PosedBvh::in_f64`] has accepted it.
    #[must_use]
    pub fn in_f64_unchecked(bvh: Bvh<'a, L>, world_from_bvh: &Pose64) -> Self {
        let mut new = Self::unposed(bvh);
        place(new.side(&root_bounds(&bvh)), *world_from_bvh, DVec3::ZERO);
        new
    }

    pub(super) fn unposed(bvh: Bvh<'a, L>) -> Self {
        Self { bvh, pose: None, exact: None }
    }

    /// The functions that a query in f64 calls, if the mesh or the pose is in f64.
    pub(super) fn f64(&self) -> Option<&'static F64> {
        self.exact.as_ref().map(|exact| exact.f64).or(self.bvh.mesh().f64())
    }

    /// This side of a query in f64, given the bounds of its shadow.
    pub(super) fn side<'s>(&'s mut self, bounds: &'s Bounds) -> Side<'s> {
        let Self { bvh, pose, exact } = self;
        Side { mesh: &bvh.mesh, bounds, pose, exact }
    }

    /// A box that contains every posed vertex of every triangle, rounding included; `None` for an
    /// empty mesh. For broad phases.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        Some(self.bounds(self.bvh.root()?).into())
    }

    /// A box that contains the posed triangles below a node.
    #[inline(always)]
    pub(super) fn bounds(&self, node: &L) -> Bounds {
        posed(self.pose.as_ref(), &self.bvh.bounds(node))
    }

    /// The posed corners of a triangle.
    pub(super) fn triangle(&self, triangle: u32) -> Triangle {
        let corners = self.bvh.mesh().shadow_triangle(triangle);
        let Some(pose) = self.pose else { return corners };
        corners.map(|p| pose.point(Vec3A::from_array(p)).to_array())
    }
}

pub(super) fn root_bounds<L: Layout>(bvh: &Bvh<'_, L>) -> Bounds {
    bvh.root().map_or(Bounds::EMPTY, |root| bvh.bounds(root))
}

/// A box that contains posed `bounds`.
pub(super) fn posed(pose: Option<&Affine>, bounds: &Bounds) -> Bounds {
    pose.map_or(*bounds, |pose| pose.bounds(bounds))
}
