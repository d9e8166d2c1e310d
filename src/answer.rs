//! What both queries keep: buffers, lent out, and who walks, which is the core or several threads.

use pfront_core::query::{Query, TrianglePair};
use pfront_core::triangle::Contact;
use std::ops::ControlFlow;

#[derive(Clone, Debug, Default)]
pub(crate) struct Answer {
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
    #[cfg(feature = "threads")]
    pub(crate) traversal: Option<pfront_cpu::Traversal>,
}

impl Answer {
    /// All pairs, sorted. Allocates only when there are more than ever before.
    pub(crate) fn all(&mut self, query: &(impl Query + Sync)) -> &[TrianglePair] {
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.traversal {
            traversal.all(query, &mut self.pairs);
            return &self.pairs;
        }
        self.pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            self.pairs.push(pair);
            ControlFlow::Continue(())
        });
        self.pairs.sort_unstable();
        &self.pairs
    }

    /// How many pairs meet.
    pub(crate) fn count(&mut self, query: &(impl Query + Sync)) -> u64 {
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.traversal {
            return traversal.count(query);
        }
        query.count()
    }

    /// Some pair that meets.
    pub(crate) fn any(&mut self, query: &(impl Query + Sync)) -> Option<TrianglePair> {
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.traversal {
            return traversal.any(query);
        }
        query.any()
    }

    /// All pairs that meet, sorted, with where. A pair that only `Conservative` or `Fast` reports
    /// meets nowhere and is left out.
    pub(crate) fn contacts(&mut self, query: &(impl Query + Sync)) -> &[(TrianglePair, Contact)] {
        self.all(query);
        self.contacts.clear();
        let found = self.pairs.iter().filter_map(|&pair| Some((pair, query.contact(pair)?)));
        self.contacts.extend(found);
        &self.contacts
    }
}
