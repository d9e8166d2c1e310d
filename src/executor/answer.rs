//! The questions and the answers of a frame.

use crate::TrianglePair;

/// The verbs of a query.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Verb {
    #[default]
    All,
    Count,
    Any,
}

/// The answer to a frame, beside the list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer<T> {
    pub(crate) count: u64,
    pub(crate) first: Option<T>,
}

impl<T: Copy> Answer<T> {
    /// The answer to `all`: a list in order.
    pub(crate) fn listed(list: &[T]) -> Self {
        Self { count: list.len() as u64, first: list.first().copied() }
    }

    pub(crate) fn counted(count: u64) -> Self {
        Self { count, first: None }
    }

    /// This and the answer about further subjects.
    pub(crate) fn and(self, more: Self) -> Self {
        Self { count: self.count + more.count, first: self.first.or(more.first) }
    }

    /// The same with the list, if there is one.
    pub(crate) fn with(self, verb: Verb, list: &[T]) -> Self {
        if verb == Verb::All { Self::listed(list) } else { self }
    }

    /// The answer to `any`: a pair found.
    pub(crate) fn found(first: Option<T>) -> Self {
        Self { count: u64::from(first.is_some()), first }
    }
}

/// An intersecting triangle pair, as a query shows it.
pub(crate) trait Named: Copy + Ord + Send + Sync {
    /// Tells its subject from the others of a frame.
    type Name: Copy + Ord;

    fn new(name: Self::Name, pair: TrianglePair) -> Self;

    fn name(&self) -> Self::Name;

    fn pair(&self) -> TrianglePair;

    /// A list of these as one of pairs, if they are nothing else.
    #[cfg(feature = "threads")]
    fn as_pairs(_: &mut Vec<Self>) -> Option<&mut Vec<TrianglePair>> {
        None
    }
}

/// The pairs of a single subject.
impl Named for TrianglePair {
    type Name = ();

    fn new((): (), pair: TrianglePair) -> Self {
        pair
    }

    fn name(&self) {}

    fn pair(&self) -> TrianglePair {
        *self
    }

    #[cfg(feature = "threads")]
    fn as_pairs(list: &mut Vec<Self>) -> Option<&mut Vec<TrianglePair>> {
        Some(list)
    }
}
