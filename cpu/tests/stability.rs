//! Where p-partition fronts could fail: named scenes, each with many numbers of workers under a static schedule, in counted
//! work, so that figures are the same on every machine. Each frame's pairs are those of one core.
//!
//! Limits are those that the project set itself. `w_max` is the dearest BVTT node that no front splits, a leaf pair or one
//! that is not worth it: whatever partition there is, its worker takes that long, which is what p·w_max/W says relative
//! to the mean. It comes from the BVTT and not from the front that is judged.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront_core::bvh::{self, BuildOptions, BvhStorage, Refit, node_bound};
use pfront_core::bvtt::{Cursor, NodePair, PairBvtt, Query, SelfBvtt, TrianglePair};
use pfront_core::{Bvh, Mesh, Node, Pose};
use pfront_cpu::{Pool, Report, Schedule, Settings, Traversal};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Scene, icosphere};
use std::collections::HashMap;
use std::ops::ControlFlow;

const WORKERS: [usize; 5] = [1, 2, 7, 64, 1024];

/// As in [`pfront_core::front`]: nodes that cost less are not split.
const WORTH_SPLITTING: f64 = 64.0;

/// Box tests per worker below which a single node that is too small to be worth splitting is most of what a worker does.
const THIN: f64 = 100.0;

/// The limit on the imbalance of a frame: busiest worker over mean.
#[derive(Clone, Copy, PartialEq)]
enum Bound {
    /// Nothing is asked of a first frame.
    None,
    /// A frame like the last: at most max(1.5, 1.1·p·w_max/W); a contact that comes where there was none adds its cost to a
    /// worker that has its full share.
    Coherent,
    /// A frame like the last in which no node dominates: at most 1.5.
    Even,
    /// A frame unlike the last, whose costs are estimates: at most 2.5.
    Estimated,
    /// Little to divide: at most 1.1·max(1.36, p·w_max/W); workers may be idle.
    Scarce,
}

/// The frames of two meshes.
type Steps = Vec<(Bound, Pose)>;

struct Body {
    mesh: MeshData,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Body {
    fn new(mesh: MeshData) -> Self {
        let n = mesh.triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let view = Mesh::new(&mesh.positions, &mesh.triangles).unwrap();
        let mut scratch = vec![Node::EMPTY; n];
        let used = bvh::sah(view, &BuildOptions::default(), storage, &mut scratch).unwrap();
        let used = used.nodes().len();
        nodes.truncate(used);
        Self { mesh, nodes, order }
    }

    fn bvh(&self) -> Bvh<'_> {
        let mesh = Mesh::new_unchecked(&self.mesh.positions, &self.mesh.triangles);
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }
}

/// The costs of the BVTT nodes of a frame and of the last.
#[derive(Default)]
struct Census {
    costs: HashMap<NodePair, f64>,
    last: HashMap<NodePair, f64>,
    /// The cost of the dearest node that no front splits.
    w_max: f64,
    /// The most by which the cost of a node has risen that no front split.
    w_rise: f64,
}

impl Census {
    fn take(&mut self, query: &impl Query) {
        std::mem::swap(&mut self.costs, &mut self.last);
        self.costs.clear();
        self.w_rise = 0.0;
        self.w_max = query.root().map_or(0.0, |root| self.cost_and_w_max(query, root).1);
    }

    /// The cost of a BVTT node, and that of the dearest node at or below it that no front splits.
    fn cost_and_w_max(&mut self, query: &impl Query, n: NodePair) -> (f64, f64) {
        let mut children = Vec::new();
        let tests = query.children(n, &mut |child, _| children.push(child));
        let (mut cost, mut w_max) = (f64::from(tests), 0.0);
        for &child in &children {
            let (below, dearest) = self.cost_and_w_max(query, child);
            (cost, w_max) = (cost + below, f64::max(w_max, dearest));
        }
        if tests == 0 {
            let mut cursor = Cursor::at(n);
            let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
            (cost, w_max) = (cursor.work.cost(), cursor.work.cost());
        }
        let last = self.last.get(&n).copied().unwrap_or(0.0);
        if tests == 0 || last < WORTH_SPLITTING {
            self.w_rise = self.w_rise.max(cost - last);
        }
        self.costs.insert(n, cost);
        (cost, if cost < WORTH_SPLITTING { cost } else { w_max })
    }

