//! `pfront-lab judge`: whose answers to triangle pairs are right.

use super::progress;
use anyhow::Result;
use clap::Args;
use pfront_cli::output::out;
use pfront_lab::judge::{FAST, IN_F64, OURS, OnGpu, Tally, Test, judge, judge_in_f64};
use pfront_lab::suite::{Block, Set, Suite};
use pfront_testkit::families::InF64;
use std::io::{self, Write};

#[derive(Debug, Args)]
pub(crate) struct Judge {
    /// How many pairs to generate, equally many of each set
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pairs: u64,
    /// Number that the pairs are generated from
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Ask a GPU too
    #[arg(long)]
    gpu: bool,
    /// Judge pairs in f64
    #[arg(long, conflicts_with = "gpu")]
    in_f64: bool,
}

pub(crate) fn run(asked: &Judge) -> Result<bool> {
    let (sets, columns) = if asked.in_f64 { of_f64(asked) } else { of_suite(asked)? };
    print(&mut out(), &sets, &columns)?;
    Ok(columns.iter().all(Column::keeps_its_promise))
}

/// The names of sets, and the answers to them.
type Table = (Vec<String>, Vec<Column>);

/// Somebody's answers: a tally for each set.
struct Column {
    name: String,
    /// Whether no hit may be missed, and none invented.
    promises: [bool; 2],
    tallies: Vec<Tally>,
}

/// A column for each test; no hit may be missed, and none invented, as promised.
fn columns<T>(tests: &[Test<T>], promises: &[[bool; 2]], scores: &[Vec<Tally>]) -> Vec<Column> {
    let column = |(i, (test, &promises)): (usize, (&Test<T>, &[bool; 2]))| {
        let tallies = scores.iter().map(|score| score[i]).collect();
        Column { name: test.name.to_owned(), promises, tallies }
    };
    tests.iter().zip(promises).enumerate().map(column).collect()
}

fn of_f64(asked: &Judge) -> Table {
    let promises = [[true; 2], [false; 2], [false; 2]];
    let columns = columns(&IN_F64, &promises, &judge_in_f64(asked.pairs, asked.seed));
    (InF64::ALL.map(InF64::name).into(), columns)
}

fn of_suite(asked: &Judge) -> Result<Table> {
    let suite = Suite::generated(asked.seed, None)?;
    let names: Vec<_> = suite.sets.iter().map(Set::name).collect();
    let mut gpu = asked.gpu.then(OnGpu::new).transpose()?;
    let mut on_gpu = vec![Tally::default(); names.len()];
    let bar = progress(asked.pairs, "pair");
    let tests = [&OURS[..], &[FAST]].concat();
    let scores = judge(&suite, asked.pairs, &tests, |Block { set, cases }| {
        if let Some(gpu) = &mut gpu {
            on_gpu[*set].add(&Tally::of(cases, gpu.answers(cases)?));
        }
        bar.inc(cases.len() as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    let promises = [[true; 2], [true; 2], [false; 2]];
    let mut columns = columns(&tests, &promises, &scores);
    if let Some(gpu) = gpu {
        let name = format!("{}, {} left to the CPU", gpu.name(), gpu.left_to_cpu());
        columns.push(Column { name, promises: [true; 2], tallies: on_gpu });
    }
    Ok((names, columns))
}

impl Column {
    fn total(&self) -> Tally {
        let mut total = Tally::default();
        self.tallies.iter().for_each(|tally| total.add(tally));
        total
    }

    fn keeps_its_promise(&self) -> bool {
        let Tally { missed, false_hits, .. } = self.total();
        self.promises.into_iter().zip([missed, false_hits]).all(|(it, wrong)| !it || wrong == 0)
    }
}

/// Prints a line for each set, then one for each who answered.
fn print(out: &mut impl Write, sets: &[String], columns: &[Column]) -> io::Result<()> {
    let letters = || ('A'..='Z').zip(columns);
    write!(out, "{:<20} {:>11} {:>11} {:>8}", "set", "pairs", "hits", "3/N")?;
    letters()
        .try_for_each(|(letter, _)| write!(out, " {:>18}", format!("{letter}: miss/false")))?;
    writeln!(out)?;
    for (i, set) in sets.iter().enumerate() {
        let tally = columns[0].tallies[i];
        let (Tally { pairs, hits, .. }, bound) = (tally, 1e-6 * tally.bound());
        write!(out, "{set:<20} {pairs:>11} {hits:>11} {bound:>8.1e}")?;
        for column in columns {
            let Tally { missed, false_hits, .. } = column.tallies[i];
            write!(out, " {:>18}", format!("{missed}/{false_hits}"))?;
        }
        writeln!(out)?;
    }
    for (letter, column) in letters() {
        let total = column.total();
        let said = |what: &str, count: u64| match count {
            0 => format!("0 of {} {what} (< {:.1e})", total.pairs, 1e-6 * total.bound()),
            _ => format!("{count} of {} {what}", total.pairs),
        };
        let [missed, false_hits] =
            [said("missed", total.missed), said("false hits", total.false_hits)];
        writeln!(out, "{letter}: {}: {missed}, {false_hits}", column.name)?;
    }
    writeln!(out, "(< 3/N): where none was seen, the rate is below that with 95 % confidence")
}
