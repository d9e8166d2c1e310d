//! Every verb, whatever the cut, against each tree visited as a whole.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::front::Cut;
use super::{AT_START, AnyMovingBvtt, MovingSubjects, SubjectNodePair, earlier};
use crate::executor::{History, Named};
use crate::{Executor, Impact, Model, Motion, Pose, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, PairBvtt, Query, SelfBvtt};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};
use pfront_testkit::shapes::{pose_rows, sheet, sphere};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A pair of one of several subjects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Hit {
    name: usize,
    pair: TrianglePair,
}

impl Named for Hit {
    type Name = usize;

    fn new(name: usize, pair: TrianglePair) -> Self {
        Self { name, pair }
    }

    fn name(&self) -> usize {
        self.name
    }

    fn pair(&self) -> TrianglePair {
        self.pair
    }
}

/// The last leaves something of every node pair that is no leaf pair, so that there are as many fronts as the trees are deep.
const CUTS: [Cut; 4] = [
    Cut::DEFAULT,
    Cut { front: 64, budget: 64, least: 2, alone: 16 },
    Cut { front: 200, budget: 16, least: 3, alone: 0 },
    Cut { front: 5, budget: 1, least: 1, alone: 1 },
];

fn executors() -> Vec<Executor> {
    let sequential = Executor::sequential();
    let flagged = sequential.clone().with_cancel(Arc::new(AtomicBool::new(false)));
    [sequential, flagged].into_iter().chain([1, 2, 7].map(Executor::threads)).collect()
}

/// The pairs of a tree, visited from its root.
fn every(name: usize, tree: &AnyMovingBvtt<'_>) -> Vec<(Hit, Impact)> {
    let mut all = Vec::new();
    let mut add = |pair, impact| {
        all.push((Hit { name, pair }, impact));
        ControlFlow::Continue(())
    };
    let _ = match tree {
        AnyMovingBvtt::Pair(tree) => tree.visit(&mut add),
        AnyMovingBvtt::Itself(tree) => tree.visit(&mut add),
        AnyMovingBvtt::Still(tree) => tree.visit(&mut tree.start(), |pair| add(pair, AT_START)),
    };
    all
}

/// Asks about some trees with every verb. Compares with all their pairs, sorted.
fn check(
    executor: &Executor,
    cut: Cut,
    trees: &[AnyMovingBvtt<'_>],
    every: &[(Hit, Impact)],
    known: Option<(Hit, Impact)>,
) {
    let root = |(name, tree): (usize, &AnyMovingBvtt<'_>)| {
        tree.first_overlap().map(|from| SubjectNodePair::root(name, from))
    };
    let mut subjects: Vec<_> = trees.iter().enumerate().filter_map(root).collect();
    subjects.sort_by(|p, q| p.from.total_cmp(&q.from));
    let mut history = History::on(executor);
    macro_rules! ask {
        ($verb:ident($($argument:expr)?)) => {{
            let tree = |name: usize| Some((name, trees[name]));
            let subjects = MovingSubjects::new(&mut history, &subjects, tree);
            MovingSubjects { cut, ..subjects }.$verb($($argument)?).unwrap()
        }};
    }
    let mut all: Vec<(Hit, Impact)> = Vec::new();
    ask!(all(&mut all));
    all.sort_by_key(|hit| hit.0);
    assert!(all == every, "{executor:?} {cut:?}");
    let proven = all.iter().filter(|hit| hit.1.is_proven()).count();
    assert_eq!(ask!(count()), [proven as u64, all.len() as u64]);
    let any: Option<(Hit, Impact)> = ask!(any());
    assert!(any.map_or(all.is_empty(), |hit| all.contains(&hit)));
    assert_eq!(any.is_some_and(|hit| hit.1.is_proven()), proven > 0);
    let first = all.into_iter().map(Some).fold(known, earlier);
    assert_eq!(ask!(first(known)), first, "{executor:?} {cut:?}");
    assert!(history.plan().is_some());
}

fn model(soup: &MeshData) -> Model {
    Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap()
}

/// The same model with each corner up to so far away.
fn shaken(soup: &MeshData, by: f32, rng: &mut ChaCha8Rng) -> Model {
    let mut model = model(soup);
    let mut shake = |x: f32| x + rng.random_range(-by..by);
    let positions: Vec<_> = soup.positions.iter().map(|p| p.map(&mut shake)).collect();
    model.set_positions(&positions).unwrap();
    model
}

#[test]
fn answers_do_not_depend_on_the_cut() {
    let mut rng = seeded(474);
    let (ball, cloth) = (sphere(8), sheet(9, |u, v| 0.3 * (5.0 * u).sin() * v));
    let (floor, body, before) = (model(&cloth), model(&ball), model(&cloth));
    let (executors, mut at_start, mut later) = (executors(), 0, 0);
    for _ in 0..6 {
        let after = shaken(&cloth, 0.05, &mut rng);
        let [start, end] = [0; 2].map(|_| Pose::new(pose_rows(2.0, &mut rng)));
        let from = [5.0, 0.0, 0.0].map(|x: f32| x + rng.random_range(-0.3..0.3));
        let [far, behind] = [from, from.map(|x| -x)].map(Pose::from_translation);
        let motions = [
            Motion::at_rest(&floor),
            Motion::new(&body, start, end).unwrap(),
            Motion::new(&body, far, behind).unwrap(),
            Motion::between(&before, &after).unwrap(),
        ];
        let [rest, moving, through, deforming] = motions.each_ref().map(Motion::bvh);
        // Two bodies of which one moves, one that deforms, two that are far apart at both ends, and two that rest.
        let trees = [
            AnyMovingBvtt::Pair(PairBvtt::moving(rest, moving)),
            AnyMovingBvtt::Itself(SelfBvtt::moving(deforming)),
            AnyMovingBvtt::Pair(PairBvtt::moving(rest, through)),
            AnyMovingBvtt::Still(AnyBvtt::Pair(
                PairBvtt::new(floor.bvh(), body.bvh(), start).unwrap(),
            )),
        ];
        for trees in [&trees[..], &trees[..1], &trees[1..2], &trees[2..3], &trees[2..]] {
            let mut all: Vec<_> =
                (0..).zip(trees).flat_map(|(name, tree)| every(name, tree)).collect();
            all.sort_by_key(|hit| hit.0);
            at_start += all.iter().filter(|hit| hit.1.from == 0.0).count();
            later += all.iter().filter(|hit| hit.1.from > 0.0).count();
            for (executor, cut) in executors.iter().flat_map(|on| CUTS.map(|cut| (on, cut))) {
                check(executor, cut, trees, &all, None);
                check(executor, cut, trees, &all, all.get(all.len() / 2).copied());
            }
        }
    }
    assert!(at_start > 50 && later > 10_000, "{at_start} {later}");
}
