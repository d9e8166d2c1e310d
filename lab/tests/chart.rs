//! Charts of very little.

use pfront_lab::chart::frames::Machine;
use pfront_lab::chart::{Charts, Look, Plan, Point, front, together};
use pfront_lab::judge::Tally;
use pfront_lab::suite::Suite;
use std::fs;

fn point(time: f64, missed: u64) -> Point {
    let tally = Tally { pairs: 100, hits: 50, missed, false_hits: 0 };
    let (set, configuration) = ("set".to_owned(), format!("{time}"));
    Point { set, is_real: true, configuration, look: Look::default(), time, tally }
}

#[test]
fn the_front_is_what_nothing_beats() {
    let points = [(3.0, 0), (1.0, 9), (2.0, 9), (2.0, 4), (2.0, 4), (4.0, 0), (5.0, 1)];
    let points = points.map(|(time, missed)| point(time, missed));
    let on_front = front(&points, Tally::wrong);
    assert_eq!(on_front, [true, true, false, true, true, false, false]);
    assert_eq!(front(&points, |tally| tally.false_hits)[..2], [false, true]);
}

#[test]
fn sets_together_weigh_by_their_pairs() {
    let mut other = point(4.0, 7);
    other.tally.pairs = 300;
    let all = together("both", &[&[point(2.0, 1)], &[other]]);
    assert_eq!((all[0].time, all[0].tally.missed, all[0].tally.pairs), (3.5, 8, 400));
}

#[test]
fn every_configuration_is_in_the_charts_and_the_table() {
    let suite = Suite::generated(1, Some(8_000)).unwrap();
    let plan = Plan { pairs: 33 * 40, frames: 1, rounds: 1 };
    let machine = Machine { threads: 2, ..Machine::this() };
    let charts = Charts::measure(&suite, &plan, &machine, |_| {}).unwrap();
    let folder = tempfile::tempdir().unwrap();
    charts.write(folder.path()).unwrap();

    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    for (name, sets) in [("pairs.svg", &charts.pairs), ("frames.svg", &charts.frames)] {
        let svg = read(name);
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "svg");
        let texts: Vec<_> = document.descendants().filter_map(|node| node.text()).collect();
        let says = |text: &str| texts.iter().any(|found| found.trim() == text);
        assert!(sets[0].iter().all(|point| says(&point.look.name)), "{name}: {texts:?}");
        assert!(texts.iter().any(|text| text.contains("0 of ")), "{name}");
    }
    assert!(roxmltree::Document::parse(&read("contacts.svg")).is_ok());

    let table = read("pareto.csv");
    let lines = charts.pairs.iter().chain(&charts.frames).map(Vec::len).sum::<usize>();
    assert_eq!(table.lines().count(), 1 + lines);
    for point in charts.frames.iter().flatten() {
        assert_eq!(point.tally.wrong() * u64::from(point.configuration.starts_with("Exact")), 0);
        assert!(point.time > 0.0 && table.contains(&point.configuration));
    }
    // Three accuracies and leaf sizes, one thread and three schedules; and a GPU with each leaf size.
    assert_eq!(charts.frames.len(), 3);
    assert!([36, 39].contains(&charts.frames[0].len()));
    assert!(charts.summary().contains("torus-knots"));
}
