//! A body of a scene: a model and where it is.

use super::id::BodyId;
use crate::sphere::Sphere;
use crate::{Aabb, AnyPose, Error, Model};
use pfront_core::bvtt::PosedBvh;
use std::sync::{Arc, OnceLock};

/// Groups of bodies: two bodies are asked about if each is a member of a group that the other's filter lets through. Rapier's
/// `InteractionGroups` in the mode `And` are the same bits.
///
/// # Examples
/// ```
/// use pfront::Groups;
/// let wheels = Groups { memberships: 0b01, filter: 0b10 };
/// let ground = Groups { memberships: 0b10, filter: 0b11 };
/// assert!(wheels.meet(&ground) && !wheels.meet(&wheels));
/// assert!(ground.meet(&Groups::default()));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Groups {
    /// A bit for each group that the body is a member of.
    pub memberships: u32,
    /// A bit for each group whose members it may meet.
    pub filter: u32,
}

impl Groups {
    /// Whether members of both are asked about.
    #[must_use]
    pub const fn meet(&self, other: &Self) -> bool {
        self.memberships & other.filter != 0 && other.memberships & self.filter != 0
    }
}

/// Every body meets every other.
impl Default for Groups {
    fn default() -> Self {
        Self { memberships: u32::MAX, filter: u32::MAX }
    }
}

/// A model and where it is.
#[derive(Clone, Debug)]
pub struct Body {
    pub(super) id: BodyId,
    pub(super) model: Arc<Model>,
    pub(super) pose: AnyPose,
    aabb: Option<Aabb>,
    /// Made when a box of another body first overlaps that of this one.
    sphere: OnceLock<Sphere>,
    /// When it got the mesh that it has.
    pub(super) meshed: u64,
    pub(super) groups: Groups,
    pub(super) user_data: u64,
}

impl Body {
    /// The id.
    #[must_use]
    pub fn id(&self) -> BodyId {
        self.id
    }

    /// The model, in its own frame.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The pose `world_from_body`.
    #[must_use]
    pub fn pose(&self) -> AnyPose {
        self.pose
    }

    /// The groups of [`crate::SceneQuery::set_groups`].
    #[must_use]
    pub fn groups(&self) -> Groups {
        self.groups
    }

    /// The number of [`crate::SceneQuery::set_user_data`], 0 at first.
    #[must_use]
    pub fn user_data(&self) -> u64 {
        self.user_data
    }

    /// A box in the world that contains every posed vertex, rounding included; `None` if there is no
    /// triangle.
    #[must_use]
    pub fn aabb(&self) -> Option<Aabb> {
        self.aabb
    }

    /// A sphere in the world that contains every posed vertex, rounding included.
    ///
    /// # Complexity
    /// O(n) for a model of n triangles that no body has asked about since it changed, else O(1).
    pub(super) fn sphere(&self) -> Sphere {
        *self.sphere.get_or_init(|| match self.model.sphere() {
            Some(sphere) => sphere.posed(&self.pose.to_f64()),
            None => Sphere { centre: [0.0; 3], radius: f32::INFINITY },
        })
    }

    /// Whether the model or the pose is in f64.
    pub(super) fn is_f64(&self) -> bool {
        self.pose.is_f64() || self.model.is_f64()
    }

    /// A body in this pose, that gets its mesh at a time.
    pub(super) fn new(
        id: BodyId,
        model: Arc<Model>,
        pose: AnyPose,
        meshed: u64,
    ) -> Result<Self, Error> {
        let (groups, sphere) = (Groups::default(), OnceLock::new());
        let mut body = Self { id, model, pose, aabb: None, sphere, meshed, groups, user_data: 0 };
        body.set_pose(pose)?;
        Ok(body)
    }

    pub(super) fn set_pose(&mut self, pose: AnyPose) -> Result<(), Error> {
        pose.check(self.model.bvh())?;
        self.pose = pose;
        self.reshaped();
        Ok(())
    }

    /// To be called when the shape has changed, within what the pose can take.
    pub(super) fn reshaped(&mut self) {
        self.aabb = self.placed().aabb();
        self.sphere.take();
    }

    pub(super) fn placed(&self) -> PosedBvh<'_> {
        self.pose.place(self.model.bvh())
    }
}
