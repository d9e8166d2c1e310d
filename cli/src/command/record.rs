//! `pfront record SCENE FILE`

use super::progress;
use crate::args::Record;
use crate::recording::Recording;
use anyhow::{Context, Result};
use pfront_cli::workload::WorkloadWriter;
use std::fs::File;
use std::io::{BufWriter, Write, stdout};

pub(crate) fn run(record: &Record) -> Result<bool> {
    let mut recording = Recording::open(&record.scene, record.size, record.frames)?;
    let header = recording.take_header()?;
    let writing = || format!("writing {}", record.file.display());
    let file = File::create(&record.file).map(BufWriter::new);
    let mut to = file.and_then(|f| WorkloadWriter::new(f, &header)).with_context(writing)?;
    let bar = progress(header.frames.into());
    while let Some(frame) = recording.next_frame()? {
        to.frame(frame).with_context(writing)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    to.finish().with_context(writing)?;
    let (name, file, frames) = (&record.scene, record.file.display(), header.frames);
    writeln!(stdout(), "{name}: {frames} frames, {} objects; see {file}", header.objects.len())?;
    Ok(true)
}
