//! The `pfront-lab` command. Standard output gets results and nothing else.

mod command;

use clap::{Parser, Subcommand};
use command::balance::Balance;
use command::chart::Chart;
use command::judge::Judge;
use command::passes::Passes;
use command::phases::Phases;
use command::record::Record;
use command::regret::Regret;
use command::replay::Replay;
use command::stability::Stability;
use pfront_cli::executor::quieten_drivers;
use std::process::ExitCode;

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  judge, stability: a promise is broken
  2  the command line or a file was refused; standard error says why";

/// Measures pfront: speed against accuracy, balance, stability, and the regret of choices
#[derive(Debug, Parser)]
#[command(name = "pfront-lab", version, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a recorded workload; prints tab-separated lines
    ///
    /// BUILD ms cpu_ms; FRAME number update_ms query_ms pairs update_cpu_ms query_cpu_ms (with --mode any, pairs is 1 or
    /// 0); at the end RSS and the most bytes of memory that the process had. `update` is moving the objects and
    /// refitting, `query` is the rest; `cpu` is the time of all threads.
    Replay(Replay),
    /// Write a built-in scene as a workload
    Record(Record),
    /// Show how evenly p-partition fronts divide the work, for any number of workers
    ///
    /// Work is counted in box and triangle tests, not timed (but for the share of time that the front takes),
    /// so that the figures mean the same on every machine and p may be larger than its number of cores.
    Balance(Balance),
    /// Count wrong answers to triangle pairs whose truth is known
    ///
    /// Without a file, pairs are generated: random, nearly touching, coplanar, degenerate, of every scale, and
    /// harvested from meshes in contact. A million pairs take about a minute on two cores.
    Judge(Judge),
    /// Chart speed against accuracy of tests of two triangles, pfront's, inexact ones and those of the literature
    ///
    /// Writes pareto.svg and pareto.csv, and prints what Exact costs. With the meshes of the folder that PFRONT_DATA
    /// names, if it does. Takes about three minutes on two cores; --quick, some seconds.
    Chart(Chart),
    /// Show that fronts divide work evenly where they could fail, beside the paper's equations as printed
    ///
    /// Each row of the matrix plays its scenes with every number of workers; answers are compared with those of
    /// one core, small ones with an exact oracle too. Prints the figure nearest to its limit, or farthest
    /// beyond, in counted work. The whole matrix takes two minutes on 16 cores, more on fewer: name a --row or two to see
    /// that it works.
    Stability(Stability),
    /// Measure what --backend auto costs, against the best of all plans that never change
    ///
    /// Cases are drawn from a seed: two bodies, a sheet, or up to ten thousand bodies, that rest, move, meet or jump; or
    /// workloads are played. Everyone plays each case in turn, and answers are compared. "naive" is a rule of five constants
    /// that knows how long one thread takes; A/A is how far a plan is from itself. 48 cases take some minutes; --quick, a
    /// second.
    Regret(Regret),
    /// Show where a GPU spends its time: the median of each pass, by the device's own clock
    Passes(Passes),
    /// Show where threads spend the time of a frame, beside as many frames at once as there are threads
    Phases(Phases),
}

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const FAILED: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    quieten_drivers();
    let done = match Cli::parse().command {
        Command::Replay(replay) => command::replay::run(&replay),
        Command::Record(record) => command::record::run(&record),
        Command::Balance(balance) => command::balance::run(&balance),
        Command::Judge(judge) => command::judge::run(&judge),
        Command::Chart(chart) => command::chart::run(&chart),
        Command::Stability(stability) => command::stability::run(&stability),
        Command::Regret(regret) => command::regret::run(&regret),
        Command::Passes(passes) => command::passes::run(&passes),
        Command::Phases(phases) => command::phases::run(&phases),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => FAILED.into(),
        Err(error) => {
            eprintln!("error: {error:#}");
            REFUSED.into()
        }
    }
}
