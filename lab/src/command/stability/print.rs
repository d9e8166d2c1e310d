//! The matrix as a table, and its frames as CSV.

use super::Played;
use anyhow::Result;
use pfront_lab::stability::{Finding, Frame, Method, Series};
use std::io::{self, Write};

/// One line for each row, measure and method; a column for each p.
pub(super) fn table(out: &mut impl Write, workers: &[usize], all: &[Played]) -> io::Result<()> {
    write!(out, "{:<16} {:<14} {:<17}", "row", "measured", "method")?;
    for p in workers {
        write!(out, " {:>13}", format!("p = {p} "))?;
    }
    writeln!(out)?;
    for Played { row, outcome, .. } in all {
        let mut name = row.name;
        let mut measures: Vec<&str> = outcome.findings.iter().map(|found| found.measure).collect();
        measures.sort_unstable();
        measures.dedup();
        for measure in measures {
            for method in Method::ALL {
                let is_meant = |f: &&Finding| f.measure == measure && f.method == method;
                let found: Vec<_> = outcome.findings.iter().filter(is_meant).collect();
                if !found.is_empty() {
                    line(out, name, workers, &found)?;
                    name = "";
                }
            }
        }
    }
    writeln!(
        out,
        "\nfigure/limit, the worst of all frames; ! beyond it, ? an answer wrong or a cost that is no number,\n\
         ~ workers with so little to do that the limit is wider"
    )?;
    summary(out, all)
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
    // A change or a drift is a share.
    let number = |x: f64| match measure {
        "imbalance" if x >= 100.0 => format!("{x:.0}"),
        "imbalance" if x.is_finite() => format!("{x:.2}"),
        "imbalance" => "-".to_owned(),
        "wrong pairs" => format!("{x}"),
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

fn summary(out: &mut impl Write, all: &[Played]) -> io::Result<()> {
    for method in Method::ALL {
        let judged = |played: &&Played| played.outcome.findings.iter().any(|f| f.method == method);
        let rows: Vec<_> = all.iter().filter(judged).collect();
        let failing: Vec<_> = rows.iter().filter(|played| !played.outcome.holds(method)).collect();
        let (passing, count) = (rows.len() - failing.len(), rows.len());
        write!(out, "{:<17} passes {passing} of {count} rows", method.name())?;
        let names: Vec<_> = failing.iter().map(|played| played.row.name).collect();
        writeln!(out, "{}{}", if names.is_empty() { "" } else { "; fails " }, names.join(", "))?;
    }
    let by_oracle: usize = all.iter().map(|played| played.outcome.by_oracle).sum();
    writeln!(out, "{by_oracle} frames compared with the oracle, every one with one core")
}

/// One line for each frame, method and p.
pub(super) fn lines(out: &mut impl Write, all: &[Played]) -> Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record([
        "row",
        "scene",
        "method",
        "p",
        "frame",
        "what",
        "right",
        "imbalance",
        "limit",
        "widened",
        "front_nodes",
        "front_box_tests",
        "predicted",
        "makespan",
        "total",
    ])?;
    for Played { row, outcome, .. } in all {
        for Series { scene, method, workers, frames } in &outcome.series {
            for (i, frame) in frames.iter().enumerate() {
                let Frame { imbalance, limit, predicted, makespan, total, .. } = *frame;
                let names = [row.name, scene, method.name()].map(str::to_owned);
                let place = [workers.to_string(), i.to_string(), frame.what.to_owned()];
                let right = frame.right && frame.finite;
                csv.write_record(names.into_iter().chain(place).chain([
                    u8::from(right).to_string(),
                    format!("{imbalance:.4}"),
                    format!("{limit:.4}"),
                    u8::from(frame.widened).to_string(),
                    frame.nodes.to_string(),
                    frame.front_box_tests.to_string(),
                    format!("{predicted:.1}"),
                    format!("{makespan:.1}"),
                    format!("{total:.1}"),
                ]))?;
            }
        }
    }
    csv.flush()?;
    Ok(())
}
