//! Tests of fronts: whole cuts at any capacity, sound costs on any boxes, steady from frame to frame.

extern crate std;

use super::history::CostHistory;
use super::node::Path;
use super::*;
use crate::Pose;
use crate::bvh::tests::Owned;
use crate::bvtt::{Cursor, PairBvtt, Query, SelfBvtt, TrianglePair};
use core::ops::ControlFlow;
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::{bumpy, sheet};
use std::vec;
use std::vec::Vec;

/// More nodes than any front here has.
const CAPACITY: usize = 1 << 16;

impl Front<'_> {
    /// Checks that the nodes are pairwise disjoint as far as paths tell, and have finite costs of at least 1.
    fn assert_well_formed(&self) {
        for (i, node) in self.nodes().iter().enumerate() {
            assert!(node.cost >= 1.0 && node.cost.is_finite(), "node {i} costs {}", node.cost);
        }
        let mut sorted = self.nodes().to_vec();
        sorted.sort_by_key(FrontNode::first_key);
        for two in sorted.windows(2) {
            let [x, y] = [two[0], two[1]];
            let is_deep = x.path == y.path && x.path.level() == Path::MAX_LEVEL && x.pair != y.pair;
            assert!(x.last_key() < y.first_key() || is_deep, "{x:?} {y:?}");
        }
    }
}

/// Frames that remember.
struct Frames {
    history: Vec<FrontNode>,
    capacity: usize,
}

impl Frames {
    fn new(capacity: usize) -> Self {
        Self { history: Vec::new(), capacity }
    }

    /// A frame of some queries. Checks that the front is well formed, and that each query finds what it does alone.
    fn frame<Q: Query>(&mut self, queries: &[Q], options: RefineOptions) -> FrontReport {
        let mut nodes = vec![FrontNode::default(); self.capacity];
        let mut front = Front::new(&mut nodes);
        for (query, number) in queries.iter().zip(0..) {
            query.root().into_iter().for_each(|root| front.add(number, root).unwrap());
        }
        let report = front.refine(&options, &mut self.history, |n| &queries[n as usize]);
        front.assert_well_formed();
        let cost = front.cost();
        let mut parts = vec![Part::default(); options.workers];
        let nodes = front.partition(&mut parts);
        let makespan = parts.iter().fold(0.0, |most, part| f64::max(most, part.cost));
        let bound = (1.0 + report.epsilon) * cost / options.workers as f64;
        assert!(makespan <= bound * 1.000_001, "{makespan} {bound} {report:?}");
        let mut found: Vec<_> = queries.iter().map(|_| Vec::new()).collect();
        for node in &mut *nodes {
            let number = node.query as usize;
            node.cost = traverse(&queries[number], node.pair, &mut found[number]);
        }
        for (query, found) in queries.iter().zip(found) {
            assert!(sorted(found) == pairs(query, query.root()));
        }
        self.history = nodes.to_vec();
        report
    }

    /// The share of the last frame's costs that a frame of these queries would find again from the roots' children on.
    fn share_in_starting_front<Q: Query>(&self, queries: &[Q]) -> f64 {
        let mut nodes = vec![FrontNode::default(); self.capacity];
        let mut front = Front::new(&mut nodes);
        for (query, number) in queries.iter().zip(0..) {
            query.root().into_iter().for_each(|root| front.add(number, root).unwrap());
        }
        front.refine(&options(2, 0.0), &mut [], |n| &queries[n as usize]);
        let mut starting = front.nodes().to_vec();
        starting.sort_by_key(FrontNode::first_key);
        CostHistory::new(&mut self.history.clone()).share_in(&starting)
    }
}

const fn options(workers: usize, g: f64) -> RefineOptions {
    RefineOptions { workers, g, g_estimated: g }
}

#[test]
fn any_front_is_a_whole_cut() {
    let bumpy = body(bumpy(24));
    let pair = PairBvtt::new(bumpy.bvh(), bumpy.bvh(), tilt(0.3)).unwrap();
    let itself = SelfBvtt::new(bumpy.bvh());
    let mut rng = seeded(7);
    for capacity in (1..40).chain([64, 100, 1000, CAPACITY]) {
        let options = RefineOptions { g: rng.random_range(0..16).into(), ..RefineOptions::new(5) };
        let [mut of_two, mut of_one] = [Frames::new(capacity), Frames::new(capacity)];
        for _ in 0..2 {
            of_two.frame(&[pair], options);
            of_one.frame(&[itself], options);
        }
    }
}

