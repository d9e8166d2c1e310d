//! Tests of fronts: whole cuts at any capacity, sound costs on any boxes, steady from frame to frame.

extern crate std;

use super::*;
use crate::bvh::{self, BuildOptions, BvhStorage};
use crate::bvtt::{Cursor, PairQuery, SelfQuery, TrianglePair};
use crate::front::partition::{Load, greedy};
use crate::{Bvh, Mesh, Node, Pose};
use core::cell::RefCell;
use core::ops::ControlFlow;
use std::vec;
use std::vec::Vec;

/// More than any front here has.
const CAPACITY: usize = if cfg!(miri) { 1 << 8 } else { 1 << 16 };

const ESTIMATES: [Estimate; 4] = [
    Estimate { extent: Extent::Volume, alpha: Alpha::Density },
    Estimate { extent: Extent::Volume, alpha: Alpha::Constant },
    Estimate { extent: Extent::Penetration, alpha: Alpha::Density },
    Estimate { extent: Extent::Penetration, alpha: Alpha::Constant },
];

#[test]
fn any_front_is_a_whole_cut() {
    let bumpy = Body::bumpy(24);
    let pair = PairQuery::new(bumpy.bvh(), bumpy.bvh(), tilt(0.3)).unwrap();
    let itself = SelfQuery::new(bumpy.bvh());
    let mut random = 7_u32;
    let (few, many) =
        if cfg!(miri) { (3..4, &[30][..]) } else { (1..40, &[64, 100, 1000, CAPACITY][..]) };
    for capacity in few.chain(many.iter().copied()) {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let depth = random >> 8 & 7;
        let grain = Grain { measured: f64::from(random >> 12 & 15), estimated: 9.0 };
        let estimate = ESTIMATES[(random >> 20 & 3) as usize];
        cut(&pair, capacity, depth, grain, estimate);
        cut(&itself, capacity, depth, grain, estimate);
    }
}

/// Two frames, the second with the costs of the first: same pairs as the whole walk.
fn cut(query: &impl Query, capacity: usize, depth: u32, grain: Grain, estimate: Estimate) {
    let whole = pairs(query, query.root());
    let mut memory = vec![PastCost::default(); capacity];
    let mut remembered = 0;
    for _ in 0..2 {
        let mut nodes = vec![FrontNode::default(); capacity];
        let past = Past::new(&memory[..remembered]);
        let mut front = Front::new(&mut nodes);
        front.start(query, 0, depth, estimate, past).unwrap();
        front.assert_well_formed();
        front.refine(5, grain, estimate, past, |_| query);
        front.assert_well_formed();
        let found = RefCell::new(Vec::new());
        let walked = |node: &FrontNode| walk(query, node.pair, &mut found.borrow_mut());
        Past::record(&mut memory, front.nodes(), walked).unwrap();
        assert_eq!(sorted(found.into_inner()), whole);
        remembered = front.nodes().len();
    }
}

#[test]
fn a_front_without_room_for_a_root_is_refused() {
    let body = Body::sheet(4, |_, _| 0.0);
    let query = SelfQuery::new(body.bvh());
    let mut nodes = [FrontNode::default(); 1];
    let mut front = Front::new(&mut nodes);
    let mut start = |n| front.start(&query, n, 3, Estimate::default(), Past::NOTHING);
    assert_eq!(start(0), Ok(()));
    let error = CapacityError { buffer: "front", needed: 2, capacity: 1 };
    assert_eq!(start(1), Err(error));
}

#[test]
fn one_front_serves_many_queries() {
    let body = Body::sheet(if cfg!(miri) { 2 } else { 16 }, |x, y| x * y);
    let queries: Vec<_> = [0.0, 9.0, 0.2, 0.4]
        .map(|z| PairQuery::new(body.bvh(), body.bvh(), tilt(z)).unwrap())
        .into();
    let mut nodes = vec![FrontNode::default(); 5000];
    let mut front = Front::new(&mut nodes);
    for (query, number) in queries.iter().zip(0..) {
        front.start(query, number, 2, Estimate::default(), Past::NOTHING).unwrap();
    }
    let grain = Grain::default();
    front.refine(4, grain, Estimate::default(), Past::NOTHING, |n| &queries[n as usize]);
    front.assert_well_formed();
    for (query, number) in queries.iter().zip(0..) {
        let own = front.nodes().iter().filter(|n| n.query == number).map(|n| n.pair);
        assert_eq!(pairs(query, own), pairs(query, query.root()));
    }
}

