//! Queries in steps of bounded work: the same pairs in the same order for every budget, and no step above its bound.

extern crate std;

use super::super::{PairBvtt, Query, SelfBvtt, TrianglePair, Work};
use super::{at_one_go, with_certificates};
use crate::bvh::MAX_DEPTH;
use crate::bvh::tests::Owned;
use crate::{Bvh, Mesh, Node, Pose};
use core::ops::ControlFlow::{Break, Continue};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::{bumpy, pose_rows, sheet, sphere, tangle, union};
use std::vec;
use std::vec::Vec;

/// The tests by which a step may exceed its budget: box tests come up to 16 at a time.
const OVERSHOOT: u64 = 16;

/// Asks in steps, each with a budget and a visitor that breaks after as many pairs as a page takes. Checks each step,
/// and that the whole is what the query does at one go. Returns the tests of the longest step.
pub(super) fn in_steps(
    query: &impl Query,
    (expected, work): &(Vec<TrianglePair>, Work),
    steps: impl IntoIterator<Item = (u64, usize)>,
) -> u64 {
    let (mut cursor, mut pairs, mut longest, mut idle) = (query.start(), Vec::new(), 0, 0);
    let mut steps = steps.into_iter();
    while !cursor.is_done() {
        let (budget, page) = steps.next().unwrap();
        let (before, found) = (cursor.work.tests(), pairs.len());
        let flow = query.step(&mut cursor, budget, |pair| {
            pairs.push(pair);
            if pairs.len() - found == page { Break(()) } else { Continue(()) }
        });
        let done = cursor.work.tests() - before;
        assert_eq!(flow.is_break(), pairs.len() - found == page);
        assert!(done <= budget.saturating_add(OVERSHOOT), "{done} tests for {budget}");
        longest = longest.max(done);
        idle = if done == 0 { idle + 1 } else { 0 };
        assert!(idle < 1_000, "no progress");
    }
    assert_eq!((&pairs, cursor.work), (expected, *work));
    longest
}

/// Asks with each budget; for those that the query is large enough for, the bound is tight.
fn with_each_budget(query: &impl Query) {
    let whole = at_one_go(query);
    let all = whole.1.tests();
    for budget in [1, 10, 1000] {
        let longest = in_steps(query, &whole, core::iter::repeat((budget, usize::MAX)));
        let bound = budget + OVERSHOOT;
        assert!(all <= 100 * budget || 10 * longest >= 9 * bound, "{longest} of {bound} tests");
    }
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; `blocks` runs the same vector code")]
fn two_meshes_with_each_budget() {
    let meshes = [(sphere(90), sphere(70)), (bumpy(120), sheet(90, |_, _| 0.0))];
    for leaf_size in [1, 4, 8] {
        for (a, b) in &meshes {
            let [a, b] = [a, b].map(|soup| Owned::new(soup.clone(), leaf_size, false));
            for translation in [[0.0; 3], [0.3, 0.1, 0.02]] {
                let pose = Pose::from_translation(translation);
                with_each_budget(&PairBvtt::new(a.bvh(), b.bvh(), pose).unwrap());
            }
        }
    }
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; `blocks` runs the same vector code")]
fn one_mesh_with_each_budget() {
    let rolled = sheet(100, |_, _| 0.0)
        .map(|[x, y, _]| [(14.0 * x).cos(), (14.0 * x).sin() * (1.0 - 0.1 * x), y]);
    let two = union(&[sphere(60), sphere(60).map(|[x, y, z]| [x + 0.01, y, z])]);
    for leaf_size in [1, 4, 8] {
        for soup in [&rolled, &two] {
            let owned = Owned::new(soup.clone(), leaf_size, false);
            let query = SelfBvtt::new(owned.bvh());
            with_each_budget(&query);
            with_certificates(owned.bvh().mesh(), |certified| {
                with_each_budget(&query.with_certificates(certified));
            });
            with_each_budget(&query.boxes_only());
        }
    }
}

/// Budgets and pages that change from step to step, down to none.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long; `blocks` runs the same vector code")]
fn with_any_budgets() {
    let mut rng = seeded(8);
    for _ in 0..64 {
        let (size, leaf_size) = (rng.random_range(0..8), rng.random_range(1..=8));
        let (a, b) = (tangle(60, 120, size, &mut rng), tangle(40, 90, size, &mut rng));
        let [a, b] = [a, b].map(|soup| Owned::new(soup, leaf_size, false));
        let pose = Pose { rows: pose_rows(0.5, &mut rng) };
        let count = rng.random_range(1..20);
        let mut steps: Vec<_> =
            (0..count).map(|_| (rng.random_range(0..40), rng.random_range(1..6))).collect();
        steps.push((1, 1));
        with_steps(&PairBvtt::new(a.bvh(), b.bvh(), pose).unwrap(), &steps);
        with_steps(&SelfBvtt::new(a.bvh()), &steps);
    }
}

/// Asks in these steps, again and again.
fn with_steps(query: &impl Query, steps: &[(u64, usize)]) {
    in_steps(query, &at_one_go(query), steps.iter().copied().cycle());
}

#[test]
fn a_budget_ends_inside_a_leaf_pair() {
    let eight =
        Owned::new(MeshData::of([[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 8]), 8, false);
    let query = PairBvtt::new(eight.bvh(), eight.bvh(), Pose::IDENTITY).unwrap();
    let mut cursor = query.start();
    for done in [10, 20, 30, 40, 50, 60, 64] {
        let _ = query.step(&mut cursor, 10, |_| Continue(()));
        assert_eq!(cursor.work, Work { box_tests: 0, triangle_tests: done });
    }
    assert!(cursor.is_done());
}

/// At every second level of the deepest tree all 16 pairs of grandchildren overlap, and the last leads on downwards.
#[test]
fn the_deepest_tree_fills_the_stack() {
    let point = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let leaf = |first: u32| Node { first, count: 1, ..point };
    let (mut nodes, mut parent, mut leaves) = (vec![point; 2], 0, 0..);
    let mut next = || leaf(leaves.next().unwrap());
    for _ in 0..MAX_DEPTH / 2 {
        let at = nodes.len() as u32;
        nodes[parent].first = at;
        nodes.extend([Node { first: at + 2, ..point }, Node { first: at + 4, ..point }]);
        nodes.extend([next(), next(), next(), point]);
        parent = nodes.len() - 1;
    }
    nodes[parent] = next();
    let triangles = vec![[0; 3]; next().first as usize];
    let order: Vec<_> = (0..triangles.len() as u32).collect();
    let mesh = Mesh::new(&[[0.0; 3]], &triangles).unwrap();
    let bvh = Bvh::new(mesh, &nodes, &order, &mut [0; 3]).unwrap();
    assert_eq!(bvh.depth(), MAX_DEPTH);
    let query = PairBvtt::new(bvh, bvh, Pose::IDENTITY).unwrap();
    let mut cursor = query.start();
    let _ = query.step(&mut cursor, 16 * (MAX_DEPTH / 2) as u64, |_| Continue(()));
    assert_eq!(cursor.pending().len(), 15 * MAX_DEPTH / 2 + 1);
    // Miri would take minutes.
    if !cfg!(miri) {
        assert_eq!(query.count(), (triangles.len() * triangles.len()) as u64);
    }
}

#[test]
fn work_costs_box_tests_and_some_for_each_triangle_test() {
    let work = Work { box_tests: 2, triangle_tests: 3 };
    assert_eq!(work.cost(), 2.0 + 3.0 * Work::TRIANGLE_COST);
}
