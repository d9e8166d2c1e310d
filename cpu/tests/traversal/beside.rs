//! A front of which a device takes a part. Here that is one more core, which tells what it did.

use crate::common::{Body, Frames, sequential};
use pfront_core::Pose;
use pfront_core::bvtt::{Cursor, NodePair, PairQuery, Query, SelfQuery, TrianglePair, Work};
use pfront_cpu::{Schedule, Settings, Traversal};
use pfront_scenes::{Scene, TriMesh};
use std::ops::ControlFlow;

const SHARES: [f64; 5] = [0.0, 0.1, 0.5, 0.9, 1.0];

/// What lies below some nodes, in no order, and what it took.
fn below(query: &impl Query, nodes: &[NodePair]) -> (Vec<TrianglePair>, Work) {
    let (mut pairs, mut cursor) = (Vec::new(), Cursor::at(NodePair::default()));
    let before = cursor.work();
    assert_eq!(before, Work::default());
    for &node in nodes {
        cursor.restart(node);
        let _ = query.visit(&mut cursor, |pair| {
            pairs.push(pair);
            ControlFlow::Continue(())
        });
    }
    (pairs, cursor.work())
}

/// A frame, all of it: checks it and returns the device's share of the true cost, and how many pairs meet.
fn frame(traversal: &mut Traversal, query: &(impl Query + Sync), share: f64) -> (f64, usize) {
    let mut pairs = vec![TrianglePair { a: 7, b: 7 }; 3];
    let device = |nodes: &[NodePair]| (below(query, nodes), nodes.len());
    let ((found, device), nodes) = traversal.all_beside(query, share, device, &mut pairs);
    assert!(pairs.is_sorted());
    pairs.extend(found);
    pairs.sort();
    let truth = sequential(query);
    let (p, report) = (traversal.workers(), traversal.report());
    assert!(pairs == truth, "p = {p}, {share}: {} pairs, not {}", pairs.len(), truth.len());
    // Nothing is looked at twice.
    let mut whole = query.start();
    let _ = query.visit(&mut whole, |_| ControlFlow::Continue(()));
    let workers = report.work();
    let tests = workers.triangle_tests + device.triangle_tests;
    assert_eq!(tests, whole.work().triangle_tests, "p = {p}, {share}");
    assert_eq!(report.device_nodes, nodes);
    assert!(nodes <= report.nodes && (0.0..=1.0).contains(&report.device_share()));
    if share == 0.0 || share == 1.0 {
        assert_eq!(nodes, share as usize * report.nodes);
    }
    let [mine, theirs] = [device, workers].map(|work| report.cost(work));
    (if mine > 0.0 { mine / (mine + theirs) } else { 0.0 }, truth.len())
}

fn traversals() -> Vec<Traversal> {
    let schedules = [Schedule::Static, Schedule::Stealing, Schedule::Hybrid];
    let all = [1, 2, 7].into_iter().flat_map(|p| schedules.map(|schedule| (p, schedule)));
    all.map(|(p, schedule)| {
        Traversal::new(p).with_settings(Settings { schedule, ..Settings::default() })
    })
    .collect()
}

#[test]
fn two_meshes_that_move_and_jump() {
    for (name, size) in [("worm-gear", 7_600), ("torus-knots", 5_000)] {
        let frames = Frames::named(name, size);
        for mut traversal in traversals() {
            let mut met = 0;
            for (i, at) in [40, 41, 42, 43, 90, 91, 5, 41, 42, 43].into_iter().enumerate() {
                // Shares change from frame to frame.
                met += frame(&mut traversal, &frames.query(at), SHARES[(7 * i + i / 3) % 5]).1;
                met += frame(&mut traversal, &frames.query(at), SHARES[i % 5]).1;
            }
            assert!(met > 0, "{name}");
        }
    }
}

#[test]
fn one_mesh_that_deforms() {
    let scene = Scene::by_name("sheet", Some(5_000)).unwrap();
    let mut body = Body::new(scene.meshes[0].clone());
    let (mut traversals, mut positions, mut met) = (traversals(), Vec::new(), 0);
    for at in [60, 61, 62, 150, 151] {
        scene.positions(at, &mut positions);
        body.deform(&positions);
        let query = SelfQuery::new(body.bvh());
        for traversal in &mut traversals {
            for share in SHARES {
                met += frame(traversal, &query, share).1;
            }
        }
    }
    assert!(met > 0);
}

#[test]
fn nothing_and_nearly_nothing() {
    let empty = Body::new(TriMesh::default());
    let one = Body::new(TriMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
    });
    let far = Pose::from_translation([9.0, 0.0, 0.0]);
    for (a, b, pose, met) in [
        (&empty, &empty, Pose::IDENTITY, 0),
        (&one, &empty, Pose::IDENTITY, 0),
        (&one, &one, far, 0),
        (&one, &one, Pose::IDENTITY, 1),
    ] {
        let query = PairQuery::new(a.bvh(), b.bvh(), pose).unwrap();
        for mut traversal in traversals() {
            for share in SHARES.into_iter().chain([f64::NAN, -3.0, f64::INFINITY]) {
                assert_eq!(frame(&mut traversal, &query, share).1, met);
                assert_eq!(frame(&mut traversal, &SelfQuery::new(a.bvh()), share).1, 0);
            }
        }
    }
}

/// Costs of nodes that a device walks are never measured then; what it gets is still about what was asked for,
/// however long that goes on.
#[test]
fn a_device_gets_about_the_share_that_it_was_to_get() {
    let frames = Frames::named("torus-knots", 20_000);
    for p in [1, 2, 7] {
        for share in [0.1, 0.5, 0.9] {
            let mut traversal = Traversal::new(p);
            // In motion, and then at rest.
            let got = Vec::from_iter((0..60).map(|i| {
                let (got, _) = frame(&mut traversal, &frames.query(40 + i.min(40)), share);
                assert!((traversal.report().device_share() - share).abs() < 0.02);
                got
            }));
            let mean = got.iter().sum::<f64>() / got.len() as f64;
            assert!((mean - share).abs() < 0.03, "p = {p}, {share}: {mean}");
            let far = got.iter().find(|&got| (got - share).abs() > 0.15);
            assert_eq!(far, None, "p = {p}, {share}");
        }
    }
}

#[test]
fn a_share_changes_nothing_afterwards() {
    let frames = Frames::named("spheres", 3_000);
    let mut traversal = Traversal::new(3);
    let mut pairs = Vec::new();
    for i in 0..6 {
        let query = frames.query(50 + i);
        frame(&mut traversal, &query, 0.4);
        assert!(traversal.report().device_nodes > 0 && traversal.report().device_cost > 0.0);
        traversal.all(&query, &mut pairs);
        assert!(pairs == sequential(&query));
        assert_eq!((traversal.report().device_nodes, traversal.report().device_share()), (0, 0.0));
    }
}
