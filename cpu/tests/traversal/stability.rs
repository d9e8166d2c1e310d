//! Where the front method could fail: imbalance in counted work, case by case.
//!
//! Limits are those that the project set itself. `w_max` is the dearest node of the front: whatever
//! partition there is, its worker takes that long, which is what p·w_max/W says relative to the mean.
//!
//! One exception: below [`THIN`] box tests a worker, about a microsecond, a single node that is too small
//! to be worth splitting is most of what a worker does, and no forecast meets the limits (measured with
//! 1024 workers: 13 after an onset, 28 for two squares that touch along an edge, always within 2 % of
//! p·w_max/W where above 4). There [`holds`] widens them.

use crate::common::{Body, Frames, sequential};
use pfront_core::Pose;
use pfront_core::front::{Alpha, Estimate, Extent, Grain};
use pfront_core::query::{PairQuery, Query, SelfQuery, Work};
use pfront_cpu::{Report, Schedule, Settings, Traversal};
use pfront_scenes::{Scene, TriMesh, icosphere};

/// Box tests per worker.
const THIN: f64 = 100.0;

const WORKERS: [usize; 5] = [1, 2, 7, 64, 1024];

/// Static partition: nothing but the front and its dealing makes up the balance.
fn traversal(workers: usize) -> Traversal {
    let settings =
        Settings { schedule: Schedule::Static, grain: Grain::uniform(16.0), ..Settings::default() };
    Traversal::new(workers).with_settings(settings)
}

/// A frame, checked against one core.
fn frame<Q: Query + Sync>(traversal: &mut Traversal, query: &Q) {
    let mut pairs = Vec::new();
    traversal.all(query, &mut pairs);
    assert!(pairs == sequential(query));
    let report = traversal.report();
    assert!(report.imbalance().is_finite());
    assert!(report.shares.iter().all(|s| s.predicted.is_finite()));
}

/// p·w_max/W.
fn dominance(report: &Report) -> f64 {
    let total: f64 = report.shares.iter().map(|s| report.cost(s.work)).sum();
    if total > 0.0 { report.dearest_node * report.shares.len() as f64 / total } else { 0.0 }
}

fn coherent_limit(report: &Report) -> f64 {
    f64::max(1.5, 1.1 * dominance(report))
}

#[track_caller]
fn holds(report: &Report, limit: f64, what: &str) {
    let (imbalance, p) = (report.imbalance(), report.shares.len());
    let dominance = dominance(report);
    let nodes = report.nodes;
    let mean = report.shares.iter().map(|s| report.cost(s.work)).sum::<f64>() / p as f64;
    let limit = if mean < THIN { limit.max(4.0).max(1.5 * dominance) } else { limit };
    assert!(
        imbalance <= limit,
        "{what}, p = {p}: {imbalance:.2} > {limit:.2}; {nodes} nodes, p·w_max/W {dominance:.2}"
    );
}

fn pose(turn: f32, [x, y, z]: [f32; 3]) -> Pose {
    let (sin, cos) = turn.sin_cos();
    Pose::new([[cos, -sin, 0.0, x], [sin, cos, 0.0, y], [0.0, 0.0, 1.0, z]])
}

fn grid(side: u32, height: impl Fn(f32, f32) -> f32) -> TriMesh {
    let at = |i: u32| i as f32 / side as f32;
    let points = (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j)));
    let cells = (0..side).flat_map(|j| (0..side).map(move |i| j * (side + 1) + i));
    TriMesh {
        positions: points.map(|(i, j)| [at(i), at(j), height(at(i), at(j))]).collect(),
        triangles: cells
            .flat_map(|c| [[c, c + 1, c + side + 1], [c + 1, c + side + 2, c + side + 1]])
            .collect(),
    }
}

#[test]
fn coherent_motion() {
    let sphere = Body::new(icosphere(20_000));
    let scene = Scene::by_name("sheet", Some(8_000)).unwrap();
    let mut cloth = Body::new(scene.meshes[0].clone());
    let mut positions = Vec::new();
    for p in WORKERS {
        let (mut two, mut one) = (traversal(p), traversal(p));
        for i in 0..8 {
            let here = pose(0.001 * i as f32, [0.3 + 0.0005 * i as f32, 0.1, 0.0]);
            frame(&mut two, &PairQuery::new(sphere.bvh(), sphere.bvh(), here).unwrap());
            scene.positions(60 + i, &mut positions);
            cloth.deform(&positions);
            frame(&mut one, &SelfQuery::new(cloth.bvh()));
            if i > 0 {
                holds(two.report(), coherent_limit(two.report()), "spheres");
                holds(one.report(), coherent_limit(one.report()), "cloth");
            }
        }
    }
}

