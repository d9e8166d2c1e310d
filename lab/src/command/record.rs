//! `pfront record SCENE FILE`

use super::progress;
use crate::args::Record;
use anyhow::{Context, Result};
use pfront_cli::output::{Draft, out};
use pfront_lab::recording::Recording;
use pfront_lab::workload::WorkloadWriter;
use std::io::Write;

pub(crate) fn run(record: &Record) -> Result<bool> {
    let (header, mut recording) = Recording::open(&record.scene, record.size, record.frames)?;
    let writing = || format!("cannot write {}", record.file.display());
    let mut to = WorkloadWriter::new(Draft::new(&record.file)?, &header).with_context(writing)?;
    let bar = progress(header.frames.into());
    while let Some(frame) = recording.next_frame()? {
        to.frame(frame).with_context(writing)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    to.finish().finish()?;
    let (name, file, frames) = (&record.scene, record.file.display(), header.frames);
    writeln!(out(), "{name}: {frames} frames, {} objects; see {file}", header.objects.len())?;
    Ok(true)
}
