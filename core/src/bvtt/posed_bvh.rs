//! A BVH in a pose: one side of a query.

use crate::aabb::Bounds;
use crate::pose::{Affine, Pose64, PoseError};
use crate::scalar::IN_F64;
#[cfg(feature = "relation")]
use crate::scalar::Scalar;
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
pub struct PosedBvh<'a> {
    pub(crate) bvh: Bvh<'a>,
    /// The pose of the corners; `None` is the identity. If there is another in f64, that of the shadow.
    pub(super) pose: Option<Affine>,
    /// The pose of the positions in f64, if the mesh or the pose is in f64, or the other side of a query.
    pub(super) pose_f64: Option<Pose64>,
}

impl<'a> PosedBvh<'a> {
    /// Poses a BVH. [`Pose::IDENTITY`] leaves every vertex as it is and costs a query nothing.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes the mesh out of range.
    pub fn new(bvh: Bvh<'a>, world_from_bvh: &Pose) -> Result<Self, PoseError> {
        if bvh.mesh().is_f64() {
            check(&bvh, &(*world_from_bvh).into())?;
        } else if *world_from_bvh != Pose::IDENTITY {
            world_from_bvh.check(&bvh.aabb().unwrap_or(Aabb::EMPTY))?;
        }
        Ok(Self::new_unchecked(bvh, world_from_bvh))
    }

    /// Poses a BVH as [`PosedBvh::new`] or [`Pose::check`] has accepted it. In a pose that they refuse a query may
    /// miss pairs.
    #[must_use]
    pub fn new_unchecked(bvh: Bvh<'a>, world_from_bvh: &Pose) -> Self {
        let mut new = Self::unposed(bvh);
        if bvh.mesh().is_f64() {
            new.pose_shadow((*world_from_bvh).into(), DVec3::ZERO);
        } else {
            new.pose = Affine::new(world_from_bvh, &root_bounds(&bvh));
        }
        new
    }

    /// Poses a BVH in f64, in which its query is then asked, whatever the other side.
    ///
    /// # Errors
    /// As [`PosedBvh::new`].
    #[cfg(feature = "f64")]
    pub fn in_f64(bvh: Bvh<'a>, world_from_bvh: &Pose64) -> Result<Self, PoseError> {
        check(&bvh, world_from_bvh)?;
        Ok(Self::in_f64_unchecked(bvh, world_from_bvh))
    }

    /// Poses a BVH as [`PosedBvh::in_f64`] has accepted it.
    #[cfg(feature = "f64")]
    #[must_use]
    pub fn in_f64_unchecked(bvh: Bvh<'a>, world_from_bvh: &Pose64) -> Self {
        let mut new = Self::unposed(bvh);
        new.pose_shadow(*world_from_bvh, DVec3::ZERO);
        new
    }

    pub(crate) fn unposed(bvh: Bvh<'a>) -> Self {
        Self { bvh, pose: None, pose_f64: None }
    }

    /// Whether the mesh or the pose is in f64.
    pub(super) fn is_f64(&self) -> bool {
        IN_F64 && (self.pose_f64.is_some() || self.bvh.mesh().is_f64())
    }

    /// The pose in f64, the same if it is given in f32.
    pub(crate) fn as_pose64(&self) -> Pose64 {
        let in_f32 = || self.pose.map_or(Pose::IDENTITY, Affine::to_pose);
        self.pose_f64.unwrap_or_else(|| in_f32().into())
    }

    /// Poses positions, and their shadow in a frame whose origin is at `zero`. Returns the pose of the shadow.
    pub(super) fn pose_shadow(&mut self, pose: Pose64, zero: DVec3) -> Affine {
        let origin = DVec3::from_array(self.bvh.mesh().origin());
        let shadow = Affine::of_shadow(&pose, origin, &root_bounds(&self.bvh), zero);
        (self.pose, self.pose_f64) = (Some(shadow), Some(pose));
        shadow
    }

    /// A box that contains every posed vertex of every triangle, rounding included; `None` for an
    /// empty mesh. For broad phases.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        Some(self.bounds(self.bvh.root()?).into())
    }

    /// A box that contains the posed triangles below a node.
    #[inline(always)]
    pub(super) fn bounds(&self, node: &Node) -> Bounds {
        posed(self.pose.as_ref(), &node.bounds())
    }

    /// The posed corners of a triangle.
    pub(crate) fn triangle(&self, triangle: u32) -> Triangle {
        let corners = self.bvh.mesh().shadow_triangle(triangle);
        let Some(pose) = self.pose else { return corners };
        corners.map(|p| pose.point(Vec3A::from_array(p)).to_array())
    }

    /// The corners of a triangle as they are posed in f64.
    pub(crate) fn triangle_f64(&self, triangle: u32) -> [[f64; 3]; 3] {
        let corners = self.bvh.mesh().triangle_f64(triangle);
        self.pose_f64.map_or(corners, |pose| corners.map(|p| pose.apply(p)))
    }
}

/// Whether the sum of two numbers takes no rounding: it leads back to both (Dekker 1971).
#[cfg(feature = "relation")]
fn sums_exactly<C: Scalar>(p: &[C; 3], t: &[f64; 3], sum: &[C; 3]) -> bool {
    // Sums of f32 are exact in f64 or far from their roundings.
    (0..3).all(|k| {
        let (x, sum): (f64, f64) = (p[k].into(), sum[k].into());
        sum - x == t[k] && sum - t[k] == x
    })
}

#[cfg(feature = "relation")]
impl PosedBvh<'_> {
    /// Whether it is not posed at all.
    pub(crate) fn is_unposed(&self) -> bool {
        self.pose.is_none() || self.pose_f64.is_some_and(|pose| pose == Pose64::IDENTITY)
    }

    /// Whether the pose only translates, and rounds no position: O(vertices).
    #[inline(never)]
    pub(crate) fn is_exact(&self) -> bool {
        let mesh = self.bvh.mesh();
        let pose = self.as_pose64();
        let translation = pose.rows.map(|row| row[3]);
        if pose != Pose64::from_translation(translation) {
            return false;
        }
        match self.pose_f64 {
            Some(_) => (0..mesh.vertex_count() as u32).all(|vertex| {
                let p = mesh.position_f64(vertex);
                sums_exactly(&p, &translation, &pose.apply(p))
            }),
            None => {
                let Some(pose) = self.pose else { return true };
                mesh.shadow().iter().all(|p| {
                    let sum = pose.point(Vec3A::from_array(*p)).to_array();
                    sums_exactly(p, &translation, &sum)
                })
            }
        }
    }
}

/// Checks that a pose in f64 is finite and keeps a mesh in range.
fn check(bvh: &Bvh<'_>, pose: &Pose64) -> Result<(), PoseError> {
    let bounds = root_bounds(bvh);
    let half = bounds.min.abs().max(bounds.max.abs()).as_dvec3();
    let half = if bounds.min.x <= bounds.max.x { half } else { DVec3::ZERO };
    // At least 1, so that no entry of the pose overflows in f32.
    let extent = (DVec3::from_array(bvh.mesh().origin()).abs() + half).max(DVec3::ONE);
    pose.check_reach(extent.to_array())
}

pub(super) fn root_bounds(bvh: &Bvh<'_>) -> Bounds {
    bvh.root().map_or(Bounds::EMPTY, Node::bounds)
}

/// A box that contains posed `bounds`.
#[inline(always)]
pub(super) fn posed(pose: Option<&Affine>, bounds: &Bounds) -> Bounds {
    match pose {
        Some(pose) => pose.bounds(bounds),
        None => *bounds,
    }
}
