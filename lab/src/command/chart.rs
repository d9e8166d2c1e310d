//! `pfront chart`: speed against accuracy.

use crate::args;
use anyhow::{Context, Result, anyhow};
use indicatif::ProgressBar;
use pfront_cli::executor as how;
use pfront_cli::output::out;
use pfront_lab::chart::frames::Machine;
use pfront_lab::chart::{Charts, Plan};
use pfront_lab::motion;
use pfront_lab::recorded;
use std::fs::{self, File};
use std::io::Write;

pub(crate) fn run(chart: &args::Chart) -> Result<bool> {
    // Before the work, not after it.
    fs::create_dir_all(&chart.out)
        .with_context(|| format!("cannot make the folder {}", chart.out.display()))?;
    let suite = recorded::suite(chart.seed, chart.size)?;
    let plan = if chart.quick { Plan::QUICK } else { Plan::FULL };
    let plan = Plan { pairs: chart.pairs.unwrap_or(plan.pairs), ..plan };
    let machine = Machine { threads: how::number(chart.threads), ..Machine::this() };
    let spinner = ProgressBar::new_spinner();
    let charts = Charts::measure(&suite, &plan, &machine, |what| {
        spinner.set_message(what.to_owned());
        spinner.tick();
    })?;
    spinner.set_message("slow motion");
    let flips = motion::run(if chart.quick { 16 } else { 256 })?;
    spinner.finish_and_clear();
    charts.write(&chart.out)?;
    fs::write(chart.out.join("flips.svg"), motion::draw(&flips).map_err(|e| anyhow!("{e}"))?)?;
    motion::write_csv(File::create(chart.out.join("flips.csv"))?, &flips)?;
    write!(out(), "{}", charts.summary())?;
    Ok(true)
}
