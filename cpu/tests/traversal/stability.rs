//! Where the front method could fail: imbalance in counted work, case by case.
//!
//! Limits are those that the project set itself. `w_max` is the dearest BVTT node that no front splits, a
//! leaf pair or one that is not worth it: whatever partition there is, its worker takes that long, which is
//! what p·w_max/W says relative to the mean. It comes from the BVTT and not from the front that is
//! tested.
//!
//! One exception: below [`THIN`] box tests a worker, about a microsecond, a single node that is too small
//! to be worth splitting is most of what a worker does, and more so the further its estimate is off: no
//! forecast meets the limits (measured with 1024 workers of 26 tests each: 12 in a first frame, where
//! p·w_max/W is 2.4). There [`Frame::holds`] widens them.

use crate::common::{Body, sequential};
use pfront_core::Pose;
use pfront_core::front::{Alpha, Estimate, Extent, Grain};
use pfront_core::query::{Cursor, NodePair, PairQuery, Query, SelfQuery, Work};
use pfront_cpu::{Report, Schedule, Settings, Traversal};
use pfront_scenes::{Scene, TriMesh, icosphere};
use std::ops::ControlFlow;

/// Box tests per worker.
const THIN: f64 = 100.0;

/// As in [`pfront_core::front`]: nodes that cost less are not split.
const WORTH_SPLITTING: f64 = 64.0;

const WORKERS: [usize; 5] = [1, 2, 7, 64, 1024];

/// Static partition: nothing but the front and its dealing makes up the balance.
fn traversal(workers: usize) -> Traversal {
    let settings =
        Settings { schedule: Schedule::Static, grain: Grain::uniform(16.0), ..Settings::default() };
    Traversal::new(workers).with_settings(settings)
}

/// How large an imbalance may be, and how many times p·w_max/W where there is little to do.
#[derive(Clone, Copy)]
struct Limit {
    usual: f64,
    thin: f64,
}

const COHERENT: Limit = Limit { usual: 1.5, thin: 2.0 };
const ESTIMATED: Limit = Limit { usual: 2.5, thin: 5.0 };

/// What a frame did, and how good it could have been.
struct Frame<'r> {
    report: &'r Report,
    /// Cost of all workers.
    total: f64,
    /// p·w_max/W.
    dominance: f64,
}

/// A frame, checked against one core.
fn frame<'r, Q: Query + Sync>(traversal: &'r mut Traversal, query: &Q) -> Frame<'r> {
    let mut pairs = Vec::new();
    traversal.all(query, &mut pairs);
    assert!(pairs == sequential(query));
    let report = traversal.report();
    assert!(report.imbalance().is_finite());
    assert!(report.shares.iter().all(|s| s.predicted.is_finite()));
    let total = report.shares.iter().map(|s| report.cost(s.work)).sum();
    let w_max = query.root().map_or(0.0, |root| cost_and_w_max(query, root, report).1);
    let dominance = if total > 0.0 { w_max * report.shares.len() as f64 / total } else { 0.0 };
    Frame { report, total, dominance }
}

/// What a BVTT node costs, and the dearest at or below it that no front splits.
fn cost_and_w_max<Q: Query>(query: &Q, node: NodePair, report: &Report) -> (f64, f64) {
    let mut children = Vec::with_capacity(4);
    let tests = query.expand(node, &mut |child| children.push(child));
    if tests == 0 {
        let mut cursor = Cursor::at(node);
        let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
        let cost = report.cost(cursor.work());
        return (cost, cost);
    }
    let below = children.into_iter().map(|child| cost_and_w_max(query, child, report));
    let (cost, w_max) = below
        .fold((f64::from(tests), 0.0), |(sum, most), (cost, w)| (sum + cost, f64::max(most, w)));
    (cost, if cost < WORTH_SPLITTING { cost } else { w_max })
}

impl Frame<'_> {
    fn coherent_limit(&self) -> Limit {
        Limit { usual: f64::max(1.5, 1.1 * self.dominance), ..COHERENT }
    }

    #[track_caller]
    fn holds(&self, limit: Limit, what: &str) {
        let Self { report, total, dominance } = *self;
        let (imbalance, p, nodes) = (report.imbalance(), report.shares.len(), report.nodes);
        let thin = total / (p as f64) < THIN;
        let limit = if thin { f64::max(4.0, limit.thin * dominance) } else { limit.usual };
        assert!(
            imbalance <= limit,
            "{what}, p = {p}: {imbalance:.2} > {limit:.2}; {nodes} nodes, p·w_max/W {dominance:.2}"
        );
    }
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
            let query = PairQuery::new(sphere.bvh(), sphere.bvh(), here).unwrap();
            let spheres = frame(&mut two, &query);
            scene.positions(60 + i, &mut positions);
            cloth.deform(&positions);
            let query = SelfQuery::new(cloth.bvh());
            let cloth = frame(&mut one, &query);
            if i > 0 {
                spheres.holds(spheres.coherent_limit(), "spheres");
                cloth.holds(cloth.coherent_limit(), "cloth");
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
                let query = PairQuery::new(a.bvh(), b.bvh(), here).unwrap();
                let frame = frame(&mut traversal, &query);
                frame.holds(if i > 0 { COHERENT } else { ESTIMATED }, what);
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
        // A frame like the one before is held to more.
        let course = [
            ("start", at(0.8, 0.0), ESTIMATED),
            ("start", at(0.8005, 0.0), COHERENT),
            ("teleport", at(-0.5, 0.9), ESTIMATED),
            ("teleport", at(-0.5005, 0.9), COHERENT),
            ("loss", at(-3.0, 0.0), COHERENT),
            ("onset", at(0.0, 1.1), ESTIMATED),
            ("onset", at(0.0005, 1.1), COHERENT),
        ];
        let mut traversal = traversal(p);
        for (what, query, limit) in course {
            frame(&mut traversal, &query).holds(limit, what);
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
                let frame = frame(&mut traversal, &query);
                if i > 0 {
                    frame.holds(frame.coherent_limit(), what);
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
                let frame = frame(&mut traversal, &query);
                if i > 0 {
                    frame.holds(frame.coherent_limit(), what);
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
        // A fixed point with few workers. With many, a swing of 0.4 % remains: what a node costs depends
        // a little on whether those above it are split, as a walk takes two levels in a step.
        let mut last = [0; 8];
        for nodes in &mut last {
            traversal.count(&query);
            *nodes = traversal.report().nodes;
        }
        let swing = last.iter().max().unwrap() - last.iter().min().unwrap();
        assert!(swing <= if p > 7 { settled / 100 } else { 0 }, "p = {p}: {last:?}");
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
