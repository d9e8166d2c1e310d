//! `pfront-lab chart`: speed against accuracy.

use super::progress;
use anyhow::{Context, Result};
use clap::Args;
use pfront_cli::output::out;
use pfront_lab::{chart, recorded};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Chart {
    /// The folder to write into
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// How many triangle pairs of all sets together [default: 4 million, or 80,000]
    #[arg(long, value_name = "N")]
    pairs: Option<u64>,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// The seed of everything random
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Measure little, to see that it works
    #[arg(long)]
    quick: bool,
}

pub(crate) fn run(asked: &Chart) -> Result<bool> {
    let folder = &asked.out;
    // Before the work, not after it.
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let (pairs, rounds) = if asked.quick { (80_000, 3) } else { (4_000_000, 9) };
    let suite = recorded::suite(asked.seed, asked.size)?;
    let bar = progress(suite.sets().len() as u64, "set");
    let pairs = asked.pairs.unwrap_or(pairs);
    let mut sets = chart::measure(&suite, pairs, rounds, |set| bar.set_position(set as u64));
    let each = pairs.div_ceil(suite.sets().len() as u64);
    sets.extend(chart::measure_in_f64(each, asked.seed, rounds));
    bar.finish_and_clear();
    fs::write(folder.join("pareto.svg"), chart::figure(&sets).svg())?;
    chart::write_csv(BufWriter::new(File::create(folder.join("pareto.csv"))?), &sets)?;
    write!(out(), "{}", chart::summary(&sets))?;
    Ok(true)
}