#[test]
fn boxes_without_volume() {
    let flat = Body::new(grid(60, |_, _| 0.0));
    let other = Body::new(grid(47, |_, _| 0.0));
    let steps = Body::new(grid(40, |x, _| (8.0 * x).floor() / 8.0));
    for p in WORKERS {
        for (what, a, b, x) in [
            ("coplanar", &flat, &other, 0.3),
            ("touching along a line", &flat, &other, 1.0),
            ("flat on steps", &flat, &steps, 0.0),
        ] {
            let mut traversal = traversal(p);
            for i in 0..4 {
                let here = Pose::from_translation([x, 0.0, 0.0]);
                frame(&mut traversal, &PairQuery::new(a.bvh(), b.bvh(), here).unwrap());
                let limit = if i > 0 { coherent_limit(traversal.report()).min(2.5) } else { 2.5 };
                holds(traversal.report(), limit, what);
            }
        }
    }
}

#[test]
fn teleport_onset_and_loss() {
    let sphere = Body::new(icosphere(20_000));
    let at = |x: f32, y: f32| {
        PairQuery::new(sphere.bvh(), sphere.bvh(), pose(0.3, [x, y, 0.1])).unwrap()
    };
    for p in WORKERS {
        // Where, and whether the frame is like the one before.
        let course = [
            ("start", at(0.8, 0.0), false),
            ("start", at(0.8005, 0.0), true),
            ("teleport", at(-0.5, 0.9), false),
            ("teleport", at(-0.5005, 0.9), true),
            ("loss", at(-3.0, 0.0), true),
            ("onset", at(0.0, 1.1), false),
            ("onset", at(0.0005, 1.1), true),
        ];
        let mut traversal = traversal(p);
        for (what, query, coherent) in &course {
            frame(&mut traversal, query);
            let report = traversal.report();
            holds(report, if *coherent { 1.5 } else { 2.5 }, what);
        }
    }
}

#[test]
fn skewed_trees_and_few_nodes() {
    // Each triangle half the size of the last: a chain of nodes.
    let shrinking = (0..60).map(|i| 0.5_f32.powi(i));
    let chain = TriMesh {
        positions: shrinking.flat_map(|s| [[s, 0.0, 0.0], [s, s, 0.0], [s, 0.0, s]]).collect(),
        triangles: (0..60).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    };
    let wedge = TriMesh {
        positions: vec![[-1.5, 0.1, 0.1], [1.5, 0.2, 0.1], [0.1, 1.5, 0.3]],
        triangles: vec![[0, 1, 2]],
    };
    let (chain, wedge) = (Body::new(chain), Body::new(wedge));
    let (sphere, small) = (Body::new(icosphere(20_000)), Body::new(icosphere(80)));
    for p in WORKERS {
        for (what, a, b) in [
            ("chain", &chain, &chain),
            ("one against 20,000", &sphere, &wedge),
            ("20,000 against one", &wedge, &sphere),
            ("few", &small, &small),
        ] {
            let query = PairQuery::new(a.bvh(), b.bvh(), pose(0.2, [0.05, 0.0, 0.0])).unwrap();
            let mut traversal = traversal(p);
            for i in 0..4 {
                frame(&mut traversal, &query);
                let report = traversal.report();
                if i > 0 {
                    holds(report, 1.1 * f64::max(1.36, dominance(report)), what);
                }
            }
        }
    }
}

#[test]
fn identical_and_contained() {
    let (sphere, ball) = (Body::new(icosphere(8_000)), Body::new(icosphere(2_000)));
    let shrunk = Pose::new([[0.5, 0.0, 0.0, 0.1], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]]);
    for p in WORKERS {
        for (what, a, b, here) in
            [("identical", &sphere, &sphere, Pose::IDENTITY), ("contained", &sphere, &ball, shrunk)]
        {
            let query = PairQuery::new(a.bvh(), b.bvh(), here).unwrap();
            let mut traversal = traversal(p);
            for i in 0..4 {
                frame(&mut traversal, &query);
                if i > 0 {
                    holds(traversal.report(), coherent_limit(traversal.report()), what);
                }
            }
        }
    }
}

