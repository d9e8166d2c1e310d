//! The `pfront` command. Standard output gets results and nothing else.

mod adapters;
mod args;
mod charts;
mod command;
mod engine;
mod gpus;
mod how;
mod listing;
mod memory;
mod output;
mod recording;
mod stacks;

use args::{Bench, Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// What a script can tell apart; 2 is also what clap exits with.
const NOTHING_MEETS: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        None => command::demo::run(),
        Some(Command::Pairs { meshes, listing, how }) => {
            command::pairs::run(&meshes, &listing, &how)
        }
        Some(Command::Any { meshes, how }) => command::any::run(&meshes, &how),
        Some(Command::Within(within)) => command::within::run(&within),
        Some(Command::Replay(replay)) => command::replay::run(&replay),
        Some(Command::Record(record)) => command::record::run(&record),
        Some(Command::Bake(bake)) => command::bake::run(&bake),
        Some(Command::Balance(balance)) => command::balance::run(&balance),
        Some(Command::Chart(chart)) => command::chart::run(&chart),
        Some(Command::Judge(judge)) => command::judge::run(&judge),
        Some(Command::Stability(stability)) => command::stability::run(&stability),
        Some(Command::Regret(regret)) => command::regret::run(&regret),
        Some(Command::Bench { what: Bench::Gpu(bench) }) => command::bench::run(&bench),
        Some(Command::Devices { json }) => command::devices::run(json),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => NOTHING_MEETS.into(),
        Err(error) => {
            eprintln!("error: {error:#}");
            REFUSED.into()
        }
    }
}
