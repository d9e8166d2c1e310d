//! A body of a scene: a model and where it is.

use super::id::BodyId;
use crate::sphere::Sphere;
use crate::{Aabb, Adjacency, AnyPose, Error, Model};
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

/// The options of a body, beside its model and its pose.
///
/// # Examples
/// ```
/// use pfront::{Adjacency, BodyOptions, Model, Pose, SceneQuery};
/// // A fold of two triangles, and a third that pierces the first.
/// let points = vec![
///     [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0],
///     [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 9.0],
/// ];
/// let cloth = Model::new(points, vec![[0, 1, 2], [1, 0, 3], [4, 5, 6]])?;
/// let mut scene = SceneQuery::new();
/// let itself = Some(Adjacency::default());
/// let options = BodyOptions { user_data: 7, itself, ..BodyOptions::default() };
/// let body = scene.add_with(cloth, Pose::IDENTITY, options)?;
/// let hits = scene.all()?;
/// assert_eq!((hits[0].bodies, hits[0].pair.a, hits[0].pair.b), ([body; 2], 0, 2));
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyOptions {
    /// The groups that it is in, and those whose members it may meet; all, by default.
    pub groups: Groups,
    /// A number of the caller's: the index of an entity, `Entity::to_bits` of bevy, or both halves of rapier's
    /// `RigidBodyHandle::into_raw_parts`.
    pub user_data: u64,
    /// With a rule for triangles that share a vertex, the pairs of the body with itself are among the hits, as
    /// [`SelfQuery`](crate::SelfQuery) finds them: in its own frame, by that rule. Cloth wants it; a body that does not deform
    /// costs as much in each frame in which it moves.
    pub itself: Option<Adjacency>,
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
    pub(super) options: BodyOptions,
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

    /// Its groups, the number of the caller, and whether it is asked about itself.
    #[must_use]
    pub fn options(&self) -> BodyOptions {
        self.options
    }

    /// A box in the world that contains every posed vertex, rounding included; `None` if there is no
    /// triangle.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut scene = SceneQuery::new();
    /// let id = scene.add(tile, Pose::from_translation([5.0, 0.0, 0.0]))?;
    /// let aabb = scene.body(id)?.aabb().expect("it has a triangle");
    /// assert!(aabb.min[0] <= 5.0 && 6.0 <= aabb.max[0]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
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

    /// Whether a GPU answers about all pairs of it and of others like it.
    pub(super) fn is_of_gpu(&self) -> bool {
        !self.is_f64() && self.options.itself.is_none()
    }

    /// A body in this pose, that gets its mesh at a time.
    pub(super) fn new(
        id: BodyId,
        model: Arc<Model>,
        pose: AnyPose,
        options: BodyOptions,
        meshed: u64,
    ) -> Result<Self, Error> {
        let sphere = OnceLock::new();
        let mut body = Self { id, model, pose, aabb: None, sphere, meshed, options };
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
