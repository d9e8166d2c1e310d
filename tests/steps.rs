//! Queries in steps of bounded work: the same pairs in the same order for every budget, and no step above
//! its bound.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod layouts;

use layouts::Compact;
use pfront::core::bvtt::{Cursor, PairQuery, Query, SelfQuery, Work};
use pfront::{BuildOptions, Model, Pose, TrianglePair};
use pfront_testkit::rng::seeded;
use pfront_testkit::shapes::{Soup, bumpy, pose_rows, sheet, sphere, tangle, union};
use proptest::prelude::*;
use std::ops::ControlFlow::{Break, Continue};

const BUDGETS: [u64; 3] = [1, 10, 1000];

/// By how much a step may exceed its budget: box tests come up to 16 at a time.
const OVERSHOOT: u64 = 15;

fn model(soup: &Soup, leaf_size: u32) -> Model {
    let (positions, triangles) = (soup.positions.clone(), soup.triangles.clone());
    Model::with_options(positions, triangles, BuildOptions { leaf_size, ..BuildOptions::default() })
        .unwrap()
}

/// What a query does at one go.
fn at_one_go(query: &impl Query) -> (Vec<TrianglePair>, Work) {
    let (mut cursor, mut pairs) = (query.start(), Vec::new());
    let end = query.visit(&mut cursor, |pair| {
        pairs.push(pair);
        Continue(())
    });
    assert!(end.is_continue() && cursor.is_done());
    (pairs, cursor.work)
}

fn tests(cursor: &Cursor) -> u64 {
    let Work { box_tests, triangle_tests } = cursor.work;
    box_tests + triangle_tests
}

/// Asks in steps with these budgets, each visitor breaking after as many pairs as its page takes, and
/// checks each step and the whole. Returns the tests of the longest step.
fn in_steps(
    query: &impl Query,
    (expected, work): &(Vec<TrianglePair>, Work),
    budgets: impl IntoIterator<Item = (u64, usize)>,
) -> u64 {
    let (mut cursor, mut pairs, mut longest) = (query.start(), Vec::new(), 0);
    let mut budgets = budgets.into_iter();
    while !cursor.is_done() {
        let (budget, page) = budgets.next().unwrap();
        let (before, found) = (tests(&cursor), pairs.len());
        let end = query.step(&mut cursor, budget, |pair| {
            pairs.push(pair);
            if pairs.len() - found == page { Break(()) } else { Continue(()) }
        });
        let done = tests(&cursor) - before;
        assert_eq!(end.is_break(), pairs.len() - found == page);
        assert!(done <= budget.saturating_add(OVERSHOOT), "{done} tests for {budget}");
        longest = longest.max(done);
    }
    assert_eq!((&pairs, cursor.work), (expected, *work));
    longest
}

/// Asks with each budget; for those that the query is large enough for, the bound is tight.
fn with_each_budget(query: &impl Query) {
    let whole = at_one_go(query);
    let all = whole.1.box_tests + whole.1.triangle_tests;
    for budget in BUDGETS {
        let longest = in_steps(query, &whole, std::iter::repeat((budget, usize::MAX)));
        println!("budget {budget}: longest step {longest} of {all} tests");
        if all > 100 * budget {
            let bound = budget + OVERSHOOT;
            assert!(
                10 * longest >= 9 * bound,
                "{longest} tests at most, where {bound} are allowed"
            );
        }
    }
    in_steps(query, &whole, [(0, 1), (u64::MAX, usize::MAX)]);
}

#[test]
fn two_meshes_with_each_budget() {
    let meshes = [(sphere(90), sphere(70)), (bumpy(120), sheet(90, |_, _| 0.0))];
    for leaf_size in [1, 4, 8] {
        for (a, b) in &meshes {
            let (a, b) = (model(a, leaf_size), model(b, leaf_size));
            for [x, y, z] in [[0.0; 3], [0.3, 0.1, 0.02]] {
                let pose = Pose::from_translation([x, y, z]);
                with_each_budget(&PairQuery::new(a.bvh(), b.bvh(), pose).unwrap());
                let small = Compact::of(a.bvh());
                with_each_budget(&PairQuery::new(small.bvh(a.mesh()), b.bvh(), pose).unwrap());
            }
        }
    }
}

#[test]
fn one_mesh_with_each_budget() {
    let rolled = sheet(100, |_, _| 0.0)
        .map(|[x, y, _]| [(14.0 * x).cos(), (14.0 * x).sin() * (1.0 - 0.1 * x), y]);
    let two = union(&[sphere(60), sphere(60).map(|[x, y, z]| [x + 0.01, y, z])]);
    for leaf_size in [1, 4, 8] {
        for soup in [&rolled, &two] {
            let model = model(soup, leaf_size);
            let query = SelfQuery::new(model.bvh());
            with_each_budget(&query);
            with_each_budget(&query.with_certificates(model.certificates()));
            with_each_budget(&query.boxes_only());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Budgets and pages that change from step to step, down to none.
    #[test]
    fn with_any_budgets(
        seed in any::<u64>(),
        size in 0..8,
        leaf_size in 1_u32..=8,
        mut steps in prop::collection::vec((0_u64..40, 1_usize..6), 1..20),
    ) {
        let mut rng = seeded(seed);
        let (a, b) = (tangle(60, 120, size, &mut rng), tangle(40, 90, size, &mut rng));
        let pose = Pose::new(pose_rows(0.5, &mut rng));
        let (a, b) = (model(&a, leaf_size), model(&b, leaf_size));
        steps.push((1, 1));
        let steps = || steps.iter().copied().cycle();
        let query = PairQuery::new(a.bvh(), b.bvh(), pose).unwrap();
        in_steps(&query, &at_one_go(&query), steps());
        let query = SelfQuery::new(a.bvh());
        in_steps(&query, &at_one_go(&query), steps());
        let (small, least) = (Compact::of(a.bvh()), Compact::of(b.bvh()));
        let query = PairQuery::new(small.bvh(a.mesh()), least.bvh(b.mesh()), pose).unwrap();
        in_steps(&query, &at_one_go(&query), steps());
        let query = SelfQuery::new(small.bvh(a.mesh()));
        in_steps(&query, &at_one_go(&query), steps());
    }
}