#[test]
fn a_front_without_room_for_a_root_is_refused() {
    let root = NodePair { a: 1, b: 2 };
    let mut nodes = [FrontNode::default(); 1];
    let mut front = Front::new(&mut nodes);
    assert_eq!(front.add(0, root), Ok(()));
    assert_eq!((front.nodes()[0].pair, front.nodes()[0].cost), (root, 1.0));
    let error = CapacityError { buffer: "front", needed: 2, capacity: 1 };
    assert_eq!(front.add(1, root), Err(error));
}

#[test]
fn one_front_serves_many_queries() {
    let body = body(sheet(16, |x, y| x * y));
    let query = |z| PairBvtt::new(body.bvh(), body.bvh(), tilt(z)).unwrap();
    let queries = [0.0, 9.0, 0.2, 0.4].map(query);
    for capacity in [4, 7, 5000] {
        let mut frames = Frames::new(capacity);
        frames.frame(&queries, RefineOptions::new(4));
        assert!(frames.frame(&queries, RefineOptions::new(4)).coherent);
        // The second has no node, the first is gone, and the others have changed places.
        let numbers = [None, None, Some(1), Some(0)];
        frames.history.retain_mut(|node| {
            numbers[node.query as usize].inspect(|&new| node.query = new).is_some()
        });
        let queries = [queries[3], queries[2]];
        assert!(frames.share_in_starting_front(&queries) > 0.9);
        assert!(frames.frame(&queries, RefineOptions::new(4)).coherent);
    }
}

/// Every node costs less than ε·W/p, if there is enough work for all nodes to be split that cost more.
#[test]
fn epsilon_bounds_the_predicted_makespan() {
    let body = body(bumpy(120));
    let query = PairBvtt::new(body.bvh(), body.bvh(), tilt(0.1)).unwrap();
    for (epsilon, workers) in [(1.0, 2), (0.5, 7), (0.2, 16), (0.1, 3)] {
        let report = Frames::new(CAPACITY).frame(&[query], options(workers, 1.0 / epsilon));
        assert!(!report.full);
        assert!(report.epsilon < epsilon * 1.000_001, "{report:?}");
    }
}

/// The units are powers of two, so that all coordinates round alike: about 0.01, 1 and 100.
#[test]
fn the_unit_of_length_is_of_no_account() {
    let fronts = [1.0 / 128.0, 1.0, 128.0].map(|unit| {
        let body = body(bumpy(40).map(|p| p.map(|x| unit * x)));
        let mut here = tilt(0.1);
        here.rows.iter_mut().for_each(|row| row[3] *= unit);
        let query = PairBvtt::new(body.bvh(), body.bvh(), here).unwrap();
        let mut nodes = vec![FrontNode::default(); CAPACITY];
        let mut front = Front::new(&mut nodes);
        front.add(0, query.root().unwrap()).unwrap();
        front.refine(&RefineOptions::new(4), &mut [], |_| &query);
        (front.cost(), front.nodes().iter().map(|n| n.pair).collect::<Vec<_>>())
    });
    let [small, usual, large] = fronts;
    assert!((small.0 / usual.0 - 1.0).abs() < 1e-6 && small.1 == usual.1);
    assert!((large.0 / usual.0 - 1.0).abs() < 1e-6 && large.1 == usual.1);
}

#[test]
fn boxes_without_volume_get_sound_costs() {
    let flat = body(sheet(12, |_, _| 0.0));
    let point = body(MeshData::of([[[0.5, 0.5, 0.0]; 3]; 10]));
    let huge = body(MeshData::of([[[-3e37, 0.0, 0.0], [3e37, 0.0, 0.0], [0.0, 3e37, 3e37]]; 40]));
    let cases = [
        (&flat, &flat, Pose::IDENTITY),
        (&flat, &flat, Pose::from_translation([1.0, 0.0, 0.0])),
        (&flat, &point, Pose::IDENTITY),
        (&point, &point, Pose::IDENTITY),
        (&huge, &huge, Pose::IDENTITY),
        (&huge, &flat, Pose::IDENTITY),
    ];
    for (a, b, pose) in cases {
        let query = PairBvtt::new(a.bvh(), b.bvh(), pose).unwrap();
        let mut frames = Frames::new(3000);
        for _ in 0..2 {
            frames.frame(&[query], RefineOptions::new(5));
        }
    }
}

