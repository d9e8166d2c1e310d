//! The `pfront-lab` command. Standard output gets results and nothing else.

mod args;
mod charts;
mod command;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const FAILED: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Replay(replay) => command::replay::run(&replay),
        Command::Record(record) => command::record::run(&record),
        Command::Balance(balance) => command::balance::run(&balance),
        Command::Judge(judge) => command::judge::run(&judge),
        Command::Chart(chart) => command::chart::run(&chart),
        Command::Stability(stability) => command::stability::run(&stability),
        Command::Regret(regret) => command::regret::run(&regret),
        Command::Passes(passes) => command::passes::run(&passes),
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
