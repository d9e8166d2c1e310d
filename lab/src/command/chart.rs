//! `pfront-lab chart`: speed against accuracy.

use super::progress;
use anyhow::Result;
use clap::Args;
use pfront_cli::output::{Draft, out};
use pfront_lab::chart;
use pfront_lab::suite::Suite;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Chart {
    /// The CSV file to write
    out: PathBuf,
    /// How many triangle pairs of all sets together
    #[arg(long, value_name = "N", default_value_t = 4_000_000)]
    pairs: u64,
    /// How often each test answers; the median counts
    #[arg(long, value_name = "N", default_value_t = 9)]
    rounds: usize,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// The seed of everything random
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(asked: &Chart) -> Result<bool> {
    // Before the work, not after it.
    let mut file = Draft::new(&asked.out)?;
    let suite = Suite::generated(asked.seed, asked.size)?;
    let bar = progress(suite.sets.len() as u64, "set");
    let mut points = chart::measure(&suite, asked.pairs, asked.rounds, || bar.inc(1));
    let each = asked.pairs.div_ceil(suite.sets.len() as u64);
    points.extend(chart::measure_in_f64(each, asked.seed, asked.rounds));
    bar.finish_and_clear();
    chart::write_csv(&mut file, &points)?;
    file.finish()?;
    let mut out = out();
    writeln!(out, "{:<50} {:>9} {:>10} {:>10}", "per million pairs", "ns", "missed", "false")?;
    for (test, [time, missed, false_hits]) in chart::summary(&points) {
        writeln!(out, "{test:<50} {time:>9.1} {missed:>10.1} {false_hits:>10.1}")?;
    }
    Ok(true)
}
