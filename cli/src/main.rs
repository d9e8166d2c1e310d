//! The `pfront` command. Standard output gets results and nothing else.

mod args;
mod command;
mod listing;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const NOTHING_MEETS: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        None => command::bench::demo(),
        Some(Command::Pairs { meshes, listing, executor }) => {
            command::pairs::run(&meshes, &listing, &executor)
        }
        Some(Command::Any { meshes, executor }) => command::any::run(&meshes, &executor),
        Some(Command::SelfCollision(asked)) => command::self_collision::run(&asked),
        Some(Command::Bake(bake)) => command::bake::run(&bake),
        Some(Command::Bench(bench)) => command::bench::run(&bench),
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