#[test]
fn a_jump_is_noticed_and_motion_is_not() {
    let body = body(bumpy(40));
    let place = |x: f32| {
        let mut moved = tilt(0.0);
        moved.rows[0][3] += x;
        [PairBvtt::new(body.bvh(), body.bvh(), moved).unwrap()]
    };
    let options = RefineOptions::new(8);
    let mut frames = Frames::new(CAPACITY);
    assert!(!frames.frame(&place(0.0), options).coherent);
    let share = frames.share_in_starting_front(&place(0.001));
    assert!(share > 0.9, "{share}");
    assert!(frames.frame(&place(0.001), options).coherent);
    frames.frame(&place(0.7), options);
    assert!(frames.share_in_starting_front(&place(-0.7)) < 0.5);
    assert!(!frames.frame(&place(-0.7), options).coherent);
}

#[test]
fn a_still_scene_settles() {
    let body = body(bumpy(60));
    let query = [PairBvtt::new(body.bvh(), body.bvh(), tilt(0.05)).unwrap()];
    let mut frames = Frames::new(CAPACITY);
    for _ in 0..5 {
        frames.frame(&query, RefineOptions::new(8));
    }
    let settled = frames.history.len();
    for _ in 0..20 {
        frames.frame(&query, RefineOptions::new(8));
        assert_eq!(frames.history.len(), settled);
    }
}

/// Costs of any sign and size, other queries, nodes twice, and nodes of random bits.
#[test]
fn any_history_is_harmless() {
    let bumpy = body(bumpy(20));
    let huge = body(MeshData::of([[[-f32::MAX; 3], [f32::MAX; 3], [0.0, f32::MAX, -f32::MAX]]; 3]));
    let (nan, infinity, max) = (f32::NAN, f32::INFINITY, f32::MAX);
    let odd = [nan, -nan, infinity, -infinity, -1.0, 0.0, -0.0, max, -max, 1e-45, 1.0, 50.0];
    let mut rng = seeded(1);
    for round in 0..300 {
        let bvh = if round % 7 == 0 { huge.bvh() } else { bumpy.bvh() };
        let query = [PairBvtt::new(bvh, bvh, Pose::IDENTITY).unwrap()];
        let capacity = [1, 4, 5, 33, 40, 300, CAPACITY][rng.random_range(0..7)];
        let mut frames = Frames::new(capacity);
        frames.frame(&query, RefineOptions::new(5));
        let usual = odd.get(rng.random_range(0..=odd.len()));
        for node in &mut frames.history {
            if usual.is_none() || rng.random_bool(0.2) {
                node.cost = *usual.unwrap_or(&odd[rng.random_range(0..odd.len())]);
            }
            if rng.random_bool(0.1) {
                node.query = rng.random_range(0..3);
            }
        }
        for node in frames.history.clone() {
            if rng.random_bool(0.3) {
                frames.history.push(node);
            }
            if rng.random_bool(0.1) {
                let words: [u32; 10] = core::array::from_fn(|_| rng.random());
                let mut forged: FrontNode = bytemuck::cast(words);
                if rng.random_bool(0.5) {
                    (forged.query, forged.cost) = (0, forged.cost.abs().min(1e6));
                }
                frames.history.push(forged);
            }
        }
        frames.frame(&query, RefineOptions::new(5));
    }
}

/// The pending nodes of a cursor all have the path of the root: sorts that differ, with and without `std`, still agree.
#[test]
fn nodes_of_a_cursor_are_assigned_alike_in_any_order() {
    let flat = body(sheet(12, |_, _| 0.0));
    let query = SelfBvtt::new(flat.bvh());
    let mut cursor = query.start();
    let _ = query.step(&mut cursor, 400, |_| ControlFlow::Continue(()));
    let mut pending = cursor.take_pending().to_vec();
    let mut assigned = || {
        pending.reverse();
        let mut memory = vec![FrontNode::default(); 4000];
        let mut front = Front::new(&mut memory);
        pending.iter().for_each(|&pair| front.add(0, pair).unwrap());
        front.refine(&RefineOptions::new(4), &mut [], |_| &query);
        front.partition(&mut [Part::default(); 4]).to_vec()
    };
    assert!(assigned() == assigned());
}

#[test]
fn a_front_of_leaf_pairs_is_not_full() {
    let one = body(sheet(1, |_, _| 0.0));
    let query = SelfBvtt::new(one.bvh());
    let report = Frames::new(1).frame(&[query], RefineOptions::new(2));
    assert!(!report.full && report.box_tests == 0, "{report:?}");
}

