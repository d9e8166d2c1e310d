//! Questions that are submitted together.

use crate::executor::Verb;
use crate::subject::Subject;
use crate::{Accuracy, Model};
use std::sync::Arc;

/// Questions and what is asked about them.
#[derive(Clone, Default)]
pub(super) struct Job {
    pub(super) questions: Arc<Vec<Subject<Arc<Model>>>>,
    pub(super) accuracy: Accuracy,
    pub(super) verb: Verb,
}
