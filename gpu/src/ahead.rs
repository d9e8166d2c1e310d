//! Commands that are recorded ahead: for the next question, while the device works on this one.
//!
//! The commands of a run do not depend on a pose, which is copied from a staging buffer with all other parameters. So those of
//! the next question about the same models are known before it is asked: they are recorded where the host would only wait,
//! and wait for their parameters.

use crate::GpuError;
use crate::engine::Engine;
use crate::layout::Query;
use crate::results::Run;
use crate::task::{GpuVerb, Start, Task};
use wgpu::{Buffer, CommandBuffer, WriteOnly};

/// All that the commands of a run from the seeds depend on, but for how much comes to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Subject {
    bound: [u64; 2],
    levels: u32,
    seeds: [u32; 2],
    certify: u32,
    is_direct: bool,
    verb: GpuVerb,
}

/// A run that was recorded before its parameters are known.
#[derive(Debug)]
pub(crate) struct Ahead {
    subject: Subject,
    commands: CommandBuffer,
    /// Mapped, for the parameters.
    source: Buffer,
    run: Run,
}

impl Subject {
    fn new(engine: &Engine, task: &Task, verb: GpuVerb) -> Self {
        let Query { seeds, certify, .. } = task.query;
        let (bound, is_direct) = (engine.bound(), engine.is_direct(task));
        Self { bound, levels: task.levels_below_seeds, seeds, certify, is_direct, verb }
    }
}

impl Ahead {
    /// Records a run from the seeds for a question that may come, while the host would only wait.
    pub(crate) fn record(
        engine: &mut Engine,
        task: &Task,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<Self, GpuError> {
        let bytes = engine.parameters(task, Start::Seeds, verb).len() as u64;
        let source = engine.staging.take(&engine.gpu, bytes)?;
        let mut encoder = engine.encoder();
        let run =
            engine.record_commands(&mut encoder, &source, task, Start::Seeds, copies, verb)?;
        let (subject, commands) = (Subject::new(engine, task, verb), encoder.finish());
        Ok(Self { subject, commands, source, run })
    }

    /// The commands with the parameters of a question, if they answer it and bring so much at least.
    pub(crate) fn take(
        self,
        engine: &mut Engine,
        task: &Task,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<Option<(CommandBuffer, Run)>, GpuError> {
        let Self { subject, commands, source, mut run } = self;
        engine.read_back.shown = None;
        // A buffer that the host still maps is no place for results, and these commands keep no time.
        let is_in_use = engine.read_back.is_pending() || engine.clock.is_some();
        let is_in_use = is_in_use || !engine.are_counters_clear;
        let suits = subject == Subject::new(engine, task, verb) && run.brings_at_least(copies);
        if is_in_use || !suits {
            return Ok(None);
        }
        let parameters = engine.parameters(task, Start::Seeds, verb);
        let fill = |mut view: WriteOnly<'_, [u8]>| view.copy_from_slice(&parameters);
        engine.staging.write_into(&engine.gpu, source, parameters.len() as u64, fill)?;
        run.ticket = engine.ticket;
        Ok(Some((commands, run)))
    }
}
