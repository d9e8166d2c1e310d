//! The same pairs as one core finds, for every number of workers, schedule and verb.

use crate::common::{Body, Frames, SCHEDULES, predicted_imbalance, sequential};
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt, TrianglePair};
use pfront_cpu::{Hit, MAX_WORKERS, Pool, Settings, Traversal};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Scene, icosphere};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

const WORKERS: [usize; 7] = [1, 2, 3, 7, 16, 64, 1024];

fn traversals() -> Vec<Traversal> {
    let settings = |schedule| Settings { schedule, ..Settings::default() };
    let all = WORKERS.iter().flat_map(|&p| SCHEDULES.map(|s| (p, s)));
    all.map(|(p, schedule)| Traversal::new(&Pool::new(p).with_settings(settings(schedule))))
        .collect()
}

/// Asks everything of one query, of all traversals.
fn conforms<Q: Query + Sync>(traversals: &mut [Traversal], query: &Q) -> usize {
    let (queries, expected) = (std::slice::from_ref(query), sequential(query));
    let mut pairs = vec![TrianglePair { a: 7, b: 7 }; 3];
    for traversal in traversals {
        traversal.all(queries, &mut pairs).unwrap();
        let p = traversal.pool.workers;
        assert!(pairs == expected, "p = {p}: {} pairs, not {}", pairs.len(), expected.len());
        assert_eq!(traversal.count(queries).unwrap(), expected.len() as u64, "p = {p}");
        match traversal.any(queries).unwrap() {
            Some(hit) => assert!(expected.binary_search(&hit.pair).is_ok(), "p = {p}"),
            None => assert!(expected.is_empty(), "p = {p}"),
        }
        let visited = Mutex::new(Vec::new());
        let end = traversal
            .visit(queries, |hit| {
                visited.lock().unwrap().push(hit.pair);
                ControlFlow::Continue(())
            })
            .unwrap();
        let mut visited = visited.into_inner().unwrap();
        visited.sort_unstable();
        assert!(end.is_continue() && visited == expected, "p = {p}");
    }
    expected.len()
}

#[test]
fn pairs_in_motion() {
    for (name, size) in [("worm-gear", 7_600), ("spheres", 6_000), ("torus-knots", 5_000)] {
        let frames = Frames::named(name, size);
        let mut traversals = traversals();
        let met: usize =
            (40..52).step_by(3).map(|i| conforms(&mut traversals, &frames.query(i))).sum();
        assert!(met > 0, "{name}");
    }
}

#[test]
fn random_courses() {
    let frames = Frames::named("course", 6_000);
    let mut traversals = traversals();
    let met: usize = (0..12).map(|i| conforms(&mut traversals, &frames.query(i))).sum();
    assert!(met > 0);
}

#[test]
fn a_deforming_mesh_with_itself() {
    let scene = Scene::by_name("sheet", Some(5_000)).unwrap();
    let mut body = Body::new(scene.meshes[0].clone());
    let (mut traversals, mut positions, mut met) = (traversals(), Vec::new(), 0);
    for frame in (40..70).step_by(10) {
        scene.positions(frame, &mut positions);
        body.deform(&positions);
        met += conforms(&mut traversals, &SelfBvtt::new(body.bvh()));
    }
    assert!(met > 0);
}

#[test]
fn nothing_and_nearly_nothing() {
    let empty = Body::new(MeshData::default());
    let one = Body::new(MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
    });
    let mut traversals = traversals();
    for (a, b, met) in [(&empty, &empty, 0), (&one, &empty, 0), (&one, &one, 1)] {
        let query = PairBvtt::new(a.bvh(), b.bvh(), pfront_core::Pose::IDENTITY).unwrap();
        assert_eq!(conforms(&mut traversals, &query), met);
        assert_eq!(conforms(&mut traversals, &SelfBvtt::new(a.bvh())), 0);
    }
}