#[test]
fn a_front_without_room_for_children_is_full() {
    let bumpy = body(bumpy(24));
    let report = Frames::new(1).frame(&[SelfBvtt::new(bumpy.bvh())], RefineOptions::new(2));
    // The root branches into three pairs, of which one takes a test.
    assert!(report.full && report.box_tests > 0, "{report:?}");
}

/// A level of 32 nodes is a starting front, and a g of 0 leaves it as it is. So does one worker with any.
#[test]
fn a_starting_front_is_not_split() {
    let body = body(bumpy(24));
    let query = SelfBvtt::new(body.bvh());
    let none: [SelfBvtt; 0] = [];
    assert_eq!(Frames::new(1).frame(&none, RefineOptions::new(2)), FrontReport::default());
    let mut frames = Frames::new(CAPACITY);
    frames.frame(&[query], RefineOptions::new(1));
    assert_eq!(frames.history.len(), 1);
    for (queries, expected) in [(32, 32), (31, 93)] {
        let mut frames = Frames::new(CAPACITY);
        frames.frame(&vec![&query; queries], options(2, 0.0));
        assert_eq!(frames.history.len(), expected);
    }
}

/// The costs of a front are those that the last frame measured, if it was like this one, and estimates if it was not.
#[test]
fn measured_costs_are_used_again_if_frames_are_alike() {
    let body = body(bumpy(60));
    let query = PairBvtt::new(body.bvh(), body.bvh(), tilt(0.05)).unwrap();
    let mut frames = Frames::new(CAPACITY);
    for _ in 0..5 {
        frames.frame(&[query], RefineOptions::new(8));
    }
    let front = |history: &mut [FrontNode]| {
        let mut memory = vec![FrontNode::default(); CAPACITY];
        let mut front = Front::new(&mut memory);
        front.add(0, NodePair::ROOT).unwrap();
        let report = front.refine(&RefineOptions::new(8), history, |_| &query);
        let mut nodes = front.nodes().to_vec();
        nodes.sort_by_key(FrontNode::order);
        let costs: Vec<_> = nodes.iter().map(|n| (n.pair, n.cost)).collect();
        (costs, report.coherent)
    };
    let mut settled = frames.history.clone();
    settled.sort_by_key(FrontNode::order);
    let measured = settled.iter().map(|n| (n.pair, n.cost)).collect();
    assert_eq!(front(&mut frames.history.clone()), (measured, true));
    // Most of the cost lies in another query now.
    frames.history.push(FrontNode { query: 1, cost: 1e9, ..FrontNode::default() });
    assert_eq!(front(&mut frames.history), front(&mut []));
}

/// Nodes that the last frame split are merged again where they have become cheap.
#[test]
fn a_coarser_grain_makes_a_smaller_front() {
    let body = body(bumpy(60));
    let query = [PairBvtt::new(body.bvh(), body.bvh(), tilt(0.05)).unwrap()];
    let mut frames = Frames::new(CAPACITY);
    let lengths = [64.0, 1.0].map(|g| {
        frames.frame(&query, options(8, g));
        frames.history.len()
    });
    assert!(2 * lengths[1] < lengths[0], "{lengths:?}");
}

fn pairs(query: &impl Query, roots: impl IntoIterator<Item = NodePair>) -> Vec<TrianglePair> {
    let mut found = Vec::new();
    for root in roots {
        traverse(query, root, &mut found);
    }
    sorted(found)
}

/// Adds the pairs below a node pair to `found`; returns what it cost to find them.
fn traverse(query: &impl Query, root: NodePair, found: &mut Vec<TrianglePair>) -> f32 {
    let mut cursor = Cursor::at(root);
    let _ = query.visit(&mut cursor, |pair| {
        found.push(pair);
        ControlFlow::Continue(())
    });
    1.0 + cursor.work.cost() as f32
}

fn sorted(mut pairs: Vec<TrianglePair>) -> Vec<TrianglePair> {
    pairs.sort_unstable();
    pairs
}

/// A turn about x by a third, and a lift.
fn tilt(z: f32) -> Pose {
    Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 0.8, -0.6, 0.3], [0.0, 0.6, 0.8, z - 0.3]])
}

fn body(soup: MeshData) -> Owned {
    Owned::new(soup, 4, true)
}
