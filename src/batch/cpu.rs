//! Consecutive questions of a batch on one thread, in slices.

use super::found::Found;
use super::job::{Job, Nearest};
use crate::executor::{Answer, SLICE, Verb, step};
use crate::memory::push;
use crate::{Error, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Cursor, Query, Search};
use std::ops::Range;

/// To begin a question costs as much as so many tests.
const BEGIN: u64 = 16;

/// Consecutive questions, answered in slices on the thread that calls.
pub(super) struct Steps {
    job: Job,
    left: Range<usize>,
    /// The progress of the first question that is left, if it has been begun.
    begun: Option<(Cursor, Answer<TrianglePair>)>,
    /// The same of a search for the smallest distance.
    search: Option<Search>,
    /// The nearest pair of the last question that had one.
    seed: Option<TrianglePair>,
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
        Self { job, left, begun: None, search: None, seed: None, found: Found::default() }
    }

    /// Goes on for about [`SLICE`] tests. Returns whether nothing is left.
    pub(super) fn step(&mut self) -> Result<bool, Error> {
        if let Some(nearest) = self.job.nearest {
            return self.step_nearest(nearest);
        }
        let Self { job: Job { questions, verb, .. }, left, begun, found, .. } = self;
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

    /// [`Steps::step`] of searches for smallest distances. The nearest pair of the question before is tried first: often it is about
    /// the same models in a pose that is not much different.
    fn step_nearest(&mut self, nearest: Nearest) -> Result<bool, Error> {
        let Self { job: Job { questions, .. }, left, search, seed, found, .. } = self;
        let mut left_over = SLICE;
        while left_over > 0 && !Range::is_empty(left) {
            let tree = questions[left.start].tree()?;
            let gap = if let AnyBvtt::Pair(tree) = &tree {
                let search = search.get_or_insert_with(|| tree.search(nearest.at_most, *seed));
                left_over = left_over.saturating_sub(tree.seek(search, left_over) + BEGIN);
                if !search.is_done() {
                    break;
                }
                search.gap()
            } else {
                // Between a model and itself there is none.
                None
            };
            *seed = gap.map(|gap| gap.pair).or(*seed);
            push(&mut found.gaps, gap)?;
            *search = None;
            left.start += 1;
        }
        Ok(Range::is_empty(left))
    }
}