    fn limit(&self, bound: Bound, report: &Report) -> f64 {
        let total: f64 = report.shares.iter().map(|share| share.work.cost()).sum();
        let p = report.shares.len() as f64;
        let relative = |w: f64| if total > 0.0 { w * p / total } else { 0.0 };
        let (dominance, rise) = (relative(self.w_max), relative(self.w_rise));
        let is_thin = total / p < THIN;
        match bound {
            Bound::None => f64::INFINITY,
            Bound::Coherent => f64::max(1.5, 1.1 * dominance).max(1.1 * (1.0 + rise)),
            Bound::Even => f64::max(1.5, if is_thin { 1.1 * dominance } else { 0.0 }),
            Bound::Estimated if is_thin => f64::max(4.0, 5.0 * dominance),
            Bound::Estimated => 2.5,
            Bound::Scarce => 1.1 * f64::max(1.36, dominance),
        }
    }
}

/// Traversals with each number of workers, and the nodes of their fronts in each frame.
struct Players {
    traversals: Vec<Traversal>,
    nodes: Vec<Vec<f64>>,
    census: Census,
}

impl Players {
    fn new() -> Self {
        let settings = Settings { schedule: Schedule::Static, g: 16.0, ..Settings::default() };
        let traversal = |p| Traversal::new(&Pool::new(p).with_settings(settings));
        let traversals = WORKERS.map(traversal).into();
        Self { traversals, nodes: vec![Vec::new(); WORKERS.len()], census: Census::default() }
    }

    /// Checks the answers and the balance of a frame.
    fn frame<Q: Query + Sync>(&mut self, what: &str, bound: Bound, query: &Q) {
        let (mut expected, mut cursor) = (Vec::new(), query.start());
        let _ = query.visit(&mut cursor, |pair| {
            expected.push(pair);
            ControlFlow::Continue(())
        });
        expected.sort_unstable();
        self.census.take(query);
        let mut pairs: Vec<TrianglePair> = Vec::new();
        for (traversal, nodes) in self.traversals.iter_mut().zip(&mut self.nodes) {
            traversal.all(std::slice::from_ref(query), &mut pairs).unwrap();
            let report = &traversal.report;
            let (found, limit) = (report.imbalance(), self.census.limit(bound, report));
            let what = format!("{what}, frame {}, p = {}", nodes.len(), report.shares.len());
            assert!(pairs == expected, "{what}");
            assert!(found <= limit, "{what}: {found}, at most {limit}");
            assert!(report.shares.iter().all(|share| share.predicted.is_finite()), "{what}");
            nodes.push(report.nodes.max(1) as f64);
        }
    }
}

/// Plays two meshes; returns the nodes of the fronts in each frame, for each number of workers.
fn play(what: &str, a: MeshData, b: MeshData, steps: Steps) -> Vec<Vec<f64>> {
    let (a, b, mut players) = (Body::new(a), Body::new(b), Players::new());
    for (bound, a_from_b) in steps {
        players.frame(what, bound, &PairBvtt::new(a.bvh(), b.bvh(), a_from_b).unwrap());
    }
    players.nodes
}

/// Turned about z, then moved.
fn pose(turn: f32, [x, y, z]: [f32; 3]) -> Pose {
    let (sin, cos) = turn.sin_cos();
    Pose::new([[cos, -sin, 0.0, x], [sin, cos, 0.0, y], [0.0, 0.0, 1.0, z]])
}

fn at(x: f32) -> Pose {
    Pose::from_translation([x, 0.0, 0.0])
}

/// Frames of one bound after a first one, which has another.
fn frames(first: Bound, bound: Bound, poses: impl Iterator<Item = Pose>) -> Steps {
    poses.enumerate().map(|(i, pose)| (if i == 0 { first } else { bound }, pose)).collect()
}