#[test]
fn many_queries_at_once() {
    let frames = Frames::named("spheres", 3_000);
    let mut traversals = traversals();
    let mut hits = Vec::<Hit>::new();
    // Their number changes from frame to frame, and some find nothing.
    for count in [9, 0, 4, 9] {
        let queries: Vec<_> = (0..count).map(|i| frames.query(20 + 9 * i)).collect();
        let one = |(query, q)| sequential(q).into_iter().map(move |pair| Hit { query, pair });
        let expected: Vec<_> = (0..).zip(&queries).flat_map(one).collect();
        for traversal in &mut traversals {
            traversal.all(&queries, &mut hits).unwrap();
            assert!(hits == expected, "p = {}", traversal.pool.workers);
            assert_eq!(traversal.count(&queries).unwrap(), expected.len() as u64);
            assert_eq!(traversal.any(&queries).unwrap().is_some(), !expected.is_empty());
        }
    }
}

#[test]
fn settings_change_no_answer() {
    let frames = Frames::named("spheres", 4_000);
    let default = Settings::default();
    let mut pairs = Vec::<TrianglePair>::new();
    for g in [0.1, 1.0, 2.0, 100.0] {
        for (coherence, max_nodes) in [(true, 1), (false, 5), (true, 33), (true, 1 << 20)] {
            let settings = Settings { g, coherence, max_nodes, ..default };
            let mut traversal = Traversal::new(&Pool::new(13).with_settings(settings));
            for frame in 50..54 {
                let query = frames.query(frame);
                traversal.all(&[query], &mut pairs).unwrap();
                assert!(pairs == sequential(&query), "{settings:?}");
                assert!(traversal.report.nodes <= max_nodes.max(1));
            }
        }
    }
}

#[test]
fn max_nodes_bounds_a_front_whose_memory_has_grown() {
    let (frames, mut traversal) = (Frames::named("spheres", 6_000), Traversal::new(&Pool::new(64)));
    for (max_nodes, expected) in [(1 << 20, 41..2000), (40, 1..41)] {
        traversal.pool.settings.max_nodes = max_nodes;
        assert_eq!(traversal.count(&[frames.query(50)]).unwrap(), frames.query(50).count());
        assert!(expected.contains(&traversal.report.nodes), "{}", traversal.report.nodes);
    }
}

/// One sphere inside another, just not touching: a search for one hit takes long enough to be divided.
#[test]
fn a_search_for_one_hit_leaves_costs_as_they_are() {
    let mut mesh = icosphere(20_000);
    let outer = Body::new(mesh.clone());
    mesh.positions.iter_mut().flatten().for_each(|x| *x *= 0.999);
    let inner = Body::new(mesh);
    let queries = [PairBvtt::new(outer.bvh(), inner.bvh(), pfront_core::Pose::IDENTITY).unwrap()];
    let mut traversal = Traversal::new(&Pool::new(4));
    assert_eq!(traversal.count(&queries).unwrap(), 0);
    for _ in 0..2 {
        assert_eq!(traversal.count(&queries).unwrap(), 0);
        assert!(traversal.report.front.coherent);
        assert!(traversal.any(&queries).unwrap().is_none());
        assert!(!traversal.report.shares.is_empty() && !traversal.report.front.coherent);
    }
}

#[test]
fn no_partition_is_less_even_than_its_certificate() {
    let frames = Frames::named("spheres", 2_000);
    for schedule in SCHEDULES {
        let settings = Settings { schedule, ..Settings::default() };
        let mut traversal = Traversal::new(&Pool::new(4).with_settings(settings));
        traversal.count(&[frames.query(50)]).unwrap();
        let report = &traversal.report;
        let (predicted, bound) = (predicted_imbalance(report), 1.0 + report.front.epsilon);
        assert!(report.imbalance() >= 1.0 && predicted >= 1.0);
        assert!(predicted <= bound * 1.000_001, "{report:?}");
    }
}

/// How long the calling thread stays alone, and how many others it calls, depends on the machine then; the answer does not.
#[test]
fn the_measured_price_of_a_call_changes_no_answer() {
    let frames = Frames::named("spheres", 6_000);
    for schedule in SCHEDULES {
        let settings = Settings { schedule, ..Settings::default() };
        let threads = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        let pool = Pool::from(Arc::new(threads)).with_settings(settings).measured();
        let mut traversal = Traversal::new(&pool);
        let mut pairs = Vec::<TrianglePair>::new();
        // Frames of nothing, of little and of much take turns.
        for frame in [0, 50, 20, 51, 52, 0, 53] {
            let query = frames.query(frame);
            traversal.all(&[query], &mut pairs).unwrap();
            assert!(pairs == sequential(&query), "{schedule:?} {frame}");
            assert_eq!(traversal.any(&[query]).unwrap().is_some(), !pairs.is_empty());
        }
    }
}

