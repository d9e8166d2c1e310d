//! A deadline or a cancel flag ends a frame within a slice of tests of each thread, under every schedule.

use crate::common::{Body, SCHEDULES};
use pfront_core::Pose;
use pfront_core::bvtt::PairBvtt;
use pfront_cpu::{Pool, Settings, Traversal};
use pfront_testkit::scenes::icosphere;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Tests between two looks at the clock, as `Traversal::deadline` tells.
const SLICE: u64 = 4096;

#[test]
fn frames_end_at_their_deadline() {
    let ball = Body::new(icosphere(50_000));
    let pose = Pose::from_translation([0.0, 0.0, 0.002]);
    let query = PairBvtt::new(ball.bvh(), ball.bvh(), pose).unwrap();
    for schedule in SCHEDULES {
        for p in [1, 2, 8] {
            let settings = Settings { schedule, ..Settings::default() };
            let mut traversal = Traversal::new(&Pool::new(p).with_settings(settings));
            let whole = traversal.count(&[query]).unwrap();
            assert!(whole > 1000 && !traversal.report.late);
            let all = traversal.report.work();
            let tests = all.tests();
            assert!(tests > 50 * SLICE, "{tests}");

            traversal.deadline = Some(Instant::now());
            assert_eq!(traversal.count(&[query]).unwrap(), 0);
            let report = &traversal.report;
            assert!(report.late && report.alone == Default::default(), "{report:?}");
            assert!(report.shares.iter().all(|share| share.work == Default::default()));

            let deadline = Instant::now() + Duration::from_micros(300);
            traversal.deadline = Some(deadline);
            let after = AtomicU64::new(0);
            let end = traversal
                .visit(&[query], |_| {
                    after.fetch_add(u64::from(Instant::now() > deadline), Relaxed);
                    ControlFlow::Continue(())
                })
                .unwrap();
            assert!(end.is_break() && traversal.report.late, "{schedule:?} {p}");
            // Each hit takes a test.
            let after = after.into_inner();
            assert!(after <= p as u64 * SLICE, "{schedule:?} {p}: {after} hits after the deadline");

            // Nothing is left of it.
            traversal.deadline = None;
            assert_eq!(traversal.count(&[query]).unwrap(), whole);
            assert!(!traversal.report.late);
        }
    }
}

#[test]
fn frames_end_when_they_are_cancelled() {
    let ball = Body::new(icosphere(50_000));
    let pose = Pose::from_translation([0.0, 0.0, 0.002]);
    let query = PairBvtt::new(ball.bvh(), ball.bvh(), pose).unwrap();
    for schedule in SCHEDULES {
        for p in [1, 2, 8] {
            let settings = Settings { schedule, ..Settings::default() };
            let mut traversal = Traversal::new(&Pool::new(p).with_settings(settings));
            let whole = traversal.count(&[query]).unwrap();
            let cancel = Arc::new(AtomicBool::new(false));
            traversal.cancel = Some(cancel.clone());
            assert_eq!(traversal.count(&[query]).unwrap(), whole);

            let after = AtomicU64::new(0);
            let end = traversal
                .visit(&[query], |_| {
                    after.fetch_add(u64::from(cancel.swap(true, Relaxed)), Relaxed);
                    ControlFlow::Continue(())
                })
                .unwrap();
            assert!(end.is_break() && !traversal.report.late, "{schedule:?} {p}");
            let after = after.into_inner();
            assert!(after <= p as u64 * SLICE, "{schedule:?} {p}: {after} hits after the flag");

            // It stays cancelled for as long as the caller wants it.
            assert_eq!(traversal.count(&[query]).unwrap(), 0);
            cancel.store(false, Relaxed);
            assert_eq!(traversal.count(&[query]).unwrap(), whole);
        }
    }
}
