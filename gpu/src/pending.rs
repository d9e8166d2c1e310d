//! Asking now, and asking now to read later.

use crate::GpuError;
use crate::answer::{Answer, GpuVerb};
use crate::engine::{Entry, Run, Start, Task};
use crate::read::is_done;
use pfront_core::bvtt::TrianglePair;
use wgpu::{CommandEncoder, SubmissionIndex};

/// A query that has been recorded, and waits for its answer to be read.
#[derive(Debug)]
#[must_use = "submit the encoder, and read the answer"]
pub struct Pending<'q> {
    answer: &'q mut Answer,
    /// The question and its run; `None` where a model is empty.
    run: Option<(Task, Run)>,
}

impl<'q> Pending<'q> {
    /// Waits for everything that has been submitted to the device, and returns all pairs that meet, sorted.
    ///
    /// # Errors
    /// [`GpuError::NotSubmitted`], and those of the query.
    pub fn read(self) -> Result<&'q [TrianglePair], GpuError> {
        match self.run {
            Some((task, run)) => self.answer.finish(&task, run, GpuVerb::All)?,
            None => self.answer.clear(),
        }
        Ok(&self.answer.pairs)
    }

    /// The same, waiting only for the submission that the query was part of.
    ///
    /// # Errors
    /// As [`Pending::read`].
    pub fn read_after(
        mut self,
        submission: SubmissionIndex,
    ) -> Result<&'q [TrianglePair], GpuError> {
        if let Some((_, run)) = &mut self.run {
            run.submission = Some(submission);
        }
        self.read()
    }

    /// Whether the submission that the query was part of is done, so that reading does not wait for it.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the submission is one of another device.
    pub fn is_ready(&self, submission: &SubmissionIndex) -> Result<bool, GpuError> {
        is_done(self.answer.engine.gpu.device(), submission)
    }

    /// Records a query from its seeds.
    pub(crate) fn record(
        answer: &'q mut Answer,
        encoder: &mut CommandEncoder,
        task: Option<Task>,
    ) -> Result<Self, GpuError> {
        let Some(task) = task else { return Ok(Self { answer, run: None }) };
        let gpu = answer.engine.gpu.clone();
        let run = gpu.checked(|| answer.record(encoder, &task, Start::Seeds, GpuVerb::All))?;
        Ok(Self { answer, run: Some((task, run)) })
    }
}

impl Answer {
    /// Asks, waits and answers; `None` asks nothing.
    pub(crate) fn ask(&mut self, task: Option<Task>, verb: GpuVerb) -> Result<(), GpuError> {
        match task {
            Some(task) => {
                let run = self.run(&task, Start::Seeds, verb)?;
                self.finish(&task, run, verb)
            }
            None => {
                self.clear();
                Ok(())
            }
        }
    }

    /// Records a query from node pairs, and returns their parts with the run of the first, for
    /// [`Answer::finish_parts`].
    pub(crate) fn record_from(
        &mut self,
        encoder: &mut CommandEncoder,
        task: &Task,
        front: &[Entry],
        verb: GpuVerb,
    ) -> Result<(Vec<Vec<Entry>>, Run), GpuError> {
        let most = self.engine.lists.capacities.front as usize;
        let parts: Vec<_> = front.chunks(most).rev().map(<[Entry]>::to_vec).collect();
        let start = Start::Front(parts.last().map_or(&[], Vec::as_slice));
        let run = self.record(encoder, task, start, verb)?;
        Ok((parts, run))
    }
}
