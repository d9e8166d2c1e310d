//! A BVH in a pose: one side of a query.

use crate::aabb::Bounds;
use crate::bvh::Layout;
use crate::pose::{Affine, PoseError};
use crate::{Aabb, Bvh, Node, Pose, Triangle};
use glam::Vec3A;

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
    /// The pose of the corners; `None` is the identity.
    pub(super) pose: Option<Affine>,
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
        Some(self.bounds(self.bvh.root()?).into())
    }

    /// A box that contains the posed triangles below a node.
    #[inline(always)]
    pub(super) fn bounds(&self, node: &L) -> Bounds {
        posed(self.pose.as_ref(), &self.bvh.bounds(node))
    }

    /// The posed corners of a triangle.
    pub(super) fn triangle(&self, triangle: u32) -> Triangle {
        let corners = self.bvh.mesh().triangle(triangle);
        let Some(pose) = self.pose else { return corners };
        corners.map(|p| pose.point(Vec3A::from_array(p)).to_array())
    }
}

/// A box that contains posed `bounds`.
pub(super) fn posed(pose: Option<&Affine>, bounds: &Bounds) -> Bounds {
    pose.map_or(*bounds, |pose| pose.bounds(bounds))
}
