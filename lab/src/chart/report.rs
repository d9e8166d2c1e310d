//! Points as a figure, as comma-separated values, and summed up.

use super::{Point, Source, front, together};
use crate::judge::Tally;
use crate::plot::{Axis, Figure, Panel, Scale, Series, Style};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write;

/// Two panels for each source of sets: what is missed and what is a false hit.
pub fn figure(sets: &[Vec<Point>]) -> Figure {
    let mut panels = Vec::new();
    for (source, kind) in SOURCES {
        let chosen: Vec<&[Point]> =
            sets.iter().map(|set| &set[..]).filter(|set| is_of(source, set)).collect();
        let title = format!("{} sets {kind}", chosen.len());
        let points = together(&title, &chosen);
        let bound = points.first().map_or(0.0, |point| point.tally.bound());
        for (what, wrong) in COUNTED {
            panels.push(Panel {
                title: format!("{title}: {what}"),
                better: "lower left",
                x: Axis { label: "ns per triangle pair, one thread".to_owned(), scale: Scale::Log },
                y: Axis {
                    label: format!("{what} per million (0: below {bound:.0})"),
                    scale: Scale::Log,
                },
                series: points
                    .iter()
                    .map(|point| Series {
                        name: point.test.clone(),
                        points: vec![(point.time, point.tally.per_million(wrong(&point.tally)))],
                        style: Style::Points,
                    })
                    .collect(),
            });
        }
    }
    let title = "Tests of two triangles: time against wrong answers".to_owned();
    Figure { title, columns: 2, panels }
}

const SOURCES: [(Source, &str); 3] = [
    (Source::Family, "made to be hard"),
    (Source::Contact, "from real contact"),
    (Source::FamilyInF64, "made to be hard, in f64"),
];

type Count = fn(&Tally) -> u64;

const COUNTED: [(&str, Count); 2] =
    [("missed", |tally| tally.missed), ("false hits", |tally| tally.false_hits)];

#[derive(Serialize)]
struct Line<'p> {
    set: &'p str,
    real_contact: u8,
    test: &'p str,
    ns_per_pair: f64,
    pairs: u64,
    hits: u64,
    missed: u64,
    false_hits: u64,
    on_front: u8,
}

/// Writes a line for each point. It is on the front of its set if no other is as fast and as right, misses and false
/// hits counted together.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, sets: &[Vec<Point>]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    for points in sets {
        for (point, is_on_front) in points.iter().zip(front(points)) {
            let Tally { pairs, hits, missed, false_hits } = point.tally;
            table.serialize(Line {
                set: &point.set,
                real_contact: u8::from(point.source == Source::Contact),
                test: &point.test,
                ns_per_pair: (1e4 * point.time).round() / 1e4,
                pairs,
                hits,
                missed,
                false_hits,
                on_front: u8::from(is_on_front),
            })?;
        }
    }
    Ok(table.flush()?)
}

/// A line for each set from real contact: what Exact costs, and what beats it.
pub fn summary(sets: &[Vec<Point>]) -> String {
    let mut text =
        "triangle pairs       Exact ns  Fast ns  ratio  wrong per million: Exact, Fast\n"
            .to_owned();
    for set in sets.iter().filter(|set| is_of(Source::Contact, set)) {
        let find = |name: &str| set.iter().find(|p| p.test == name);
        let (Some(exact), Some(fast)) = (find("pfront Exact"), find("Fast")) else {
            continue;
        };
        let rate = |p: &Point| p.tally.per_million(p.tally.wrong());
        let (name, ratio) = (&exact.set, exact.time / fast.time);
        let beats = |p: &&Point| p.time < exact.time && p.tally.wrong() <= exact.tally.wrong();
        let beaten: Vec<&str> = set.iter().filter(beats).map(|p| &*p.test).collect();
        let standing = match &beaten[..] {
            [] => "on the front".to_owned(),
            by => format!("beaten by {}", by.join(", ")),
        };
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{name:<20} {:>8.1} {:>8.1} {ratio:>6.2}  {:.1}, {:.1}; {standing}",
            exact.time,
            fast.time,
            rate(exact),
            rate(fast)
        );
    }
    text
}

fn is_of(source: Source, set: &[Point]) -> bool {
    set.first().is_some_and(|point| point.source == source)
}