#[test]
fn a_still_scene_settles() {
    let sphere = Body::new(icosphere(20_000));
    let query = PairQuery::new(sphere.bvh(), sphere.bvh(), pose(0.3, [0.6, 0.1, 0.0])).unwrap();
    for p in WORKERS {
        let mut traversal = traversal(p);
        // The depth of the starting front takes some frames to suit the scene.
        for _ in 0..10 {
            traversal.count(&query);
        }
        let settled = traversal.report().nodes;
        for _ in 0..200 {
            traversal.count(&query);
            let nodes = traversal.report().nodes;
            assert!(nodes.abs_diff(settled) * 20 <= settled, "p = {p}: {nodes}, not {settled}");
        }
        // A fixed point up to p = 64. With 1024 workers, where nodes cost about the 8 tests below which
        // none is split, a cycle of eight frames and 0.4 % remains.
        let mut last = [0; 8];
        for nodes in &mut last {
            traversal.count(&query);
            *nodes = traversal.report().nodes;
        }
        let swing = last.iter().max().unwrap() - last.iter().min().unwrap();
        assert!(swing <= if p > 64 { settled / 100 } else { 0 }, "p = {p}: {last:?}");
    }
}

#[test]
fn grain_and_estimate_hardly_change_the_work() {
    let sphere = Body::new(icosphere(20_000));
    let query = PairQuery::new(sphere.bvh(), sphere.bvh(), pose(0.3, [0.6, 0.1, 0.0])).unwrap();
    let work = |settings, p| {
        let mut traversal = Traversal::new(p).with_settings(settings);
        for _ in 0..3 {
            traversal.count(&query);
        }
        let Work { box_tests, triangle_tests } = traversal.report().work();
        box_tests as f64 + 4.0 * triangle_tests as f64
    };
    let default = Settings { schedule: Schedule::Static, ..Settings::default() };
    for p in WORKERS {
        let usual = work(default, p);
        for factor in [0.5, 2.0] {
            let Grain { measured, estimated } = default.grain;
            let grain = Grain { measured: factor * measured, estimated: factor * estimated };
            let ratio = work(Settings { grain, ..default }, p) / usual;
            assert!((0.85..1.15).contains(&ratio), "g × {factor}, p = {p}: {ratio}");
        }
        for extent in [Extent::Volume, Extent::Penetration] {
            for alpha in [Alpha::Constant, Alpha::Density] {
                let estimate = Estimate { extent, alpha };
                let ratio = work(Settings { estimate, ..default }, p) / usual;
                assert!((0.85..1.15).contains(&ratio), "{estimate:?}, p = {p}: {ratio}");
            }
        }
    }
}

/// Fronts of thousands of nodes are made in parts, one for so many threads; and where there is too little
/// room for all, or for one part, that changes nothing.
#[test]
fn threads_do_not_show_in_a_front() {
    let frames = Frames::named("torus-knots", 40_000);
    let reports = |threads, p, most_nodes| -> Vec<Report> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = Settings { schedule: Schedule::Static, most_nodes, ..Settings::default() };
        let mut traversal = Traversal::new(p).with_settings(settings);
        let mut frame = |i| {
            pool.install(|| traversal.count(&frames.query(i)));
            traversal.report().clone()
        };
        [40, 41, 42, 90, 91].map(&mut frame).into()
    };
    for (p, most_nodes) in
        [(1024, 9_000), (1024, 20_000), (1024, 1 << 20), (64, 9_000), (200, 12_000)]
    {
        let one = reports(1, p, most_nodes);
        for threads in [1, 3, 8] {
            let several = reports(threads, p, most_nodes);
            for (one, several) in one.iter().zip(&several) {
                println!(
                    "p {p} most {most_nodes} threads {threads}: {} {} {:.3} {:.3} {} {}",
                    one.nodes,
                    several.nodes,
                    one.imbalance(),
                    several.imbalance(),
                    one.front_box_tests,
                    several.front_box_tests
                );
            }
        }
    }
}
