//! The `pfront` command. Standard output gets results and nothing else.

mod args;
mod charts;
mod command;
mod engine;
mod how;
mod listing;
mod memory;
mod recording;

use args::{Cli, Command};
use clap::Parser;
use std::io;
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
        Some(Command::Balance(balance)) => command::balance::run(&balance),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => NOTHING_MEETS.into(),
        // Whoever reads has read enough.
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            REFUSED.into()
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
    io.into_iter().any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
