//! `pfront-lab record NAME FILE`: built-in scenes, and motions of meshes, as workloads.

use super::progress;
use anyhow::{Context, Result};
use clap::Args;
use pfront_cli::output::{Draft, out};
use pfront_lab::recording::Recording;
use pfront_lab::workload::WorkloadWriter;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Record {
    /// A built-in scene; a mesh, of which there will be two; or several of the same triangles, with commas between
    name: String,
    /// Where to
    file: PathBuf,
    /// About so many triangles, instead of the scene's own number
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// So many frames, instead of the scene's own number, or of 64
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
}

pub(crate) fn run(record: &Record) -> Result<bool> {
    let (header, mut recording) = Recording::open(&record.name, record.size, record.frames)?;
    let writing = || format!("cannot write {}", record.file.display());
    let mut to = WorkloadWriter::new(Draft::new(&record.file)?, &header).with_context(writing)?;
    let bar = progress(header.frames.into(), "frame");
    while let Some(frame) = recording.next_frame()? {
        to.frame(frame).with_context(writing)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    to.finish().finish()?;
    let (name, file, frames) = (&record.name, record.file.display(), header.frames);
    writeln!(out(), "{name}: {frames} frames, {} objects; see {file}", header.objects.len())?;
    Ok(true)
}