/// The same frame again and again.
fn still(bound: Bound, pose: Pose, count: usize) -> Steps {
    frames(Bound::None, bound, std::iter::repeat_n(pose, count))
}

/// From a place on, along x.
fn moving([x, y]: [f32; 2]) -> impl Iterator<Item = Pose> {
    (0..2).map(move |i| pose(0.3, [x + 0.0005 * i as f32, y, 0.1]))
}

#[test]
fn motion_of_half_a_thousandth_is_coherent() {
    let along = (0..8).map(|i| pose(0.001 * i as f32, [0.3 + 0.0005 * i as f32, 0.1, 0.0]));
    let steps = frames(Bound::None, Bound::Coherent, along);
    play("spheres", icosphere(20_000), icosphere(20_000), steps);
    let scene = Scene::by_name("sheet", Some(8_000)).unwrap();
    let (mut body, mut players) = (Body::new(scene.meshes[0].clone()), Players::new());
    for frame in 60..68 {
        scene.positions(frame, &mut body.mesh.positions);
        let mesh = Mesh::new_unchecked(&body.mesh.positions, &body.mesh.triangles);
        bvh::refit(mesh, &mut body.nodes, &body.order, Refit::default()).unwrap();
        let bound = if frame == 60 { Bound::None } else { Bound::Coherent };
        players.frame("sheet", bound, &SelfBvtt::new(body.bvh()));
    }
}

#[test]
fn boxes_without_volume() {
    // A height field over the unit square.
    let grid = |side: u32, height: fn(f32) -> f32| {
        let at = |i: u32| i as f32 / side as f32;
        let points = (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j)));
        let cells = (0..side).flat_map(|j| (0..side).map(move |i| j * (side + 1) + i));
        let two = |c| [[c, c + 1, c + side + 1], [c + 1, c + side + 2, c + side + 1]];
        MeshData {
            positions: points.map(|(i, j)| [at(i), at(j), height(at(i))]).collect(),
            triangles: cells.flat_map(two).collect(),
        }
    };
    let steps = |x| frames(Bound::Estimated, Bound::Even, std::iter::repeat_n(at(x), 4));
    play("coplanar", grid(60, |_| 0.0), grid(47, |_| 0.0), steps(0.3));
    play("along a line", grid(60, |_| 0.0), grid(47, |_| 0.0), steps(1.0));
    let stairs = grid(40, |x| (8.0 * x).floor() / 8.0);
    play("flat on steps", grid(60, |_| 0.0), stairs, steps(0.0));
}

#[test]
fn contacts_jump_end_and_begin() {
    let anew = |place| frames(Bound::Estimated, Bound::Even, moving(place));
    let jumps = [[0.8, 0.0], [-0.5, 0.9], [0.8, 0.0]].map(anew).concat();
    play("teleport", icosphere(20_000), icosphere(20_000), jumps);
    let loss = frames(Bound::Even, Bound::Even, moving([-3.0, 0.0]));
    let steps = [anew([-0.5, 0.9]), loss, anew([0.0, 1.1])].concat();
    play("onset and loss", icosphere(20_000), icosphere(20_000), steps);
}

#[test]
fn there_is_little_to_divide() {
    // Each triangle half the size of the last: the tree is a chain of nodes.
    let shrinking = (0..60).map(|i| 0.5_f32.powi(i));
    let chain = MeshData::of(shrinking.map(|s| [[s, 0.0, 0.0], [s, s, 0.0], [s, 0.0, s]]));
    let wedge = || MeshData::of([[[-1.5, 0.1, 0.1], [1.5, 0.2, 0.1], [0.1, 1.5, 0.3]]]);
    let steps = || still(Bound::Scarce, pose(0.2, [0.05, 0.0, 0.0]), 4);
    play("chain", chain.clone(), chain, steps());
    play("one of B", icosphere(20_000), wedge(), steps());
    play("one of A", wedge(), icosphere(20_000), steps());
    play("few nodes", icosphere(80), icosphere(80), steps());
}

