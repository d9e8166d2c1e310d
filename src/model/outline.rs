//! A box of all triangles in place of a BVH, for what looks at no node below the root.

use super::Model;
use pfront_core::{Bvh, Node};
use std::cell::OnceCell;
use std::slice::from_ref;

/// The root of [`Model::outline`], once it is made.
#[derive(Debug, Default)]
pub(crate) struct Outline(OnceCell<Node>);

impl Model {
    /// The BVH if it fits the positions. If it does not, it is left alone, and a root without children stands for it, for what
    /// traverses nothing: a pose that is checked, the error bounds of a shadow, single triangles. Its box is that of the
    /// root of the BVH.
    ///
    /// # Complexity
    /// O(triangles); O(1) if the BVH fits.
    pub(crate) fn outline<'m>(&'m self, outline: &'m Outline) -> Bvh<'m> {
        if self.is_fitted() {
            return self.bvh();
        }
        let mesh = self.mesh();
        if mesh.triangles().is_empty() {
            return Bvh::new_unchecked(mesh, &[], &[]);
        }
        let root = outline.0.get_or_init(|| {
            let corners = mesh.triangles().as_flattened().iter();
            let corner = |&vertex: &u32| mesh.shadow()[vertex as usize];
            let ([mut min, mut max], at) =
                ([corner(&mesh.triangles()[0][0]); 2], corners.map(corner));
            for p in at {
                min = [0, 1, 2].map(|k| p[k].min(min[k]));
                max = [0, 1, 2].map(|k| p[k].max(max[k]));
            }
            Node { min, first: 0, max, count: 1 }
        });
        Bvh::new_unchecked(mesh, from_ref(root), &[0])
    }

    /// Whether the BVH fits the positions.
    #[inline]
    pub(crate) fn is_fitted(&self) -> bool {
        self.tree.fresh().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::Subject;
    use crate::{AnyPose, PairQuery, Pose, Pose64, PoseError};
    use pfront_testkit::scenes::icosphere;

    fn ball(scale: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let ball = icosphere(500);
        (ball.positions.iter().map(|p| p.map(|x| scale * x)).collect(), ball.triangles)
    }

    fn model() -> Model {
        let (positions, triangles) = ball(1.0);
        Model::new(positions, triangles).unwrap()
    }

    #[test]
    fn a_pose_is_checked_without_a_fit() {
        let (still, mut moving, mut query) = (model(), model(), PairQuery::new());
        moving.set_positions_unfitted(&ball(2.0).0).unwrap();
        let far = Pose::from_translation([3.0e38, 0.0, 0.0]);
        assert!(
            Subject::pair([&still, &moving], Pose::IDENTITY.into(), crate::Distance::default())
                .is_ok()
        );
        assert!(!moving.is_fitted());
        assert!(query.count(&still, &moving, far).is_err());
        // Vertices that no triangle has may be anywhere.
        let (mut positions, triangles) = ball(1.0);
        positions.push([2.0e38; 3]);
        let mut loose = Model::new(positions.clone(), triangles).unwrap();
        positions[0][0] += 0.1;
        loose.set_positions_unfitted(&positions).unwrap();
        let out: Result<(), PoseError> =
            AnyPose::F32(far).check(loose.outline(&Outline::default()));
        assert!(out.is_err() && query.count(&still, &loose, Pose::IDENTITY).is_ok());
        let twice = Pose::new([[2.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]);
        assert!(query.count(&still, &loose, twice).is_ok());
    }

    #[test]
    fn an_outline_decides_as_the_bvh_does() {
        let (mut moving, still) = (model(), model());
        moving.set_positions_unfitted(&ball(1.01).0).unwrap();
        let mut fitted = moving.clone();
        fitted.fit();
        let poses = [
            AnyPose::F32(Pose::from_translation([0.3, 0.1, 0.0])),
            AnyPose::F64(Pose64::from_translation([0.3, 0.1, 0.0])),
        ];
        for pose in poses {
            let contacts = PairQuery::new().contacts_f64(&fitted, &still, pose).unwrap();
            assert!(contacts.len() > 20);
            let outline = Outline::default();
            let query = pose.pair([moving.outline(&outline), still.bvh()]).unwrap();
            for (pair, contact) in contacts {
                use pfront_core::bvtt::Query;
                assert!(query.intersects(pair));
                assert_eq!(query.contact_f64(pair), Some(contact));
            }
        }
        assert!(!moving.is_fitted());
    }
}
