//! Which test changes an answer when, and whether the truth did.

use super::slide::{NAMES, Slide};
use crate::judge::{OURS, Test};
use crate::plot::{Axis, Figure, Panel, Scale, Series};
use crate::textbook::PARRY;
use anyhow::Result;
use pfront_testkit::oracle::intersect;
use rayon::prelude::*;
use serde::Serialize;
use std::io::Write;

/// The tests of two triangles that are watched: exact, plain f32, and parry3d's own.
pub const METHODS: [Test; 3] = [OURS[0], OURS[3], PARRY];

/// What one method did on one slide in steps of one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// One of [`NAMES`].
    pub slide: &'static str,
    /// By how much the scene moves from frame to frame; its lengths are about 1.
    pub step: f64,
    /// The name of one of [`METHODS`].
    pub method: &'static str,
    /// How many answers: pairs times frames.
    pub answers: u64,
    /// How often the truth changed.
    pub truth: u64,
    /// How often the answer changed where the truth did not.
    pub flips: u64,
    /// How often the truth changed where the answer did not.
    pub missed: u64,
    /// How many answers are wrong.
    pub wrong: u64,
}

/// The sizes of steps, of which the first is one unit in the last place of a number just below 1.
pub const STEPS: [f64; 5] = [1.0 / (1 << 24) as f64, 1e-6, 1e-5, 1e-4, 1e-3];

/// Moves every slide of [`NAMES`] through its contact in `frames` steps of each size: rows by slide, then by
/// step, then by method.
///
/// # Errors
/// If a scene has changed so that nothing happens in it any more.
///
/// # Complexity
/// Some 30 µs a pair and frame, which the truth takes; up to 130 pairs a slide. On all threads of the rayon pool.
pub fn run(frames: u32) -> Result<Vec<Row>> {
    let slides: Vec<_> = NAMES.iter().map(|name| Slide::by_name(name)).collect::<Result<_>>()?;
    let courses: Vec<_> = slides.iter().flat_map(|slide| STEPS.map(|step| (slide, step))).collect();
    Ok(courses.into_par_iter().flat_map_iter(|(slide, step)| course(slide, step, frames)).collect())
}

/// What is true of one pair, and what each method says.
#[derive(Clone, Default, PartialEq)]
struct Said {
    truth: bool,
    answers: [bool; METHODS.len()],
}

/// One slide in steps of one size, half of them before the event.
fn course(slide: &Slide, step: f64, frames: u32) -> [Row; METHODS.len()] {
    let mut rows = METHODS.map(|method| Row {
        slide: slide.name,
        step,
        method: method.name,
        answers: 0,
        truth: 0,
        flips: 0,
        missed: 0,
        wrong: 0,
    });
    let mut last: Vec<Said> = Vec::new();
    for frame in 0..frames {
        let length = step * (f64::from(frame) - f64::from(frames) / 2.0);
        let said = |[a, b]: &[_; 2]| Said {
            truth: intersect(a, b),
            answers: METHODS.map(|method| (method.meets)(a, b)),
        };
        let now: Vec<_> = slide.pairs(length).iter().map(said).collect();
        for (k, row) in rows.iter_mut().enumerate() {
            row.answers += now.len() as u64;
            row.wrong += now.iter().filter(|said| said.answers[k] != said.truth).count() as u64;
            // None, in the first frame.
            for (was, is) in last.iter().zip(&now) {
                let (turned, changed) = (was.truth != is.truth, was.answers[k] != is.answers[k]);
                row.truth += u64::from(turned);
                row.flips += u64::from(changed && !turned);
                row.missed += u64::from(turned && !changed);
            }
        }
        last = now;
    }
    rows
}

/// Changes of the truth, and of each method beyond those, over the size of steps. Wrong answers stand below, since a
/// method that always says the same never flips.
#[must_use]
pub fn figure(rows: &[Row]) -> Figure {
    let counted: [(&str, fn(&Row) -> u64); 2] =
        [("changes that the truth has not", |row| row.flips), ("wrong answers", |row| row.wrong)];
    let mut panels = Vec::new();
    for (what, count) in counted {
        for slide in NAMES {
            let of = |method: &str, count: fn(&Row) -> u64| -> Vec<(f64, f64)> {
                let rows = rows.iter().filter(|row| row.slide == slide && row.method == method);
                rows.map(|row| (row.step, count(row) as f64)).collect()
            };
            let series =
                |name: &str, points| Series { name: name.to_owned(), points, is_line: true };
            let mut all: Vec<_> =
                METHODS.iter().map(|test| series(test.name, of(test.name, count))).collect();
            all.push(series("changes of the truth", of(METHODS[0].name, |row| row.truth)));
            let answers = rows.iter().find(|row| row.slide == slide).map_or(0, |row| row.answers);
            panels.push(Panel {
                title: format!("{slide}, {answers} answers"),
                better: "down",
                x: Axis {
                    label: "motion per frame (sizes are about 1)".to_owned(),
                    scale: Scale::Log,
                },
                y: Axis { label: what.to_owned(), scale: Scale::Log },
                series: all,
            });
        }
    }
    let title = "Answers over slow motion through contact".to_owned();
    Figure { title, columns: NAMES.len(), panels }
}

/// Writes a line for each row, below the names of the columns.
///
/// # Errors
/// If it cannot be written.
pub fn write_csv(to: impl Write, rows: &[Row]) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(to);
    rows.iter().try_for_each(|row| table.serialize(row))?;
    Ok(table.flush()?)
}
