//! The `pfront` command. Standard output gets results and nothing else.

mod args;
mod command;
mod curve;
mod listing;
mod progress;

use anyhow::Result;
use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use clap_mangen::Man;
use pfront_cli::executor::quieten_drivers;
use pfront_cli::output::{out, remove_half_written};
use pfront_files::escape::{escaped, is_shown};
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

/// Exit codes that a script can tell apart; 2 is also what clap exits with.
const NO: u8 = 1;
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

/// Writes one page for the command and all below it.
fn manual() -> Result<()> {
    let mut command = Cli::command();
    command.build();
    let mut out = out();
    Man::new(command.clone()).render(&mut out)?;
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        let name = format!("pfront {}", below.get_name()).to_uppercase();
        writeln!(out, ".SH \"{name}\"")?;
        let page = Man::new(below.clone());
        page.render_description_section(&mut out)?;
        page.render_synopsis_section(&mut out)?;
        page.render_options_section(&mut out)?;
    }
    Ok(())
}

fn main() -> ExitCode {
    quieten_drivers();
    let words = args::words(std::env::args_os());
    let command = Cli::try_parse_from(words).unwrap_or_else(refuse).command;
    let done = remove_half_written().and_then(|()| match command {
        None => write!(out(), "{}", Cli::command().render_long_help())
            .map_err(Into::into)
            .map(|()| true),
        Some(Command::Demo) => command::bench::demo(),
        Some(Command::Pairs { meshes, listing, executor }) => {
            command::pairs::run(&meshes, &listing, &executor)
        }
        Some(Command::Any { meshes, executor, json }) => {
            command::any::run(&meshes, &executor, json)
        }
        Some(Command::Distance { meshes, executor, json }) => {
            command::distance::run(&meshes, &executor, json)
        }
        Some(Command::Impacts(asked)) => command::impacts::run(&asked),
        Some(Command::SelfCollision(asked)) => command::self_collision::run(&asked),
        Some(Command::Scene(asked)) => command::scene::run(&asked),
        Some(Command::Check(asked)) => command::check::run(&asked),
        Some(Command::Bake(bake)) => command::bake::run(&bake),
        Some(Command::Bench(bench)) => command::bench::run(&bench),
        Some(Command::Devices { json }) => command::devices::run(json),
        Some(Command::Man) => manual().map(|()| true),
        Some(Command::Completions { shell }) => {
            clap_complete::generate(shell, &mut Cli::command(), "pfront", &mut out());
            Ok(true)
        }
    });
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => NO.into(),
        Err(error) => {
            eprintln!("error: {}", escaped(&format!("{error:#}")));
            REFUSED.into()
        }
    }
}