/// Where there is enough to do for all to be split that costs more, every node costs less than ε·W/p,
/// and greedy stays within (1 + ε)·W/p.
#[test]
fn epsilon_bounds_the_predicted_makespan() {
    let body = Body::bumpy(120);
    let query = PairQuery::new(body.bvh(), body.bvh(), tilt(0.1)).unwrap();
    for (epsilon, workers) in [(1.0, 2), (0.5, 7), (0.2, 16), (0.1, 3)] {
        for estimate in ESTIMATES.into_iter().step_by(if cfg!(miri) { 3 } else { 1 }) {
            let mut nodes = vec![FrontNode::default(); CAPACITY];
            let mut front = Front::new(&mut nodes);
            front.start(&query, 0, 3, estimate, Past::NOTHING).unwrap();
            let grain = Grain::epsilon(epsilon);
            front.refine(workers, grain, estimate, Past::NOTHING, |_| &query);
            assert!(!front.is_full());
            let mean = front.cost() / workers as f64;
            let bound = epsilon * mean;
            // There is never enough to do on miri's small bodies.
            let enough = !cfg!(miri);
            assert!(bound > f64::from(super::refine::WORTH_SPLITTING) || !enough, "{bound}");
            let dearest = front.nodes().iter().fold(0.0, |most, n| f64::max(most, n.cost.into()));
            assert!(dearest < bound * 1.000_001 || !enough, "{dearest} of {mean}");
            let mut loads = vec![Load::default(); workers];
            let makespan = greedy(front.nodes_mut(), &mut loads);
            assert!(makespan <= (mean + if enough { bound } else { dearest }) * 1.000_001);
        }
    }
}

/// By powers of two, so that all coordinates round alike: about 0.01, 1 and 100.
#[test]
fn the_unit_of_length_is_of_no_account() {
    for estimate in ESTIMATES.into_iter().step_by(if cfg!(miri) { 3 } else { 1 }) {
        let fronts = [1.0 / 128.0, 1.0, 128.0].map(|unit| {
            let mut body = Body::bumpy(40);
            let positions = body.positions.iter().map(|p| p.map(|x| unit * x)).collect();
            body = Body::of(positions, body.triangles.into_iter());
            let mut here = tilt(0.1);
            here.rows.iter_mut().for_each(|row| row[3] *= unit);
            let query = PairQuery::new(body.bvh(), body.bvh(), here).unwrap();
            let mut nodes = vec![FrontNode::default(); CAPACITY];
            let mut front = Front::new(&mut nodes);
            front.start(&query, 0, 2, estimate, Past::NOTHING).unwrap();
            front.refine(4, Grain::default(), estimate, Past::NOTHING, |_| &query);
            (front.cost(), front.nodes().iter().map(|n| n.pair).collect::<Vec<_>>())
        });
        let [small, usual, large] = fronts;
        assert!((small.0 / usual.0 - 1.0).abs() < 1e-6 && small.1 == usual.1);
        assert!((large.0 / usual.0 - 1.0).abs() < 1e-6 && large.1 == usual.1);
    }
}

#[test]
fn boxes_without_volume_get_sound_costs() {
    let flat = Body::sheet(if cfg!(miri) { 1 } else { 12 }, |_, _| 0.0);
    let point = Body::of(
        vec![[0.5, 0.5, 0.0]; 30],
        (0..if cfg!(miri) { 2 } else { 10 }).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]),
    );
    let huge = Body::of(
        vec![[-3e37, 0.0, 0.0], [3e37, 0.0, 0.0], [0.0, 3e37, 3e37]],
        std::iter::repeat_n([0, 1, 2], if cfg!(miri) { 2 } else { 40 }),
    );
    let lifted = |z| Pose::from_translation([0.0, 0.0, z]);
    let cases = [
        (&flat, &flat, Pose::IDENTITY),
        (&flat, &flat, Pose::from_translation([1.0, 0.0, 0.0])),
        (&flat, &point, Pose::IDENTITY),
        (&point, &point, Pose::IDENTITY),
        (&huge, &huge, Pose::IDENTITY),
        // In one plane they need integers so wide that miri would take minutes.
        (&huge, &flat, lifted(if cfg!(miri) { 1e37 } else { 0.0 })),
    ];
    for (case, (a, b, pose)) in cases.into_iter().enumerate() {
        let (first, step) = if cfg!(miri) { (case % 4, 4) } else { (0, 1) };
        for estimate in ESTIMATES.into_iter().skip(first).step_by(step) {
            let query = PairQuery::new(a.bvh(), b.bvh(), pose).unwrap();
            cut(&query, if cfg!(miri) { 9 } else { 3000 }, 3, Grain::default(), estimate);
        }
    }
}

#[test]
fn a_jump_is_noticed_and_motion_is_not() {
    let body = Body::bumpy(40);
    let place = |x: f32| {
        let mut moved = tilt(0.0);
        moved.rows[0][3] += x;
        PairQuery::new(body.bvh(), body.bvh(), moved).unwrap()
    };
    // On the few triangles that miri can bear, any motion is a jump.
    let large = !cfg!(miri);
    for depth in if cfg!(miri) { 2..3 } else { 1..6 } {
        let mut frames = Still::new(depth);
        frames.frame(&place(0.0));
        assert!(frames.frame(&place(0.001)) > 0.9 || !large);
        // A deeper starting front asks for nodes below those of the last frame.
        frames.depth += 1;
        assert!(frames.frame(&place(0.002)) > 0.9 || !large);
    }
    let mut frames = Still::new(4);
    frames.frame(&place(0.7));
    assert!(frames.frame(&place(-0.7)) < COHERENT);
}

