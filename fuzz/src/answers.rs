//! The answers of one backend to one question, through all verbs, checked.

use crate::input::Ask;
use pfront::pfront_core::bvtt::Query;
use pfront::{Contact, TrianglePair};
use std::fmt::Debug;
use std::ops::ControlFlow;

/// The answers to all verbs of a query.
#[derive(Debug, PartialEq)]
pub(crate) struct Answers<H> {
    /// All hits.
    pub all: Vec<H>,
    /// How many.
    pub count: u64,
    /// Some hit.
    pub any: Option<H>,
    /// The first few that a visitor saw, who then broke off.
    pub visited: Vec<H>,
    /// Hits with where they are.
    pub contacts: Vec<(H, Contact)>,
}

impl<H: Copy + Ord + Debug> Answers<H> {
    /// # Panics
    /// If the verbs contradict each other or the truth, which is sorted.
    pub fn check(&self, truth: &[H], ask: Ask) {
        let Self { all, count, any, visited, contacts } = self;
        assert!(all.is_sorted_by(|x, y| x < y), "not sorted, or twice: {all:?}");
        assert_eq!(all, truth);
        assert_eq!(*count, all.len() as u64);
        assert_eq!(any.is_some(), !all.is_empty());
        assert_eq!(visited.len(), all.len().min(ask.stop()));
        let mut seen: Vec<_> = visited.iter().chain(any).collect();
        assert!(seen.iter().all(|hit| all.binary_search(hit).is_ok()), "{seen:?} of {all:?}");
        seen = visited.iter().collect();
        seen.sort_unstable();
        assert!(seen.is_sorted_by(|x, y| x < y), "visited twice: {visited:?}");

        let at: Vec<H> = contacts.iter().map(|(hit, _)| *hit).collect();
        assert_eq!(at, truth);
        for (_, Contact { segment, normals, .. }) in contacts {
            assert!(segment.iter().chain(normals).flatten().all(|x| x.is_finite()), "{contacts:?}");
        }
    }

    /// # Panics
    /// If another backend said something else where both have to say the same.
    pub fn same(&self, other: &Self) {
        assert_eq!(self.all, other.all);
        assert_eq!(self.contacts, other.contacts);
    }
}

/// Keeps the first few hits, and then breaks.
pub(crate) fn first_few<H>(few: &mut Vec<H>, ask: Ask) -> impl FnMut(H) -> ControlFlow<()> {
    move |hit| {
        few.push(hit);
        if few.len() == ask.stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// The answers of a query of the core, in pages; a visit goes on where it broke off.
pub(crate) fn of_core(query: &impl Query, ask: Ask) -> Answers<TrianglePair> {
    let all = pages(query, ask.page());
    let (mut cursor, mut visited) = (query.start(), Vec::new());
    let end = query.visit(&mut cursor, first_few(&mut visited, ask));
    assert_eq!(end.is_break(), all.len() >= ask.stop());
    let mut rest = visited.clone();
    let end = query.visit(&mut cursor, |pair| {
        rest.push(pair);
        ControlFlow::Continue(())
    });
    rest.sort_unstable();
    assert!(end.is_continue() && cursor.is_done() && rest == all, "{rest:?} but {all:?}");
    let contacts = all.iter().filter_map(|&pair| Some((pair, query.contact(pair)?))).collect();
    Answers { all, count: query.count(), any: query.any(), visited, contacts }
}

/// All pairs, sorted, through pages of some capacity.
pub fn pages(query: &impl Query, capacity: usize) -> Vec<TrianglePair> {
    let mut page = vec![TrianglePair::default(); capacity];
    let (mut cursor, mut all) = (query.start(), Vec::new());
    while !cursor.is_done() {
        let n = query.page(&mut cursor, &mut page);
        all.extend_from_slice(&page[..n]);
    }
    all.sort_unstable();
    all
}

/// The answer of the oracle, in our type.
#[must_use]
pub fn as_pairs(truth: &[(u32, u32)]) -> Vec<TrianglePair> {
    truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect()
}
