//! Breaks, panics, odd settings, any number of threads and ten thousand frames leave everything usable.

use crate::common::{Frames, SCHEDULES, sequential};
use pfront_core::bvtt::{Query, TrianglePair};
use pfront_cpu::{Pool, Schedule, Settings, Traversal};
use pfront_testkit::rng::{RngExt, seeded};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

/// A pool of its own, so that there are threads to break between on any machine.
fn traversal(threads: usize, schedule: Schedule) -> Traversal {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let settings = Settings { schedule, ..Settings::default() };
    Traversal::new(&Pool::from(Arc::new(pool)).with_settings(settings))
}

#[test]
fn a_break_stops_all_workers() {
    let frames = Frames::named("spheres", 6_000);
    let query = frames.query(60);
    let expected = sequential(&query);
    for schedule in SCHEDULES {
        let mut traversal = traversal(4, schedule);
        for after in [1, 2, 10, expected.len()] {
            let seen = AtomicUsize::new(0);
            let end = traversal
                .visit(&[query], |_| {
                    let last = seen.fetch_add(1, Relaxed) + 1 >= after;
                    if last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                })
                .unwrap();
            assert!(end.is_break());
            // Each other worker may have been in a call.
            assert!((after..after + 4).contains(&seen.into_inner()));
            let mut pairs = Vec::<TrianglePair>::new();
            traversal.all(&[query], &mut pairs).unwrap();
            assert_eq!(pairs, expected);
        }
    }
}

#[test]
fn a_panic_leaves_it_usable() {
    let frames = Frames::named("spheres", 6_000);
    let query = frames.query(60);
    let expected = sequential(&query);
    for schedule in SCHEDULES {
        let mut traversal = traversal(3, schedule);
        for _ in 0..3 {
            let seen = AtomicUsize::new(0);
            let panicked = catch_unwind(AssertUnwindSafe(|| {
                traversal
                    .visit(&[query], |_| {
                        if seen.fetch_add(1, Relaxed) == 20 {
                            resume_unwind(Box::new("visitor"));
                        }
                        ControlFlow::Continue(())
                    })
                    .unwrap()
            }));
            assert!(panicked.is_err());
            let mut pairs = Vec::<TrianglePair>::new();
            traversal.all(&[query], &mut pairs).unwrap();
            assert_eq!(pairs, expected);
        }
    }
}

/// Threads that wait for work to be given hold the pool that a visitor needs.
#[test]
fn a_visitor_may_use_the_same_pool() {
    let frames = Frames::named("spheres", 6_000);
    let query = frames.query(60);
    let expected = sequential(&query).len();
    for schedule in SCHEDULES {
        for threads in [1, 2, 5] {
            let mut traversal = traversal(threads, schedule);
            let pool = traversal.pool.clone();
            let inner = || (0..64).into_par_iter().sum::<u32>();
            let seen = AtomicUsize::new(0);
            let _ = traversal
                .visit(&[query], |_| {
                    let sum = pool.install(inner);
                    seen.fetch_add((sum == 2016).into(), Relaxed);
                    ControlFlow::Continue(())
                })
                .unwrap();
            assert_eq!(seen.into_inner(), expected, "{schedule:?}, {threads} threads");
        }
    }
}

/// A thread that takes its time over each hit gives what it has left to those that are done.
#[test]
fn others_take_what_a_slow_thread_has_left() {
    let frames = Frames::named("spheres", 6_000);
    let query = frames.query(60);
    let hits_of_one = SCHEDULES.map(|schedule| {
        let mut traversal = traversal(3, schedule);
        let (own, all) = (std::thread::current().id(), AtomicUsize::new(0));
        let slow = AtomicUsize::new(0);
        let _ = traversal
            .visit(&[query], |_| {
                all.fetch_add(1, Relaxed);
                if std::thread::current().id() == own && slow.fetch_add(1, Relaxed) > 0 {
                    std::thread::sleep(Duration::from_millis(1));
                }
                ControlFlow::Continue(())
            })
            .unwrap();
        assert_eq!(all.into_inner(), sequential(&query).len());
        // Work counts for the worker whose thread does it.
        let shares = traversal.report.shares.iter();
        assert!(shares.filter(|share| share.work.box_tests > 100).count() > 1, "{schedule:?}");
        slow.into_inner()
    });
    let [alone, hybrid] = hits_of_one;
    assert!(4 * hybrid < alone, "{hits_of_one:?}");
}

/// A front as coarse or as fine as can be, but none that takes for ever.
#[test]
fn any_g_comes_to_an_end() {
    let frames = Frames::named("spheres", 6_000);
    let odd = [0.0, -0.0, -1.0, f64::MIN, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, 48.0];
    for (i, schedule) in SCHEDULES.into_iter().enumerate() {
        for (g, max_nodes) in odd.iter().flat_map(|&g| [(g, 1 << 20), (g, 100)]) {
            let settings = Settings { schedule, g, max_nodes, ..Settings::default() };
            let mut traversal = Traversal::new(&Pool::new(3 + i).with_settings(settings));
            for frame in [50, 51] {
                let query = frames.query(frame);
                assert_eq!(traversal.count(&[query]).unwrap(), query.count(), "{g}");
            }
        }
    }
}

#[test]
fn ten_thousand_frames() {
    let frames = Frames::named("spheres", 300);
    let queries: Vec<_> = (0..120).map(|i| frames.query(i)).collect();
    let expected: Vec<_> = queries.iter().map(sequential).collect();
    let mut traversals: Vec<_> = SCHEDULES.iter().map(|&schedule| traversal(3, schedule)).collect();
    let (mut pairs, mut rng) = (Vec::<TrianglePair>::new(), seeded(1));
    for frame in 0..10_000 {
        // Mostly onwards, at times elsewhere.
        let jumps = rng.random_bool(1.0 / 16.0);
        let i = if jumps { rng.random_range(0..queries.len()) } else { frame % queries.len() };
        let traversal = &mut traversals[frame % 2];
        match rng.random_range(0..4) {
            0 => assert_eq!(traversal.count(&[queries[i]]).unwrap(), expected[i].len() as u64),
            1 => {
                assert_eq!(
                    traversal.any(&[queries[i]]).unwrap().is_some(),
                    !expected[i].is_empty()
                );
            }
            _ => {
                traversal.all(&[queries[i]], &mut pairs).unwrap();
                assert!(pairs == expected[i], "frame {frame}");
            }
        }
    }
}

/// Costs are counted, and summed in one order: a front depends on nothing but the frames and p.
#[test]
fn threads_do_not_show_in_a_front() {
    let frames = Frames::named("torus-knots", 40_000);
    let reports = |threads, p, max_nodes| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = Settings { schedule: Schedule::Static, max_nodes, ..Settings::default() };
        let mut traversal = Traversal::new(&Pool::new(p).with_settings(settings));
        [40, 41, 42, 90, 91].map(|i| {
            pool.install(|| traversal.count(&[frames.query(i)]).unwrap());
            let report = &traversal.report;
            (report.front, report.nodes, report.imbalance(), report.shares.clone())
        })
    };
    for (p, max_nodes) in [(1024, 9_000), (1024, 1 << 20), (200, 12_000)] {
        let alone = reports(1, p, max_nodes);
        for threads in [3, 8] {
            assert!(alone == reports(threads, p, max_nodes), "p = {p}, {threads} threads");
        }
    }
}