/// The calling thread begins, and others go on from where it was: all of a query is traversed once.
#[test]
fn what_outgrows_one_thread_is_handed_over() {
    let ball = Body::new(icosphere(20_000));
    let at = |x| {
        let pose = pfront_core::Pose::from_translation([x, 0.01, 0.0]);
        PairBvtt::new(ball.bvh(), ball.bvh(), pose).unwrap()
    };
    let (far, near, query) = (at(3.0), at(1.9999), at(0.1));
    let (few, expected) = (sequential(&near), sequential(&query));
    for schedule in SCHEDULES {
        let settings = Settings { schedule, ..Settings::default() };
        let mut traversal = Traversal::new(&Pool::new(4).with_settings(settings));
        let mut pairs = Vec::<TrianglePair>::new();
        for _ in 0..2 {
            // After a small frame, another is expected.
            traversal.all(&[near], &mut pairs).unwrap();
            assert!(pairs == few);
            traversal.all(&[near], &mut pairs).unwrap();
            assert!(pairs == few && traversal.report.shares.is_empty());
            traversal.all(&[query], &mut pairs).unwrap();
            assert!(pairs == expected, "{schedule:?}");
            let report = &traversal.report;
            assert!(report.alone.box_tests > 0 && !report.shares.is_empty(), "{report:?}");
            // Then it is known to be worth several threads.
            traversal.all(&[query], &mut pairs).unwrap();
            assert!(pairs == expected && traversal.report.alone.box_tests == 0);
            assert!(traversal.any(&[query]).unwrap().is_some());
            assert!(traversal.report.alone.box_tests > 0, "any begins on the calling thread");
            // Where nothing overlaps, nothing is known.
            traversal.all(&[far], &mut pairs).unwrap();
            assert!(pairs.is_empty() && traversal.report.shares.is_empty());
        }
    }
}

#[test]
fn the_number_of_workers_is_bounded() {
    let (frames, mut traversal) = (Frames::named("spheres", 6_000), Traversal::new(&Pool::new(0)));
    for (workers, shares) in [(usize::MAX, MAX_WORKERS), (0, 0), (100_000, MAX_WORKERS)] {
        traversal.pool.workers = workers;
        assert_eq!(traversal.count(&[frames.query(60)]).unwrap(), frames.query(60).count());
        assert_eq!(traversal.report.shares.len(), shares);
    }
}

/// On one thread, so that nobody takes anything from the worker that calls.
#[test]
fn any_on_several_workers_searches_in_the_order_of_one() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let work = |workers: usize, queries: &[SelfBvtt<'_>]| {
        let mut traversal = Traversal::new(&Pool::new(workers));
        let found = pool.install(|| traversal.any(queries)).unwrap();
        (found, traversal.report.work(), traversal.report.shares.is_empty())
    };
    let scene = Scene::by_name("sheet", Some(20_000)).unwrap();
    let (mut body, mut positions) = (Body::new(scene.meshes[0].clone()), Vec::new());
    let flat = Body::new(scene.meshes[0].clone());
    let mut divided = [0; 2];
    for frame in (0..120).step_by(8) {
        scene.positions(frame, &mut positions);
        body.deform(&positions);
        // One is asked after another that finds nothing, or as much.
        let [own, other] = [&body, &flat].map(|body| SelfBvtt::new(body.bvh()));
        for queries in [&[own][..], &[other, own, own]] {
            let (found, expected, _) = work(1, queries);
            for workers in [2, 7] {
                let (again, tests, alone) = work(workers, queries);
                assert_eq!((again, tests), (found, expected), "frame {frame}");
                divided[usize::from(found.is_some())] += usize::from(!alone);
            }
        }
    }
    assert!(divided.iter().all(|&count| count > 0), "{divided:?}");
}
