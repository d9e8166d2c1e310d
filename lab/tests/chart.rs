//! The points that charts of speed against accuracy are made of.

use pfront_lab::chart::{Point, Source, front, together};
use pfront_lab::judge::Tally;

fn point(time: f64, missed: u64) -> Point {
    let tally = Tally { pairs: 100, hits: 50, missed, false_hits: 0 };
    Point { set: "set".to_owned(), source: Source::Contact, test: format!("{time}"), time, tally }
}

#[test]
fn the_front_is_what_nothing_beats() {
    let points = [(3.0, 0), (1.0, 9), (2.0, 9), (2.0, 4), (2.0, 4), (4.0, 0), (5.0, 1)];
    let points = points.map(|(time, missed)| point(time, missed));
    assert_eq!(front(&points), [true, true, false, true, true, false, false]);
}

#[test]
fn sets_together_weigh_by_their_pairs() {
    let mut other = point(4.0, 7);
    other.tally.pairs = 300;
    let all = together("both", &[&[point(2.0, 1)], &[other]]);
    assert_eq!((all[0].time, all[0].tally.missed, all[0].tally.pairs), (3.5, 8, 400));
}
