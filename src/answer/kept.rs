//! The last answer, which is that to the next question if nothing has changed.

use super::question::Subject;
use super::ways::{Given, Want};

/// What was asked last, and what is known of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kept {
    last: Option<(Subject, Want, Given)>,
    most: u64,
}

impl Kept {
    /// The answer, if it is known; that to [`Want::All`] is the list, as it was left.
    pub(crate) fn find(&self, subject: impl FnOnce() -> Subject, want: Want) -> Option<Given> {
        let (known, answered, given) = self.last.as_ref()?;
        // From a list follows everything else.
        let tells = *answered == Want::All || *answered == want;
        (tells && *known == subject()).then_some(*given)
    }

    pub(crate) fn keep(&mut self, subject: Subject, want: Want, given: Given) {
        self.most = self.most.max(given.count);
        self.last = Some((subject, want, given));
    }

    pub(crate) fn forget(&mut self) {
        self.last = None;
    }

    /// The most pairs that an answer had.
    pub(crate) fn most(&self) -> u64 {
        self.most
    }
}
