//! Answers over slow motion: the exact one changes where the truth does and nowhere else, triangle by triangle
//! and mesh by mesh.

use pfront::{Adjacency, Model, SelfQuery, TrianglePair};
use pfront_lab::motion::{METHODS, NAMES, Row, STEPS, Slide, figure, run};
use pfront_testkit::oracle::intersect;

#[test]
fn exact_changes_where_the_truth_does() {
    let rows = run(32).unwrap();
    assert_eq!(rows.len(), NAMES.len() * STEPS.len() * METHODS.len());
    for Row { slide, step, method, truth, flips, missed, wrong, answers } in &rows {
        if *method == "Exact" {
            assert_eq!([*flips, *missed, *wrong], [0; 3], "{slide}, {step}");
        }
        assert!(truth + flips < *answers);
    }
    for name in NAMES {
        let of_slide = || rows.iter().filter(|row| row.slide == name);
        let changes: u64 = of_slide().map(|row| row.truth).sum();
        assert!(changes > 0, "nothing happens in {name}");
        let fast = of_slide().filter(|row| row.method == "Fast");
        let flips: u64 = fast.map(|row| row.flips).sum();
        println!("{name}: truth changes {changes} times, Fast flips {flips} times");
    }
    // Where a face slides over a face, plain f32 flickers.
    let flickers = |row: &&Row| row.slide == NAMES[0] && row.method == "Fast" && row.flips > 0;
    assert!(rows.iter().any(|row| flickers(&row)));
    let svg = figure(&rows).svg();
    for part in NAMES.into_iter().chain(["Exact", "Fast", ">1e-5<", ">0<"]) {
        assert!(svg.contains(part), "no '{part}' in the chart");
    }
}

/// The same through a model's tree: what it reports of the watched pairs is the truth in every frame.
#[test]
fn queries_change_where_the_truth_does() {
    for name in NAMES {
        let slide = Slide::by_name(name).unwrap();
        let mut model = Model::new(slide.positions(0.0), slide.triangles().to_vec()).unwrap();
        let mut query = SelfQuery::new().with_adjacency(Adjacency::SkipNeighbours);
        for frame in -12..12 {
            let length = STEPS[0] * f64::from(frame);
            model.set_positions(&slide.positions(length)).unwrap();
            let found = query.all(&model).unwrap();
            for (&[a, b], [s, t]) in slide.watched().iter().zip(slide.pairs(length)) {
                let reported = found.binary_search(&TrianglePair { a, b }).is_ok();
                assert_eq!(reported, intersect(&s, &t), "{name}, {a} and {b} in frame {frame}");
            }
        }
    }
}

#[test]
fn no_other_slide() {
    let error = Slide::by_name("down the hill").err().unwrap();
    assert!(error.to_string().contains("gears meshing"), "{error}");
}
