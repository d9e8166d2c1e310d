//! Trees deeper than the paths of a cost history tell apart are divided as evenly as others.

use crate::common::{Body, predicted_imbalance, sequential};
use pfront_core::Pose;
use pfront_core::bvtt::{PairBvtt, TrianglePair};
use pfront_cpu::{Pool, Schedule, Settings, Traversal};
use pfront_testkit::scenes::icosphere;

#[test]
fn a_dense_body_beside_outliers_is_divided_evenly() {
    for levels in [33, 52] {
        let body = Body::new(icosphere(20_000)).below_outliers(levels);
        assert!(body.bvh().depth() > levels as usize + 8);
        let pose = Pose::from_translation([0.0, 0.01, 0.02]);
        let query = PairBvtt::new(body.bvh(), body.bvh(), pose).unwrap();
        let expected = sequential(&query);
        for schedule in [Schedule::Static, Schedule::Hybrid] {
            for p in [2, 8] {
                let settings = Settings { schedule, ..Settings::default() };
                let mut traversal = Traversal::new(&Pool::new(p).with_settings(settings));
                let mut pairs = Vec::<TrianglePair>::new();
                for frame in 0..6 {
                    traversal.all(&[query], &mut pairs).unwrap();
                    assert!(pairs == expected);
                    let report = &traversal.report;
                    let what = format!("{levels} {p} {:?} {}", report.front, report.imbalance());
                    // A thread that comes late under Hybrid is no fault of the front.
                    if schedule == Schedule::Static {
                        assert!(report.imbalance() <= if frame == 0 { 2.5 } else { 1.5 }, "{what}");
                    }
                    assert!(predicted_imbalance(report) <= 1.0 + report.front.epsilon + 1e-6);
                    let (settled, epsilon) = match schedule {
                        Schedule::Static => (1, 0.126),
                        _ => (3, 0.51),
                    };
                    assert!(frame < settled || report.front.epsilon <= epsilon, "{what}");
                }
            }
        }
    }
}
