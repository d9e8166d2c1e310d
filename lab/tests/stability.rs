//! The matrix of where fronts could fail: each row must pass, and the method as printed must fail where it is
//! known to, or the comparison says nothing.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::pfront_core::bvtt::PairBvtt;
use pfront::threads::{Pool, Schedule, Settings, Traversal};
use pfront::{Model, Pose, TrianglePair};
use pfront_lab::stability::Method::{Ours, Printed};
use pfront_lab::stability::{Finding, ROWS};
use pfront_testkit::scenes::icosphere;

const WORKERS: [usize; 5] = [1, 2, 7, 64, 1024];

fn holds(name: &str, is_printed_failing: bool) {
    let row = ROWS.iter().find(|row| row.name == name).unwrap();
    let mut scenes = row.scenes().unwrap();
    let frames: usize = scenes.iter().map(|scene| scene.steps().len()).sum();
    let mut seen = 0;
    let outcome = row.run(&mut scenes, &WORKERS, &mut || seen += 1).unwrap();
    assert_eq!(seen, frames);
    let ours = || outcome.findings.iter().filter(|found| found.method == Ours);
    assert!(WORKERS.iter().all(|&p| ours().any(|found| found.workers == p)));
    let beyond: Vec<&Finding> = ours().filter(|found| !found.holds()).collect();
    assert!(beyond.is_empty(), "{beyond:#?}");
    // However badly it is balanced, an answer is an answer.
    for series in &outcome.series {
        let wrong = series.frames.iter().position(|frame| !frame.right);
        assert_eq!(wrong, None, "{}, {:?}, p = {}", series.scene, series.method, series.workers);
    }
    assert!(outcome.holds(Printed) != is_printed_failing, "the method as printed, {name}");
}

macro_rules! rows {
    ($($test:ident: $name:literal, $is_printed_failing:literal;)*) => {
        $(#[test]
        fn $test() {
            holds($name, $is_printed_failing);
        })*

        #[test]
        fn no_row_is_left_out() {
            assert_eq!(ROWS.map(|row| row.name), [$($name),*]);
        }
    };
}

rows! {
    coherent: "coherent", true;
    flat: "flat", true;
    teleport: "teleport", true;
    onset_and_loss: "onset-and-loss", true;
    skewed: "skewed", true;
    one_against_many: "one-against-many", true;
    few_nodes: "few-nodes", false;
    identical: "identical", true;
    contained: "contained", true;
    still: "still", true;
    swaying: "swaying", true;
    twin: "twin", false;
}

/// The work of all, the front included, changes little when g is halved or doubled.
#[test]
fn the_grain_hardly_changes_the_work() {
    let sphere = icosphere(20_000);
    let sphere = Model::new(sphere.positions, sphere.triangles).unwrap();
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
