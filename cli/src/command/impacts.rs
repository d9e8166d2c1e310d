//! `pfront impacts A [B]`

use super::{check_files, explain, list_fits, model};
use crate::args::Impacts;
use crate::listing::FileRow;
use anyhow::{Context, Result, ensure};
use pfront::{AnyPose, Executor, Impact, Model, Motion, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_cli::json::{VERSION, write_json};
use pfront_cli::output::out;
use serde_json::json;
use std::io::Write;
use std::iter::once;
use std::path::PathBuf;

type Timed = Vec<(TrianglePair, Impact)>;

/// `Ok(false)` if the first impact is asked for and there is none.
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
    let executor = asked.executor.open()?;
    let found = match &b {
        Some(b) => {
            let of_b = match &end_b {
                None => Motion::new(b, AnyPose::F32(Pose::IDENTITY), asked.pose())?,
                end => moving(b, end.as_ref(), &asked.end_b)?,
            };
            of_two(asked, &executor, [&of_a, &of_b])?
        }
        None => {
            ensure!(end_a.is_some(), "one mesh alone has to move: --end-a FILE says where to");
            of_one(asked, &executor, &of_a)?
        }
    };
    list_fits(found.len(), size_of::<(TrianglePair, Impact)>(), &asked.reading)?;
    let files = once((&asked.a, &a)).chain(asked.b.iter().zip(&b));
    let files = files.map(|(path, model)| FileRow::new(path, [model])).collect();
    print(asked, files, &found)?;
    Ok(!asked.first || !found.is_empty())
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

fn of_two(asked: &Impacts, executor: &Executor, [a, b]: [&Motion<'_>; 2]) -> Result<Timed> {
    let mut query = PairQuery::new().on(executor);
    let found = match asked.first {
        true => query.first_impact(a, b)?.into_iter().collect(),
        false => query.impacts(a, b)?,
    };
    explain(&asked.executor, query.plan());
    Ok(found)
}

fn of_one(asked: &Impacts, executor: &Executor, motion: &Motion<'_>) -> Result<Timed> {
    let mut query = SelfQuery::new().on(executor);
    let found = match asked.first {
        true => query.first_impact(motion)?.into_iter().collect(),
        false => query.impacts(motion)?,
    };
    explain(&asked.executor, query.plan());
    Ok(found)
}

fn print(asked: &Impacts, files: Vec<FileRow>, found: &Timed) -> Result<()> {
    let mut out = out();
    if asked.json {
        let row = |(pair, impact): &(TrianglePair, Impact)| {
            // JSON has no infinity.
            let to = impact.is_proven().then_some(impact.to);
            json!({ "a": pair.a, "b": pair.b, "from": impact.from, "to": to })
        };
        let answer = json!({
            "version": VERSION,
            "files": files,
            "count": found.len(),
            "impacts": found.iter().map(row).collect::<Vec<_>>(),
        });
        write_json(&mut out, &answer)?;
        return Ok(());
    }
    for (TrianglePair { a, b }, Impact { from, to }) in found {
        writeln!(out, "{a} {b} {from} {to}")?;
    }
    let open = found.iter().filter(|(_, impact)| !impact.is_proven()).count();
    if open > 0 {
        eprintln!("{open} of {} are open: they touch, or come within rounding errors", found.len());
    }
    Ok(())
}
