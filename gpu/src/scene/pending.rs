//! Asking now to read later.

use super::{Question, SceneHit, SceneQuery};
use crate::Error;
use crate::answer::Want;

/// A frame that has been recorded, and waits for its answer to be read.
#[derive(Debug)]
#[must_use = "submit the encoder, and read the answer"]
pub struct PendingScene<'q> {
    pub(super) scene: &'q mut SceneQuery,
    /// `None` if there is nothing to ask.
    pub(super) question: Option<Question>,
}

impl<'q> PendingScene<'q> {
    /// Waits for the device, and returns all pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::NotSubmitted`], and those of [`SceneQuery::all`].
    pub fn read(self) -> Result<&'q [SceneHit], Error> {
        self.scene.finish(self.question, Want::All)?;
        Ok(&self.scene.hits)
    }
}
