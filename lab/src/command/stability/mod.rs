//! `pfront stability`: where fronts could fail, ours beside the paper's as printed.

mod draw;
mod print;

use super::progress;
use crate::args::Stability;
use anyhow::Result;
use pfront_cli::output::{Draft, out};
use pfront_lab::stability::times::{Times, time};
use pfront_lab::stability::{Length, Method, Outcome, ROWS, Row};
use std::io::Write;

/// A row, and what it came to.
struct Played {
    row: Row,
    outcome: Outcome,
    /// Its scenes by the clock, if that was asked for.
    times: Vec<(&'static str, Vec<Times>)>,
}

pub(crate) fn run(asked: &Stability) -> Result<bool> {
    let length = if asked.quick { Length::Quick } else { Length::Full };
    let wanted = |row: &Row| asked.row.is_empty() || asked.row.iter().any(|name| name == row.name);
    let mut cast = Vec::new();
    for row in ROWS.into_iter().filter(wanted) {
        cast.push((row, row.scenes(length)?));
    }
    let frames: usize = cast.iter().flat_map(|row| &row.1).map(|scene| scene.steps().len()).sum();
    let bar = progress(frames as u64);
    let mut all = Vec::new();
    for (row, mut scenes) in cast {
        let outcome = row.run(&mut scenes, &asked.p, &mut || bar.inc(1))?;
        let mut times = Vec::new();
        if asked.svg.is_some() && !outcome.series.is_empty() {
            for scene in &mut scenes {
                times.push((scene.name, time(scene)?));
            }
        }
        all.push(Played { row, outcome, times });
    }
    bar.finish_and_clear();
    print::table(&mut out(), &asked.p, &all)?;
    if let Some(path) = &asked.csv {
        let mut file = Draft::new(path)?;
        print::lines(&mut file, &all)?;
        file.finish()?;
    }
    if let Some(path) = &asked.svg {
        let mut file = Draft::new(path)?;
        file.write_all(draw::page(&asked.p, &all)?.as_bytes())?;
        file.finish()?;
    }
    Ok(all.iter().all(|played| played.outcome.holds(Method::Ours)))
}
