//! Answers to the questions of a batch, in their order.

use crate::executor::Answer;
use crate::{Gap, TrianglePair};
use std::ops::Index;

/// Answers to consecutive questions, to any verb.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) answers: Vec<Answer<TrianglePair>>,
    /// Under [`Verb::All`](crate::executor::Verb), the pairs of all questions.
    pub(super) pairs: Vec<TrianglePair>,
    /// The smallest distances, in place of answers.
    pub(super) gaps: Vec<Option<Gap>>,
}

impl Found {
    pub(super) fn into_first(self) -> Vec<Option<TrianglePair>> {
        self.answers.into_iter().map(|answer| answer.first).collect()
    }

    pub(super) fn into_gaps(self) -> Vec<Option<Gap>> {
        self.gaps
    }

    pub(super) fn into_counts(self) -> Vec<u64> {
        self.answers.into_iter().map(|answer| answer.count).collect()
    }
}

/// All pairs of each question of a batch: a flat list, with a slice for each question.
///
/// # Examples
/// ```
/// # use pfront::{Batch, Executor, Model, Pose, TrianglePair};
/// # use std::sync::Arc;
/// # let model = Arc::new(Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?);
/// let mut batch = Batch::new();
/// for x in [0.0, 1.0, 0.0] {
///     batch.pair(&model, &model, Pose::from_translation([x, 0.0, 0.0]))?;
/// }
/// let lists = batch.all(&Executor::sequential())?.read()?;
/// assert_eq!(lists.iter().map(<[_]>::len).collect::<Vec<_>>(), [1, 0, 1]);
/// assert_eq!((lists.len(), lists.pairs().len()), (3, 2));
/// assert_eq!(lists[2], [TrianglePair { a: 0, b: 0 }]);
/// assert_eq!(lists.get(3), None);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PairLists {
    pairs: Vec<TrianglePair>,
    /// The end of each list in `pairs`.
    ends: Vec<usize>,
}

impl PairLists {
    /// The number of lists, which is that of the questions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there was no question.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The pairs of a question, sorted; `None` if there was no such question.
    #[must_use]
    pub fn get(&self, question: usize) -> Option<&[TrianglePair]> {
        let end = *self.ends.get(question)?;
        let start = question.checked_sub(1).map_or(0, |before| self.ends[before]);
        Some(&self.pairs[start..end])
    }

    /// The pairs of one question after the other.
    #[must_use]
    pub fn pairs(&self) -> &[TrianglePair] {
        &self.pairs
    }

    /// The list of each question.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[TrianglePair]> {
        (0..self.len()).map(|question| &self[question])
    }
}

/// # Panics
/// If there was no such question.
impl Index<usize> for PairLists {
    type Output = [TrianglePair];

    fn index(&self, question: usize) -> &[TrianglePair] {
        let start = if question == 0 { 0 } else { self.ends[question - 1] };
        &self.pairs[start..self.ends[question]]
    }
}

impl From<Found> for PairLists {
    fn from(found: Found) -> Self {
        let end = |end: &mut usize, count: u64| {
            *end += count as usize;
            Some(*end)
        };
        let ends = found.answers.iter().map(|answer| answer.count).scan(0, end).collect();
        Self { pairs: found.pairs, ends }
    }
}
