//! Poses of either precision.

use pfront_core::bvtt::PairBvtt;
use pfront_core::pose::PoseError;
use pfront_core::{Bvh, Pose, Pose64};

/// A pose in f32 or in f64, as queries take it. In an [`AnyPose::F64`] the positions of both models are posed in f64, of
/// whichever kind they are.
///
/// # Examples
/// ```
/// use pfront::{AnyPose, Model, PairQuery, Pose, Pose64};
/// assert_eq!(AnyPose::from(&Pose::IDENTITY), AnyPose::F32(Pose::IDENTITY));
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
    /// The second mesh of a query in this pose.
    pub(crate) fn pair<'m>(&self, [a, b]: [Bvh<'m>; 2]) -> Result<PairBvtt<'m>, PoseError> {
        match self {
            Self::F32(pose) => PairBvtt::new(a, b, *pose),
            Self::F64(pose) => PairBvtt::in_f64(a, b, pose),
        }
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
