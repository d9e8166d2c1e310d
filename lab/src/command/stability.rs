//! `pfront-lab stability`: where fronts could fail, ours beside the paper's as printed.

use super::progress;
use anyhow::Result;
use clap::Args;
use clap::builder::{PossibleValuesParser, RangedU64ValueParser};
use pfront_cli::output::out;
use pfront_lab::stability::{Finding, Method, Outcome, ROWS, Row};
use std::io::{self, Write};

#[derive(Debug, Args)]
pub(crate) struct Stability {
    /// Only these rows
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    #[arg(value_parser = PossibleValuesParser::new(ROWS.map(|row| row.name)))]
    row: Vec<String>,
    /// Numbers of workers
    #[arg(short, long, value_delimiter = ',', default_values_t = [1, 2, 7, 64, 1024])]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=65_536))]
    p: Vec<usize>,
}

/// A row, and what it came to.
type Played = (Row, Outcome);

pub(crate) fn run(asked: &Stability) -> Result<bool> {
    let wanted = |row: &Row| asked.row.is_empty() || asked.row.iter().any(|name| name == row.name);
    let mut cast = Vec::new();
    for row in ROWS.into_iter().filter(wanted) {
        cast.push((row, row.scenes()?));
    }
    let frames: usize = cast.iter().flat_map(|row| &row.1).map(|scene| scene.steps().len()).sum();
    let bar = progress(frames as u64, "frame");
    let mut all = Vec::new();
    for (row, mut scenes) in cast {
        let outcome = row.run(&mut scenes, &asked.p, &mut || bar.inc(1))?;
        all.push((row, outcome));
    }
    bar.finish_and_clear();
    table(&mut out(), &asked.p, &all)?;
    Ok(all.iter().all(|(_, outcome)| outcome.holds(Method::Ours)))
}

/// One line for each row, measure and method; a column for each p.
fn table(out: &mut impl Write, workers: &[usize], all: &[Played]) -> io::Result<()> {
    write!(out, "{:<16} {:<14} {:<17}", "row", "measured", "method")?;
    workers.iter().try_for_each(|p| write!(out, " {:>13}", format!("p = {p} ")))?;
    writeln!(out)?;
    for (row, outcome) in all {
        let mut measures: Vec<&str> = outcome.findings.iter().map(|found| found.measure).collect();
        measures.sort_unstable();
        measures.dedup();
        for measure in measures {
            for method in Method::ALL {
                let is_meant = |f: &&Finding| f.measure == measure && f.method == method;
                let found: Vec<_> = outcome.findings.iter().filter(is_meant).collect();
                if !found.is_empty() {
                    line(out, row.name, workers, &found)?;
                }
            }
        }
    }
    writeln!(
        out,
        "\nfigure/limit, the worst of all frames; ! beyond it, ? an answer wrong or a cost that is NaN,\n\
         ~ workers with so little to do that the limit is wider"
    )?;
    for method in Method::ALL {
        let judged = |played: &&Played| played.1.findings.iter().any(|f| f.method == method);
        let rows: Vec<_> = all.iter().filter(judged).collect();
        let failing: Vec<_> = rows.iter().filter(|played| !played.1.holds(method)).collect();
        let (passing, count) = (rows.len() - failing.len(), rows.len());
        write!(out, "{:<17} passes {passing} of {count} rows", method.name())?;
        let names: Vec<_> = failing.iter().map(|played| played.0.name).collect();
        writeln!(out, "{}{}", if names.is_empty() { "" } else { "; fails " }, names.join(", "))?;
    }
    let by_oracle: usize = all.iter().map(|(_, outcome)| outcome.by_oracle).sum();
    writeln!(out, "{by_oracle} frames compared with the oracle, every one with one core")
}

fn line(out: &mut impl Write, name: &str, workers: &[usize], found: &[&Finding]) -> io::Result<()> {
    let first = found[0];
    write!(out, "{name:<16} {:<14} {:<17}", first.measure, first.method.name())?;
    for &p in workers {
        let cell = found.iter().find(|f| f.workers == p).map_or(String::new(), |f| cell(f));
        write!(out, " {cell:>13}")?;
    }
    let failing = found.iter().filter(|f| !f.holds());
    let worst = failing.max_by(|x, y| (x.figure / x.limit).total_cmp(&(y.figure / y.limit)));
    match worst {
        Some(f) => writeln!(out, "  FAIL: p = {}, {}", f.workers, f.place),
        None => writeln!(out, "  pass"),
    }
}

fn cell(found: &Finding) -> String {
    let Finding { measure, figure, limit, .. } = *found;
    // A drift is a share.
    let number = |x: f64| match measure {
        "imbalance" if x >= 100.0 => format!("{x:.0}"),
        "imbalance" if x.is_finite() => format!("{x:.2}"),
        "imbalance" => "-".to_owned(),
        _ => format!("{:.1}%", 100.0 * x),
    };
    let mark = match (found.sound, found.holds(), found.widened) {
        (false, ..) => '?',
        (_, false, _) => '!',
        (_, _, true) => '~',
        _ => ' ',
    };
    format!("{}/{}{mark}", number(figure), number(limit))
}
