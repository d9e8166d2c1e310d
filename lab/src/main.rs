//! The `pfront-lab` command. Standard output gets results and nothing else.

mod command;

use clap::{Parser, Subcommand};
use command::chart::Chart;
use command::judge::Judge;
use command::profile::Profile;
use command::record::Record;
use command::regret::Regret;
use command::replay::Replay;
use pfront_cli::executor::quieten_drivers;
use std::process::ExitCode;

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  judge: a promise is broken
  2  the command line or a file was refused; standard error says why";

/// Measures pfront: speed against accuracy, where frames spend their time, and the regret of choices
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
    /// Count wrong answers to triangle pairs whose truth is known
    ///
    /// Pairs are generated: random, nearly touching, coplanar, degenerate, of every scale, and harvested from scenes in
    /// contact. A million pairs take about a minute on two cores.
    Judge(Judge),
    /// Time tests of two triangles, pfront's, inexact ones and those of the literature, beside their wrong answers
    ///
    /// Writes a line of CSV for each test and set, which docs/charts.py draws. Takes about three minutes on two cores.
    Chart(Chart),
    /// Measure what --backend auto costs, against the best of one thread, all threads and a GPU
    ///
    /// Everyone plays each case in turn, and answers are compared.
    Regret(Regret),
    /// Show where threads and a GPU spend the time of a frame, and how evenly it is divided
    Profile(Profile),
}

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const FAILED: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    quieten_drivers();
    let done = match Cli::parse().command {
        Command::Replay(replay) => command::replay::run(&replay),
        Command::Record(record) => command::record::run(&record),
        Command::Judge(judge) => command::judge::run(&judge),
        Command::Chart(chart) => command::chart::run(&chart),
        Command::Regret(regret) => command::regret::run(&regret),
        Command::Profile(profile) => command::profile::run(&profile),
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
