//! Poses of either precision.

use crate::environment::with_default;
use pfront_core::bvtt::{PairBvtt, PosedBvh};
use pfront_core::pose::PoseError;
use pfront_core::{Aabb, Bvh, Pose, Pose64};

/// A pose in f32 or in f64, as queries take it. In an [`AnyPose::F64`] the positions of both models are posed in f64, of
/// whichever kind they are.
///
/// # Examples
/// ```
/// use pfront::{AnyPose, Model, PairQuery, Pose, Pose64};
/// assert_eq!(AnyPose::from(Pose::IDENTITY), AnyPose::F32(Pose::IDENTITY));
/// let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
/// let above = |z| AnyPose::F64(Pose64::from_translation([0.0, 0.0, z]));
/// let mut query = PairQuery::new();
/// assert_eq!(query.count(&a, &a, above(0.0))?, 1);
/// assert_eq!(query.count(&a, &a, above(5e-324))?, 0);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AnyPose {
    /// In f32.
    F32(Pose),
    /// In f64.
    F64(Pose64),
}

impl AnyPose {
    /// The query about two meshes, the second in this pose: [`PairBvtt::new`] or [`PairBvtt::in_f64`].
    ///
    /// # Errors
    /// As these.
    ///
    /// # Examples
    /// ```
    /// use pfront::pfront_core::bvtt::Query;
    /// use pfront::{AnyPose, Model, Pose};
    /// let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let query = AnyPose::from(Pose::IDENTITY).pair([a.bvh(), a.bvh()])?;
    /// assert_eq!(query.count(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn pair<'m>(&self, [a, b]: [Bvh<'m>; 2]) -> Result<PairBvtt<'m>, PoseError> {
        with_default(|| match self {
            Self::F32(pose) => PairBvtt::new(a, b, *pose),
            Self::F64(pose) => PairBvtt::in_f64(a, b, pose),
        })
    }

    /// A mesh in this pose, which it is known to suit.
    pub(crate) fn place<'m>(&self, bvh: Bvh<'m>) -> PosedBvh<'m> {
        match self {
            Self::F32(pose) => PosedBvh::new_unchecked(bvh, pose),
            Self::F64(pose) => PosedBvh::in_f64_unchecked(bvh, pose),
        }
    }

    /// Whether the pose suits a mesh.
    pub(crate) fn check(&self, bvh: Bvh<'_>) -> Result<(), PoseError> {
        match self {
            Self::F32(pose) => PosedBvh::new(bvh, pose).map(drop),
            Self::F64(pose) => PosedBvh::in_f64(bvh, pose).map(drop),
        }
    }

    /// Whether the pose suits a mesh in f32 within these bounds.
    pub(crate) fn check_bounds(&self, bounds: &Aabb) -> Result<(), PoseError> {
        match self {
            Self::F32(pose) if *pose == Pose::IDENTITY => Ok(()),
            Self::F32(pose) => pose.check(bounds),
            Self::F64(pose) => pose.check(bounds),
        }
    }

    /// Whether it is the same pose, to the bit.
    pub(crate) fn same_bits(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::F32(own), Self::F32(other)) => {
                own.rows.map(|row| row.map(f32::to_bits))
                    == other.rows.map(|row| row.map(f32::to_bits))
            }
            (Self::F64(own), Self::F64(other)) => {
                own.rows.map(|row| row.map(f64::to_bits))
                    == other.rows.map(|row| row.map(f64::to_bits))
            }
            _ => false,
        }
    }

    /// Whether it is in f64.
    #[must_use]
    pub fn is_f64(&self) -> bool {
        matches!(self, Self::F64(_))
    }

    /// The same entries in f64, in which the posed points of one in f32 differ: they are rounded there.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{AnyPose, Pose, Pose64};
    /// assert_eq!(AnyPose::from(Pose::IDENTITY).to_f64(), Pose64::IDENTITY);
    /// ```
    #[must_use]
    pub fn to_f64(&self) -> Pose64 {
        match self {
            Self::F32(pose) => with_default(|| (*pose).into()),
            Self::F64(pose) => *pose,
        }
    }
}

impl From<Pose> for AnyPose {
    fn from(pose: Pose) -> Self {
        Self::F32(pose)
    }
}

impl From<Pose64> for AnyPose {
    fn from(pose: Pose64) -> Self {
        Self::F64(pose)
    }
}

impl From<&Pose> for AnyPose {
    fn from(pose: &Pose) -> Self {
        Self::F32(*pose)
    }
}

impl From<&Pose64> for AnyPose {
    fn from(pose: &Pose64) -> Self {
        Self::F64(*pose)
    }
}

impl From<&Self> for AnyPose {
    fn from(pose: &Self) -> Self {
        *pose
    }
}
