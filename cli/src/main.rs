//! The `pfront` command. Standard output gets results and nothing else.

mod args;
mod command;
mod curve;
mod listing;
mod progress;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use pfront_cli::executor::quieten_drivers;
use pfront_cli::output::{out, remove_half_written};
use pfront_files::escape::{escaped, is_shown};
use std::ffi::OsString;
use std::process::ExitCode;

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const NOTHING_MEETS: u8 = 1;
const REFUSED: u8 = 2;

/// Ends with what is wrong with the command line, which may name files.
fn refuse(error: clap::Error) -> Cli {
    let is_shown = |word: OsString| word.to_string_lossy().chars().all(is_shown);
    if error.use_stderr() && !std::env::args_os().all(is_shown) {
        eprintln!("{}", escaped(&error.render().to_string()));
        std::process::exit(REFUSED.into());
    }
    error.exit()
}

fn main() -> ExitCode {
    quieten_drivers();
    let command = Cli::try_parse().unwrap_or_else(refuse).command;
    let done = remove_half_written().and_then(|()| match command {
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
            eprintln!("error: {}", escaped(&format!("{error:#}")));
            REFUSED.into()
        }
    }
}
