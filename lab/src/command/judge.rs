//! `pfront-lab judge`: whose answers to triangle pairs are right.

use super::progress;
use anyhow::{Context, Result};
use clap::Args;
use indicatif::ProgressBar;
use pfront_cli::output::{Draft, out};
use pfront_lab::judge::{
    IN_F64, INEXACT, Judge as Counter, OURS, OnGpu, Tally, Test, tallies_in_f64,
};
use pfront_lab::recorded;
use pfront_lab::suite::{Block, Reader, Writer, answers};
use pfront_testkit::families::InF64;
use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct Judge {
    /// Triangle pairs with their truth, as --out writes them
    file: Option<PathBuf>,
    /// Somebody's answers to the file, a byte for each pair: 1 if they meet, else 0 [default: ours]
    #[arg(long, value_name = "FILE", requires = "file")]
    answers: Option<PathBuf>,
    /// How many pairs to generate, equally many of each set
    #[arg(long, value_name = "N", default_value_t = 1_000_000, conflicts_with = "file")]
    pairs: u64,
    /// Number that the pairs are generated from
    #[arg(long, value_name = "SEED", default_value_t = 1, conflicts_with = "file")]
    seed: u64,
    /// Write them here, with their truth
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    out: Option<PathBuf>,
    /// Ask a GPU too
    #[arg(long, conflicts_with = "answers")]
    gpu: bool,
    /// Judge pairs in f64
    #[arg(long, conflicts_with_all = ["file", "out", "gpu"])]
    in_f64: bool,
}

/// Blocks of a file that are judged at a time.
const WAVE: usize = 128;

pub(crate) fn run(asked: &Judge) -> Result<bool> {
    let (sets, columns) = match (&asked.file, &asked.answers) {
        (Some(file), Some(answers)) => of_answers(file, answers),
        (Some(file), None) => of_file(file, asked.gpu),
        (None, _) if asked.in_f64 => Ok(of_f64(asked)),
        (None, _) => of_suite(asked),
    }?;
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

/// Ours, while they are counted.
struct Ours {
    cpu: Counter,
    gpu: Option<(OnGpu, Vec<Tally>)>,
    bar: ProgressBar,
}

/// All tests that are judged.
fn tests() -> [Test; 4] {
    let ([exact, query], [conservative, fast]) = (OURS, INEXACT);
    [exact, query, conservative, fast]
}

impl Ours {
    fn new(sets: usize, pairs: u64, on_gpu: bool) -> Result<Self> {
        let gpu = if on_gpu { Some((OnGpu::new()?, vec![Tally::default(); sets])) } else { None };
        Ok(Self { cpu: Counter::new(&tests(), sets), gpu, bar: progress(pairs, "pair") })
    }

    fn add(&mut self, blocks: &[Block]) -> Result<()> {
        self.cpu.add(blocks);
        for Block { set, cases } in blocks {
            if let Some((gpu, tallies)) = &mut self.gpu {
                tallies[*set].add(&Tally::of(cases, gpu.answers(cases)?));
            }
            self.bar.inc(cases.len() as u64);
        }
        Ok(())
    }

    fn columns(self) -> Vec<Column> {
        self.bar.finish_and_clear();
        let of_test = |i: usize| self.cpu.scores().iter().map(|score| score[i]).collect();
        let promises = [[true; 2], [true; 2], [true, false], [false; 2]];
        let columns = tests().into_iter().zip(promises).enumerate().map(|(i, (test, promises))| {
            Column { name: test.name.to_owned(), promises, tallies: of_test(i) }
        });
        let gpu = self.gpu.map(|(gpu, tallies)| {
            let name = format!("{}, {} left to the CPU", gpu.name(), gpu.left_to_cpu());
            Column { name, promises: [true; 2], tallies }
        });
        columns.chain(gpu).collect()
    }
}

fn of_f64(asked: &Judge) -> Table {
    let tallies = tallies_in_f64(asked.pairs, asked.seed);
    let promises = [[true; 2], [false; 2], [false; 2]];
    let column = |(i, test): (usize, &Test<_>)| Column {
        name: test.name.to_owned(),
        promises: promises[i],
        tallies: tallies.iter().map(|tallies| tallies[i]).collect(),
    };
    let columns = IN_F64.iter().enumerate().map(column).collect();
    (InF64::ALL.map(InF64::name).into(), columns)
}

fn of_suite(asked: &Judge) -> Result<Table> {
    let suite = recorded::suite(asked.seed, None)?;
    let names: Vec<_> = suite.sets().iter().map(|set| set.name().to_owned()).collect();
    let sets: Vec<_> = names.iter().cloned().zip(suite.shares(asked.pairs)).collect();
    let mut file = match &asked.out {
        None => None,
        Some(path) => Some(Writer::new(Draft::new(path)?, asked.seed, &sets)?),
    };
    let mut ours = Ours::new(names.len(), asked.pairs, asked.gpu)?;
    for blocks in suite.waves(asked.pairs) {
        if let Some(file) = &mut file {
            blocks.iter().try_for_each(|block| file.add(&block.cases))?;
        }
        ours.add(&blocks)?;
    }
    if let Some(file) = file {
        file.finish().finish()?;
    }
    Ok((names, ours.columns()))
}

fn of_file(path: &Path, on_gpu: bool) -> Result<Table> {
    let (mut reader, names) = open(path)?;
    let pairs = reader.sets().iter().map(|(_, pairs)| pairs).sum();
    let mut ours = Ours::new(names.len(), pairs, on_gpu)?;
    loop {
        let mut wave = Vec::new();
        while wave.len() < WAVE
            && let Some(block) = reader.next_block().with_context(|| path.display().to_string())?
        {
            wave.push(block);
        }
        if wave.is_empty() {
            return Ok((names, ours.columns()));
        }
        ours.add(&wave)?;
    }
}

fn of_answers(pairs: &Path, path: &Path) -> Result<Table> {
    let (mut reader, sets) = open(pairs)?;
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let count = reader.sets().iter().map(|(_, pairs)| pairs).sum();
    let given = answers(&bytes, count).with_context(|| path.display().to_string())?;
    let mut given = given.into_iter();
    let mut tallies = vec![Tally::default(); sets.len()];
    while let Some(block) = reader.next_block().with_context(|| pairs.display().to_string())? {
        tallies[block.set].add(&Tally::of(&block.cases, given.by_ref()));
    }
    let name = path.display().to_string();
    Ok((sets, vec![Column { name, promises: [false; 2], tallies }]))
}

fn open(path: &Path) -> Result<(Reader<BufReader<File>>, Vec<String>)> {
    let named = || path.display().to_string();
    let file = File::open(path).with_context(|| format!("cannot read {}", named()))?;
    let reader = Reader::new(BufReader::new(file)).with_context(named)?;
    let names = reader.sets().iter().map(|(name, _)| name.clone()).collect();
    Ok((reader, names))
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
