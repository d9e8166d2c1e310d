//! `pfront judge`: whose answers to triangle pairs are right.

use crate::args;
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use pfront_cli::output::{Draft, out};
use pfront_lab::judge::{Judge, OURS, OnGpu, Tally};
use pfront_lab::recorded;
use pfront_lab::suite::{Answers, Block, Reader, Writer};
use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::Path;

/// Blocks of a file that are judged at a time.
const WAVE: usize = 128;

pub(crate) fn run(args: &args::Judge) -> Result<bool> {
    let table = match (&args.file, &args.answers) {
        (Some(file), Some(answers)) => of_answers(file, answers),
        (Some(file), None) => of_file(file, args.gpu),
        (None, _) => of_suite(args),
    }?;
    table.print(&mut out())?;
    Ok(table.columns.iter().all(Column::keeps_its_promise))
}

/// Answers to some sets.
struct Table {
    /// Name and bytes of each set.
    sets: Vec<String>,
    columns: Vec<Column>,
}

/// Somebody's answers: a tally for each set.
struct Column {
    name: String,
    promise: Promise,
    tallies: Vec<Tally>,
}

#[derive(Clone, Copy, PartialEq)]
enum Promise {
    Exact,
    NoneMissed,
    Nothing,
}

/// Ours, while they are counted.
struct Ours {
    cpu: Judge,
    gpu: Option<(OnGpu, Vec<Tally>)>,
    bar: ProgressBar,
}

impl Ours {
    fn new(sets: usize, pairs: u64, on_gpu: bool) -> Result<Self> {
        let gpu = if on_gpu { Some((OnGpu::new()?, vec![Tally::default(); sets])) } else { None };
        let bar = ProgressBar::new(pairs);
        let style = "{bar:40} {human_pos} of {human_len} pairs, {eta} left";
        bar.set_style(ProgressStyle::with_template(style)?);
        Ok(Self { cpu: Judge::new(&OURS, sets), gpu, bar })
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

    fn table(self, sets: Vec<String>) -> Table {
        self.bar.finish_and_clear();
        let of_test = |i: usize| self.cpu.scores().iter().map(|score| score[i]).collect();
        let promises = [Promise::Exact, Promise::Exact, Promise::NoneMissed, Promise::Nothing];
        let columns = OURS.iter().zip(promises).enumerate().map(|(i, (test, promise))| Column {
            name: test.name.to_owned(),
            promise,
            tallies: of_test(i),
        });
        let gpu = self.gpu.map(|(gpu, tallies)| {
            let name = format!("{}, {} left to the CPU", gpu.name(), gpu.left_to_cpu());
            Column { name, promise: Promise::Exact, tallies }
        });
        Table { sets, columns: columns.chain(gpu).collect() }
    }
}

fn of_suite(args: &args::Judge) -> Result<Table> {
    let suite = recorded::suite(args.seed, None)?;
    let names: Vec<_> = suite.sets().iter().map(|set| set.name().to_owned()).collect();
    let sets: Vec<_> = names.iter().cloned().zip(suite.shares(args.pairs)).collect();
    let mut file = match &args.out {
        None => None,
        Some(path) => Some(Writer::new(Draft::new(path)?, args.seed, &sets)?),
    };
    let mut ours = Ours::new(names.len(), args.pairs, args.gpu)?;
    for blocks in suite.waves(args.pairs) {
        if let Some(file) = &mut file {
            blocks.iter().try_for_each(|block| file.add(&block.cases))?;
        }
        ours.add(&blocks)?;
    }
    if let Some(file) = file {
        file.finish().finish()?;
    }
    Ok(ours.table(names))
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
            return Ok(ours.table(names));
        }
        ours.add(&wave)?;
    }
}

fn of_answers(pairs: &Path, path: &Path) -> Result<Table> {
    let (mut reader, sets) = open(pairs)?;
    let mut answers = Answers::new(BufReader::new(file(path)?));
    let mut tallies = vec![Tally::default(); sets.len()];
    while let Some(block) = reader.next_block().with_context(|| pairs.display().to_string())? {
        let given = answers.next(block.cases.len()).with_context(|| path.display().to_string())?;
        tallies[block.set].add(&Tally::of(&block.cases, given));
    }
    answers.finish().with_context(|| path.display().to_string())?;
    let name = path.display().to_string();
    Ok(Table { sets, columns: vec![Column { name, promise: Promise::Nothing, tallies }] })
}

fn open(path: &Path) -> Result<(Reader<BufReader<File>>, Vec<String>)> {
    let reader = Reader::new(BufReader::new(file(path)?));
    let reader = reader.with_context(|| path.display().to_string())?;
    let names = reader.sets().iter().map(|(name, _)| name.clone()).collect();
    Ok((reader, names))
}

fn file(path: &Path) -> Result<File> {
    File::open(path).with_context(|| format!("cannot read {}", path.display()))
}

impl Column {
    fn total(&self) -> Tally {
        let mut total = Tally::default();
        self.tallies.iter().for_each(|tally| total.add(tally));
        total
    }

    fn keeps_its_promise(&self) -> bool {
        let total = self.total();
        match self.promise {
            Promise::Exact => total.wrong() == 0,
            Promise::NoneMissed => total.missed == 0,
            Promise::Nothing => true,
        }
    }
}

impl Table {
    /// A line for each set, then one for each who answered.
    fn print(&self, out: &mut impl Write) -> io::Result<()> {
        let letters: Vec<char> = ('A'..='Z').take(self.columns.len()).collect();
        write!(out, "{:<20} {:>11} {:>11} {:>8}", "set", "pairs", "hits", "3/N")?;
        letters
            .iter()
            .try_for_each(|letter| write!(out, " {:>18}", format!("{letter}: miss/false")))?;
        writeln!(out)?;
        for (i, set) in self.sets.iter().enumerate() {
            let Tally { pairs, hits, .. } = self.columns[0].tallies[i];
            let bound = 1e-6 * self.columns[0].tallies[i].bound();
            write!(out, "{set:<20} {pairs:>11} {hits:>11} {bound:>8.1e}")?;
            for column in &self.columns {
                let Tally { missed, false_hits, .. } = column.tallies[i];
                write!(out, " {:>18}", format!("{missed}/{false_hits}"))?;
            }
            writeln!(out)?;
        }
        for (letter, column) in letters.iter().zip(&self.columns) {
            let total = column.total();
            let said = |what: &str, count: u64| match count {
                0 => format!("0 of {} {what} (< {:.1e})", total.pairs, 1e-6 * total.bound()),
                _ => format!("{count} of {} {what}", total.pairs),
            };
            let (missed, false_hits) =
                (said("missed", total.missed), said("false hits", total.false_hits));
            writeln!(out, "{letter}: {}: {missed}, {false_hits}", column.name)?;
        }
        writeln!(out, "(< 3/N): where none was seen, the rate is below that with 95 % confidence")
    }
}
