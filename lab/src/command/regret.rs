//! `pfront-lab regret`: what the choices of an executor cost, against the best of all fixed plans.

use super::progress;
use anyhow::Result;
use clap::Args;
use pfront_cli::executor::{Backend, adapter_name, number, parse_threads};
use pfront_cli::output::{Draft, out};
use pfront_lab::regret::{Case, Effort, Field, Scale, race, recipes, summary, write_csv};
use std::io::Write;
use std::num::NonZero;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
pub(crate) struct Regret {
    /// Number that the cases are generated from
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// How many of them [default: 48, or 8]
    #[arg(long, value_name = "N")]
    cases: Option<NonZero<usize>>,
    /// How often everyone plays a case; short ones are played more often [default: 5, or 1]
    #[arg(long, value_name = "N")]
    rounds: Option<NonZero<usize>>,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    threads: Option<NonZero<usize>>,
    /// Backends to choose from beside CPU threads
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// Write one line for each case
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Play this instead of drawn cases: a workload (.tcw), a built-in scene, or meshes as record takes them; may be given
    /// again
    #[arg(long, value_name = "FILE", conflicts_with_all = ["seed", "cases", "quick"])]
    workload: Vec<String>,
    /// Frames of each workload; a shorter file is played to and fro
    #[arg(long, value_name = "N", default_value_t = 300, requires = "workload")]
    frames: u32,
    /// Few and small cases, to see that it works
    #[arg(long)]
    quick: bool,
}

/// Cases, rounds of each at least, and how long to go on with more.
const FULL: (usize, Effort) = (48, Effort { rounds: 5, time: Duration::from_millis(300) });
const QUICK: (usize, Effort) = (8, Effort { rounds: 1, time: Duration::ZERO });

pub(crate) fn run(asked: &Regret) -> Result<bool> {
    let (scale, (cases, effort)) =
        if asked.quick { (Scale::QUICK, QUICK) } else { (Scale::FULL, FULL) };
    let cases = asked.cases.map_or(cases, NonZero::get);
    let effort = Effort { rounds: asked.rounds.map_or(effort.rounds, NonZero::get), ..effort };
    // Before the work, not after it.
    let mut csv = asked.csv.as_deref().map(Draft::new).transpose()?;
    let gpu = asked.backend.open()?;
    let mut out = out();
    let threads = number(asked.threads);
    writeln!(out, "seed {}, {threads} threads", asked.seed)?;
    let mut field = Field::new(threads)?;
    if let Some(gpu) = &gpu {
        writeln!(out, "GPU: {}", adapter_name(&gpu.device().adapter_info()))?;
        field = field.with_gpu(gpu)?;
    }
    field.warm_up()?;
    let drawn = recipes(asked.seed, if asked.workload.is_empty() { cases } else { 0 });
    let drawn = drawn.into_iter().map(|recipe| recipe.build(&scale));
    let played = asked.workload.iter().map(|name| Case::of_workload(name, asked.frames));
    let bar = progress((drawn.len() + played.len()) as u64, "case");
    let mut rows = Vec::new();
    for case in drawn.chain(played) {
        let case = case?;
        bar.set_message(format!("{}, ", case.name));
        let row = race(&case, &field, &effort)?;
        bar.suspend(|| {
            if rows.is_empty() {
                writeln!(out, "{}", row.heading())?;
            }
            writeln!(out, "{row}")?;
            out.flush()
        })?;
        rows.push(row);
        bar.inc(1);
    }
    bar.finish_and_clear();
    writeln!(out, "\n{}", summary(&rows))?;
    if let Some(mut file) = csv.take() {
        write_csv(&mut file, &rows)?;
        file.finish()?;
    }
    Ok(true)
}
