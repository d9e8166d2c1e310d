//! `pfront impacts A [B]`

use super::{check_files, explain, list_fits, model};
use crate::args::Impacts;
use crate::listing::{FileRow, count};
use anyhow::{Context, Result, ensure};
use pfront::{AnyPose, Error, Impact, Model, Motion, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_cli::json::{VERSION, write_json};
use pfront_cli::output::out;
use serde_json::{Value, json};
use std::io::Write;
use std::iter::once;
use std::path::PathBuf;

type Timed = Vec<(TrianglePair, Impact)>;

/// `Ok(false)` if one impact is asked for and there is none.
pub(crate) fn run(asked: &Impacts) -> Result<bool> {
    let ends = [&asked.end_a, &asked.end_b];
    let paths = once(&asked.a).chain(&asked.b).chain(ends.into_iter().flatten());
    check_files(&paths.map(PathBuf::as_path).collect::<Vec<_>>(), None)?;
    let read = |path: &PathBuf| model(path, &asked.reading).map(|(model, _)| model);
    let a = read(&asked.a)?;
    let b = asked.b.as_ref().map(read).transpose()?;
    let [end_a, end_b] = ends.map(|path| path.as_ref().map(read).transpose());
    let (end_a, end_b) = (end_a?, end_b?);
    let of_a = moving(&a, end_a.as_ref(), &asked.end_a)?;
    let of_b = match (&b, &end_b) {
        (None, _) => None,
        (Some(b), None) => Some(Motion::new(b, AnyPose::F32(Pose::IDENTITY), asked.pose())?),
        (Some(b), end) => Some(moving(b, end.as_ref(), &asked.end_b)?),
    };
    ensure!(
        of_b.is_some() || end_a.is_some(),
        "one mesh alone has to move: --end-a FILE says where to"
    );
    let files = once((&asked.a, &a)).chain(asked.b.iter().zip(&b));
    let files = files.map(|(path, model)| FileRow::new(path, [model])).collect();
    let motions = (&of_a, of_b.as_ref());
    if asked.count {
        let counts = ask(asked, motions, PairQuery::count_impacts, SelfQuery::count_impacts)?;
        print_counts(asked, files, counts)?;
        return Ok(true);
    }
    let one = |found: Option<_>| found.into_iter().collect();
    let found: Timed = match (asked.first, asked.any) {
        (true, _) => one(ask(asked, motions, PairQuery::first_impact, SelfQuery::first_impact)?),
        (_, true) => one(ask(asked, motions, PairQuery::any_impact, SelfQuery::any_impact)?),
        _ => ask(asked, motions, PairQuery::impacts, SelfQuery::impacts)?,
    };
    list_fits(found.len(), size_of::<(TrianglePair, Impact)>(), &asked.reading)?;
    print(asked, files, &found)?;
    Ok(!(asked.first || asked.any) || !found.is_empty())
}

/// A mesh that deforms into another, or stays.
fn moving<'m>(
    start: &'m Model,
    end: Option<&'m Model>,
    path: &Option<PathBuf>,
) -> Result<Motion<'m>> {
    let Some(end) = end else { return Ok(Motion::at_rest(start)) };
    let name = || path.as_ref().map(|path| path.display().to_string()).unwrap_or_default();
    Motion::between(start, end).with_context(name)
}

/// Asks a verb about two motions, or about one mesh that deforms.
fn ask<T>(
    asked: &Impacts,
    (a, b): (&Motion<'_>, Option<&Motion<'_>>),
    of_two: fn(&mut PairQuery, &Motion<'_>, &Motion<'_>) -> Result<T, Error>,
    of_one: fn(&mut SelfQuery, &Motion<'_>) -> Result<T, Error>,
) -> Result<T> {
    let (executor, within) = (asked.executor.open()?, asked.within.unwrap_or(0.0));
    let (answer, plan) = match b {
        Some(b) => {
            let mut query = PairQuery::new().within(within)?.on(&executor);
            (of_two(&mut query, a, b)?, query.plan().cloned())
        }
        None => {
            let mut query = SelfQuery::new().within(within)?.on(&executor);
            (of_one(&mut query, a)?, query.plan().cloned())
        }
    };
    explain(&asked.executor, plan.as_ref());
    Ok(answer)
}

/// Writes an answer as JSON, with what was asked.
fn print_json(asked: &Impacts, files: Vec<FileRow>, mut answer: Value) -> Result<()> {
    answer["version"] = json!(VERSION);
    answer["files"] = json!(files);
    if let Some(distance) = asked.within {
        answer["within"] = json!(distance);
    }
    Ok(write_json(&mut out(), &answer)?)
}

fn print(asked: &Impacts, files: Vec<FileRow>, found: &Timed) -> Result<()> {
    if asked.json {
        let row = |(pair, impact): &(TrianglePair, Impact)| {
            // JSON has no infinity.
            let to = impact.is_proven().then_some(impact.to);
            json!({ "a": pair.a, "b": pair.b, "from": impact.from, "to": to })
        };
        let rows = found.iter().map(row).collect::<Vec<_>>();
        return print_json(asked, files, json!({ "count": found.len(), "impacts": rows }));
    }
    let mut out = out();
    for (TrianglePair { a, b }, Impact { from, to }) in found {
        writeln!(out, "{a} {b} {from} {to}")?;
    }
    let open = found.iter().filter(|(_, impact)| !impact.is_proven()).count();
    say_open(open as u64, found.len() as u64);
    Ok(())
}

fn print_counts(asked: &Impacts, files: Vec<FileRow>, [low, high]: [u64; 2]) -> Result<()> {
    if asked.json {
        return print_json(asked, files, json!({ "count": high, "proven": low }));
    }
    let pairs = count(usize::try_from(high)?, "pair");
    match low == high {
        true => writeln!(out(), "{pairs}")?,
        false => writeln!(out(), "{low} to {pairs}")?,
    }
    say_open(high - low, high);
    Ok(())
}

/// Says on standard error how many pairs are open, if any are.
fn say_open(open: u64, all: u64) {
    if open > 0 {
        eprintln!("{open} of {all} are open: they touch, or come within rounding errors");
    }
}
