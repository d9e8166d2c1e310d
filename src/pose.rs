//! Poses of either precision.

use crate::Contact;
use crate::environment::with_default;
use glam::{DVec3, Vec3};
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

    /// Where two triangles of a mesh meet, in this pose.
    pub(crate) fn contact(&self, contact: Contact<f64>) -> Contact<f64> {
        let pose = self.to_f64();
        if pose == Pose64::IDENTITY {
            return contact;
        }
        // Normals turn as cross products of edges do.
        let [u, v, w] = pose.rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
        let cofactors = [v.cross(w), w.cross(u), u.cross(v)];
        let normals = contact.normals.map(|normal| {
            let normal = Vec3::from_array(normal).as_dvec3();
            let turned = DVec3::from_array(cofactors.map(|row| row.dot(normal)));
            turned.normalize_or_zero().as_vec3().to_array()
        });
        Contact { segment: contact.segment.map(|p| pose.apply(p)), normals, ..contact }
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

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::triangle::contact;

    /// A contact that is posed is that of the posed triangles, in a mirror and stretched too.
    #[test]
    fn contacts_are_posed_as_triangles_are() {
        let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let blade = [[1.0, 1.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0]];
        let unposed = contact(&floor, &blade).unwrap().into();
        let turned = Pose::from_rotation_translation([0.5, -0.5, 0.5, 0.5], [3.0, -7.0, 0.5]);
        let mirrored =
            Pose::new([[-1.0, 0.0, 0.0, 2.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 9.0]]);
        let stretched =
            Pose::new([[2.0, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 3.0, 0.25, 1.0]]);
        for pose in [Pose::IDENTITY, turned, mirrored, stretched] {
            let [a, b] = [floor, blade].map(|t| t.map(|p| pose.apply(p)));
            let (found, expected) = (
                AnyPose::from(pose).contact(unposed),
                Contact::<f64>::from(contact(&a, &b).unwrap()),
            );
            // The order of the ends is up to the plane.
            let ends = |c: Contact<f64>| {
                let mut ends = c.segment;
                ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
                ends
            };
            let distance = |p: &[f64], q: &[f64]| {
                p.iter().zip(q).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()))
            };
            assert!(distance(ends(found).as_flattened(), ends(expected).as_flattened()) < 1e-5);
            let normals = |c: Contact<f64>| c.normals.map(|n| n.map(f64::from));
            let apart = distance(normals(found).as_flattened(), normals(expected).as_flattened());
            assert!(apart < 1e-6, "{pose:?} {found:?} {expected:?}");
        }
    }
}
