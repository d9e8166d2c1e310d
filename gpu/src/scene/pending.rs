//! Asking now to read later.

use super::{Question, SceneHit, SceneQuery};
use crate::Error;
use crate::answer::Want;
use crate::read::is_done;
use wgpu::SubmissionIndex;

/// A frame that has been recorded, and waits for its answer to be read.
#[derive(Debug)]
#[must_use = "submit the encoder, and read the answer"]
pub struct PendingScene<'q> {
    pub(super) scene: &'q mut SceneQuery,
    /// `None` if there is nothing to ask.
    pub(super) question: Option<Question>,
}

impl<'q> PendingScene<'q> {
    /// Waits for everything that has been submitted to the device, and returns all pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::NotSubmitted`], and those of [`SceneQuery::all`].
    pub fn read(self) -> Result<&'q [SceneHit], Error> {
        self.scene.finish(self.question, Want::All)?;
        Ok(&self.scene.hits)
    }

    /// The same, waiting only for the submission that the frame was part of.
    ///
    /// # Errors
    /// As [`PendingScene::read`].
    pub fn read_after(mut self, submission: SubmissionIndex) -> Result<&'q [SceneHit], Error> {
        if let Some(question) = &mut self.question {
            question.run.submission = Some(submission);
        }
        self.read()
    }

    /// Whether the submission that the frame was part of is done, so that reading does not wait for it.
    ///
    /// # Errors
    /// [`Error::Device`] if the submission is one of another device.
    pub fn is_ready(&self, submission: &SubmissionIndex) -> Result<bool, Error> {
        is_done(self.scene.answer.engine.gpu.device(), submission)
    }
}