#[test]
fn a_still_scene_settles() {
    let body = Body::bumpy(60);
    let query = PairQuery::new(body.bvh(), body.bvh(), tilt(0.05)).unwrap();
    let mut frames = Still::new(3);
    frames.frame(&query);
    frames.frame(&query);
    frames.frame(&query);
    let settled = frames.nodes;
    for _ in 0..if cfg!(miri) { 1 } else { 200 } {
        frames.frame(&query);
        assert!(frames.nodes.abs_diff(settled) * 20 <= settled, "{} {settled}", frames.nodes);
    }
    let last = frames.nodes;
    frames.frame(&query);
    assert_eq!(frames.nodes, last);
}

/// Frames that remember.
struct Still {
    memory: Vec<PastCost>,
    nodes: usize,
    depth: u32,
}

impl Still {
    fn new(depth: u32) -> Self {
        Self { memory: vec![PastCost::default(); CAPACITY], nodes: 0, depth }
    }

    fn frame(&mut self, query: &impl Query) -> f64 {
        let estimate = Estimate::default();
        let mut nodes = vec![FrontNode::default(); CAPACITY];
        let mut front = Front::new(&mut nodes);
        let past = Past::new(&self.memory[..self.nodes]);
        front.start(query, 0, self.depth, estimate, past).unwrap();
        let found = front.found(past);
        front.refine(8, Grain::default(), estimate, past, |_| query);
        front.assert_well_formed();
        self.nodes = front.nodes().len();
        Past::record(&mut self.memory, front.nodes(), |n| walk(query, n.pair, &mut Vec::new()))
            .unwrap();
        found
    }
}

fn pairs(query: &impl Query, roots: impl IntoIterator<Item = NodePair>) -> Vec<TrianglePair> {
    let mut found = Vec::new();
    for root in roots {
        walk(query, root, &mut found);
    }
    sorted(found)
}

/// Adds the pairs below a node pair to `found`; returns what it cost to find them.
fn walk(query: &impl Query, root: NodePair, found: &mut Vec<TrianglePair>) -> f32 {
    let mut cursor = Cursor::at(root);
    let _ = query.visit(&mut cursor, |pair| {
        found.push(pair);
        ControlFlow::Continue(())
    });
    let work = cursor.work();
    (1 + work.box_tests + 4 * work.triangle_tests) as f32
}

fn sorted(mut pairs: Vec<TrianglePair>) -> Vec<TrianglePair> {
    pairs.sort_unstable();
    pairs
}

/// A turn about x by a third, and a lift.
fn tilt(z: f32) -> Pose {
    Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 0.8, -0.6, 0.3], [0.0, 0.6, 0.8, z - 0.3]])
}

struct Body {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Body {
    fn of(positions: Vec<[f32; 3]>, triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let triangles: Vec<_> = triangles.collect();
        let n = triangles.len();
        let mut body =
            Self { positions, triangles, nodes: vec![Node::EMPTY; 2 * n], order: vec![0; n] };
        let mesh = Mesh::new(&body.positions, &body.triangles).unwrap();
        let storage = BvhStorage { nodes: &mut body.nodes, order: &mut body.order };
        let mut scratch = vec![0; bvh::morton_scratch_bound(n)];
        // Small leaves make a tree of the few triangles that miri can bear.
        let options =
            BuildOptions { leaf_size: if cfg!(miri) { 1 } else { 4 }, ..BuildOptions::default() };
        let used = bvh::morton(mesh, &options, storage, &mut scratch).unwrap().nodes().len();
        body.nodes.truncate(used);
        body
    }

    /// A sheet with hills; a small one for miri, which is slow.
    fn bumpy(side: u32) -> Self {
        let side = if cfg!(miri) { 2 } else { side };
        Self::sheet(side, |x, y| 0.1 * (7.0 * x).sin() * (9.0 * y).cos())
    }

    /// A grid of 2·side² triangles over the unit square.
    fn sheet(side: u32, height: impl Fn(f32, f32) -> f32) -> Self {
        let at = |i: u32| i as f32 / side as f32;
        let grid = (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j)));
        let positions = grid.map(|(i, j)| [at(i), at(j), height(at(i), at(j))]).collect();
        let cells = (0..side).flat_map(|j| (0..side).map(move |i| j * (side + 1) + i));
        let triangles =
            cells.flat_map(|c| [[c, c + 1, c + side + 1], [c + 1, c + side + 2, c + side + 1]]);
        Self::of(positions, triangles)
    }

    fn bvh(&self) -> Bvh<'_> {
        let mesh = Mesh::new_unchecked(&self.positions, &self.triangles);
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }
}