#[test]
fn meshes_coincide_and_contain_each_other() {
    let steps = |pose| still(Bound::Coherent, pose, 4);
    play("identical", icosphere(8_000), icosphere(8_000), steps(Pose::IDENTITY));
    let half = Pose::new([[0.5, 0.0, 0.0, 0.1], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]]);
    play("contained", icosphere(8_000), icosphere(2_000), steps(half));
}

/// Two bundles of thin triangles along a diagonal: all boxes overlap, as in the mesh pair Generic_Twin_7081.
#[test]
fn all_boxes_overlap() {
    let needles = |lower: f32| {
        let spread = |step: f64, i: u32| (0.2 * (step * f64::from(i)).fract()) as f32;
        MeshData::of((0..700).map(|i| {
            let (x, y) = (spread(0.754_877_666, i), spread(0.569_840_291, i));
            let upper = 1.0 - lower;
            [[x, y, lower], [x + 0.8, y + 0.8, upper], [x + 0.8, y + 0.8001, upper]]
        }))
    };
    let steps = frames(Bound::None, Bound::Coherent, [0.0, 0.0005].map(at).into_iter());
    play("twin", needles(0.0), needles(1.0), steps);
}

/// Frames before a scene is judged: the depth of the starting front takes some to suit it.
const SETTLING: usize = 20;

/// A front does not drift by more than 5 % from one period of a motion to the next, nor goes up and down by more than 0.5 %.
fn settles(nodes: &[Vec<f64>], period: usize) {
    for (nodes, p) in nodes.iter().zip(WORKERS) {
        let settled = &nodes[SETTLING - 1..];
        let drift = |i: usize| (settled[i] / settled[i % period] - 1.0).abs();
        assert!((period..settled.len()).all(|i| drift(i) <= 0.05), "p = {p}: {settled:?}");
        let pairs = settled.as_chunks::<2>().0;
        let [ups, downs] = [0, 1].map(|odd| pairs.iter().map(|pair| pair[odd]).sum::<f64>());
        assert!(2.0 * (ups - downs).abs() / (ups + downs) <= 0.005, "p = {p}: {settled:?}");
    }
}

#[test]
fn fronts_come_to_rest() {
    let here = pose(0.3, [0.6, 0.1, 0.0]);
    let steps = still(Bound::Coherent, here, SETTLING + 200);
    let nodes = play("still", icosphere(8_000), icosphere(8_000), steps);
    settles(&nodes, 1);
    for nodes in &nodes {
        assert!(nodes[nodes.len() - 8..].windows(2).all(|two| two[0] == two[1]), "{nodes:?}");
    }
    let swaying = (0..SETTLING + 48).map(|i| {
        let phase = std::f32::consts::TAU * (i % 16) as f32 / 16.0;
        pose(0.3, [0.6 + 0.01 * phase.sin(), 0.1, 0.0])
    });
    let steps = frames(Bound::None, Bound::Coherent, swaying);
    settles(&play("swaying", icosphere(8_000), icosphere(8_000), steps), 16);
}

/// The work of all, the front included, changes little when g is halved or doubled.
#[test]
fn the_grain_hardly_changes_the_work() {
    let sphere = Body::new(icosphere(20_000));
    let there = Pose::from_translation([0.6, 0.1, 0.0]);
    let query = PairBvtt::new(sphere.bvh(), sphere.bvh(), there).unwrap();
    for workers in WORKERS {
        let [usual, halved, doubled] = [1.0, 0.5, 2.0].map(|factor| {
            let usual = Settings { schedule: Schedule::Static, ..Settings::default() };
            let settings = Settings { g: factor * usual.g, ..usual };
            let mut traversal = Traversal::new(&Pool::new(workers).with_settings(settings));
            let mut pairs = Vec::<TrianglePair>::new();
            (0..4).for_each(|_| traversal.all(std::slice::from_ref(&query), &mut pairs).unwrap());
            traversal.report.work().cost()
        });
        for other in [halved, doubled] {
            assert!((other / usual - 1.0).abs() <= 0.15, "p = {workers}: {usual} and {other}");
        }
    }
}
