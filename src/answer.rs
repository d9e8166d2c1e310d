//! The buffers behind both queries: filled by the walk of the core, sorted, lent out.

use pfront_core::query::{Query, TrianglePair};
use pfront_core::triangle::Contact;
use std::ops::ControlFlow;

#[derive(Clone, Debug, Default)]
pub(crate) struct Answer {
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
}

impl Answer {
    /// All pairs, sorted. Allocates only when there are more than ever before.
    pub(crate) fn all(&mut self, query: &impl Query) -> &[TrianglePair] {
        self.pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            self.pairs.push(pair);
            ControlFlow::Continue(())
        });
        self.pairs.sort_unstable();
        &self.pairs
    }

    /// All pairs that meet, sorted, with where. A pair that only `Conservative` or `Fast` reports
    /// meets nowhere and is left out.
    pub(crate) fn contacts(&mut self, query: &impl Query) -> &[(TrianglePair, Contact)] {
        self.all(query);
        self.contacts.clear();
        let found = self.pairs.iter().filter_map(|&pair| Some((pair, query.contact(pair)?)));
        self.contacts.extend(found);
        &self.contacts
    }
}
