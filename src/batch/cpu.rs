//! Consecutive questions of a batch on one thread, in slices.

use super::found::Found;
use super::job::Job;
use crate::executor::{Answer, SLICE, Verb, step};
use crate::memory::push;
use crate::{Error, TrianglePair};
use pfront_core::bvtt::{Cursor, Query};
use std::ops::Range;

/// To begin a question costs as much as so many tests.
const BEGIN: u64 = 16;

/// Consecutive questions, answered in slices on the thread that calls.
pub(super) struct Steps {
    job: Job,
    left: Range<usize>,
    /// The progress of the first question that is left, if it has been begun.
    begun: Option<(Cursor, Answer<TrianglePair>)>,
    pub(super) found: Found,
}

impl Steps {
    /// All questions.
    pub(super) fn new(job: Job) -> Self {
        let all = 0..job.questions.len();
        Self::part(job, all)
    }

    /// Some of them.
    pub(super) fn part(job: Job, left: Range<usize>) -> Self {
        Self { job, left, begun: None, found: Found::default() }
    }

    /// Goes on for about [`SLICE`] tests. Returns whether nothing is left.
    pub(super) fn step(&mut self) -> Result<bool, Error> {
        let Self { job: Job { questions, verb }, left, begun, found } = self;
        let mut budget = SLICE;
        while budget > 0 && !Range::is_empty(left) {
            let tree = questions[left.start].tree()?;
            let (cursor, answer) = begun.get_or_insert_with(|| (tree.start(), Answer::counted(0)));
            let before = cursor.work.tests();
            if !step(((), &tree), cursor, budget, *verb, answer, &mut found.pairs)? {
                break;
            }
            budget = budget.saturating_sub(cursor.work.tests() - before + BEGIN);
            let listed = if *verb == Verb::All { answer.count as usize } else { 0 };
            let first = found.pairs.len() - listed;
            found.pairs[first..].sort_unstable();
            push(&mut found.answers, *answer)?;
            *begun = None;
            left.start += 1;
        }
        Ok(Range::is_empty(left))
    }
}
