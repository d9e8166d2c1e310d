//! The `pfront` command. Standard output gets results and nothing else.

mod args;
mod command;
mod curve;
mod listing;
mod progress;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use pfront_cli::executor::quieten_drivers;
use pfront_cli::output::{out, remove_half_written_on_interrupt};
use std::process::ExitCode;

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const NOTHING_MEETS: u8 = 1;
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    quieten_drivers();
    let command = Cli::parse().command;
    let done = remove_half_written_on_interrupt().and_then(|()| match command {
        None => command::bench::demo(),
        Some(Command::Pairs { meshes, listing, executor }) => {
            command::pairs::run(&meshes, &listing, &executor)
        }
        Some(Command::Any { meshes, executor, json }) => {
            command::any::run(&meshes, &executor, json)
        }
        Some(Command::SelfCollision(asked)) => command::self_collision::run(&asked),
        Some(Command::Scene(asked)) => command::scene::run(&asked),
        Some(Command::Bake(bake)) => command::bake::run(&bake),
        Some(Command::Bench(bench)) => command::bench::run(&bench),
        Some(Command::Devices { json }) => command::devices::run(json),
        Some(Command::Completions { shell }) => {
            clap_complete::generate(shell, &mut Cli::command(), "pfront", &mut out());
            Ok(true)
        }
    });
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => NOTHING_MEETS.into(),
        Err(error) => {
            eprintln!("error: {error:#}");
            REFUSED.into()
        }
    }
}
