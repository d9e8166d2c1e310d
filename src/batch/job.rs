//! Questions that are submitted together.

use crate::executor::Verb;
use crate::subject::Subject;
use crate::{Distance, Model};
use std::sync::Arc;

/// Questions and what is asked about them.
#[derive(Clone, Default)]
pub(super) struct Job {
    pub(super) questions: Arc<Vec<Subject<Arc<Model>>>>,
    pub(super) verb: Verb,
    /// Asked in place of the verb, of CPUs only.
    pub(super) nearest: Option<Nearest>,
}

/// The smallest distance is asked for, if it is not greater than this.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub(super) at_most: Option<Distance>,
}
