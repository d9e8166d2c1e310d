//! Questions that are submitted together.

use crate::Model;
use crate::executor::Verb;
use crate::subject::Subject;
use std::sync::Arc;

/// Questions and what is asked about them.
#[derive(Clone, Default)]
pub(super) struct Job {
    pub(super) questions: Arc<Vec<Subject<Arc<Model>>>>,
    pub(super) verb: Verb,
}
