//! `pfront replay FILE`

use super::{milliseconds, progress};
use crate::args::{Mode, Replay};
use crate::play::{objects, update};
use crate::recording::Recording;
use anyhow::{Context, Result, ensure};
use pfront::TrianglePair;
use pfront_cli::memory;
use pfront_cli::output::{Draft, out};
use pfront_lab::engine::{Asked, Tally};
use pfront_lab::pairs::PairWriter;
use std::io::Write;
use std::time::Instant;

pub(crate) fn run(replay: &Replay) -> Result<bool> {
    ensure!(
        replay.mode == Mode::All || replay.pairs.is_none(),
        "--pairs needs --mode all, since any stops at the first pair"
    );
    let mut recording = Recording::open(&replay.file, replay.size, replay.frames)?;
    let header = recording.take_header()?;
    let frames = header.frames;
    let asked = Asked { accuracy: replay.executor.accuracy(), ..replay.executor.open()?.into() };
    let clock = Instant::now();
    let objects = objects(header).with_context(|| replay.file.clone())?;
    let mut engine = objects.engine(asked).with_context(|| replay.file.clone())?;
    let build = milliseconds(clock.elapsed());

    let mut pairs = match &replay.pairs {
        Some(path) => Some(PairWriter::new(Draft::new(path)?, frames)?),
        None => None,
    };
    let mut out = out();
    writeln!(out, "BUILD\t{build:.3}")?;
    let bar = progress(frames.into());
    let mut tally = Tally::default();
    for number in 0.. {
        let frame = recording.next_frame().with_context(|| replay.file.clone())?;
        let Some(frame) = frame else { break };
        let clock = Instant::now();
        update(&mut *engine, frame).with_context(|| format!("frame {number}"))?;
        let updated = clock.elapsed();
        let found = match replay.mode {
            Mode::All => engine.all()?,
            Mode::Any => &[TrianglePair::default()][..usize::from(engine.any()?.is_some())],
        };
        let took = clock.elapsed();
        let [update, query] = [updated, took - updated].map(milliseconds);
        writeln!(out, "FRAME\t{number}\t{update:.3}\t{query:.3}\t{}", found.len())?;
        if let Some(pairs) = &mut pairs {
            pairs.frame(found).context("cannot write the pairs")?;
        }
        if let Some(plan) = engine.plan() {
            tally.add(plan);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(pairs) = pairs {
        pairs.finish().finish()?;
    }
    if replay.executor.is_auto() {
        eprintln!("{tally}");
    }
    writeln!(out, "RSS\t{}", memory::peak())?;
    Ok(true)
}
