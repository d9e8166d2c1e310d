//! Commands that are recorded ahead: for the next question, while the device works on this one.
//!
//! The commands of a run do not depend on a pose, which is copied from a staging buffer with all other parameters. So those of
//! the next question about the same models are known before it is asked: they are recorded where the host would only wait,
//! and wait for their parameters.

use crate::GpuError;
use crate::answer::GpuVerb;
use crate::engine::Engine;
use crate::layout::Query;
use crate::results::Run;
use crate::task::{Start, Task};
use wgpu::{Buffer, CommandBuffer, WriteOnly};

/// What the commands of a run from the seeds depend on, but for the copies for the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Subject {
    bound: [u64; 2],
    levels: u32,
    seeds: [u32; 2],
    shadows: u32,
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

impl Engine {
    /// Records a run from the seeds for a question that may come, while the host would only wait.
    pub(crate) fn record_ahead(
        &mut self,
        task: &Task,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        // Times are those of the last run that was recorded.
        if self.ahead.is_some() || self.clock.is_some() {
            return Ok(());
        }
        let bytes = self.parameters(task, Start::Seeds, verb).len() as u64;
        let source = self.staging.take(&self.gpu, bytes)?;
        let mut encoder = self.encoder();
        let run = self.record_commands(&mut encoder, &source, task, Start::Seeds, copies, verb)?;
        let (subject, commands) = (self.subject(task, verb), encoder.finish());
        self.ahead = Some(Ahead { subject, commands, source, run });
        Ok(())
    }

    /// The commands that were recorded ahead, if they answer this question and copy so much at least, with its parameters.
    pub(crate) fn take_ahead(
        &mut self,
        task: &Task,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<Option<(CommandBuffer, Run)>, GpuError> {
        let subject = self.subject(task, verb);
        // A buffer that the host still maps is no place for copies.
        let Some(Ahead { subject: own, commands, source, mut run }) =
            self.ahead.take().filter(|_| self.mapping.is_none())
        else {
            return Ok(None);
        };
        if own != subject || !run.copies_at_least(copies) {
            return Ok(None);
        }
        let parameters = self.parameters(task, Start::Seeds, verb);
        let fill = |mut view: WriteOnly<'_, [u8]>| view.copy_from_slice(&parameters);
        self.staging.write_into(&self.gpu, source, parameters.len() as u64, fill)?;
        run.ticket = self.ticket;
        Ok(Some((commands, run)))
    }

    fn subject(&self, task: &Task, verb: GpuVerb) -> Subject {
        let Query { seeds, shadows, .. } = task.query;
        Subject { bound: self.bound(), levels: task.levels_below_seeds, seeds, shadows, verb }
    }
}
