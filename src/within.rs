//! One model with itself.

use crate::answer::{Answer, OfOne, Planning, Question};
use crate::planner::{Plan, Planner};
#[cfg(feature = "threads")]
use crate::threads;
use crate::{Accuracy, Adjacency, Contact, Error, Model, TrianglePair};
use pfront_core::bvtt::Query;
use std::ops::ControlFlow;

/// Asks which triangles of one model meet each other; each unordered pair is reported once, with
/// `a < b`.
///
/// Keeps its buffers, as [`crate::PairQuery`] does. What two triangles share by index is no contact.
///
/// # Examples
/// ```
/// use pfront::{Model, SelfQuery, TrianglePair};
/// // A fold of two triangles, and a third that pierces the first.
/// let points = vec![
///     [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0],
///     [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 9.0],
/// ];
/// let model = Model::new(points, vec![[0, 1, 2], [1, 0, 3], [4, 5, 6]])?;
/// assert_eq!(SelfQuery::new().all(&model), [TrianglePair { a: 0, b: 2 }]);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SelfQuery {
    accuracy: Accuracy,
    adjacency: Adjacency,
    answer: Answer,
}

impl SelfQuery {
    /// An exact query under the shared-index rule, with empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    /// The same with another rule for triangles that share a vertex.
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        Self { adjacency, ..self }
    }

    /// The same on several threads; see [`crate::PairQuery::with_threads`].
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn with_threads(self, workers: usize) -> Self {
        self.with_traversal(threads::Traversal::new(workers))
    }

    /// [`SelfQuery::with_threads`] with a pool and settings of your own.
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn with_traversal(mut self, traversal: threads::Traversal) -> Self {
        self.answer.traversal = Some(traversal);
        self
    }

    /// What the last frame on threads did; see [`threads::Report`].
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn report(&self) -> Option<&threads::Report> {
        Some(&self.answer.traversal.as_ref()?.report)
    }

    /// The same by a [`Planner`]; see [`crate::PairQuery::with_planner`].
    #[must_use]
    pub fn with_planner(mut self, planner: Planner) -> Self {
        self.answer.planning = Some(Planning::new(planner));
        self
    }

    /// How the last frame was answered by a planner, and why so.
    #[must_use]
    pub fn plan(&self) -> Option<Plan> {
        self.answer.planning.as_ref()?.plan()
    }

    /// Moves the vertices of a model before it is asked about, as [`Model::set_positions`] does, on the threads
    /// that this query has, or so as its [`Planner`] will want it: on a GPU, for one, nothing has to be refitted
    /// here.
    ///
    /// # Errors
    /// As [`Model::set_positions`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, SelfQuery};
    /// let mut cloth = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut query = SelfQuery::new();
    /// query.set_positions(&mut cloth, &[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]])?;
    /// assert_eq!(query.count(&cloth), 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions(
        &mut self,
        model: &mut Model,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        let Self { accuracy, adjacency, answer } = self;
        if let Some(planning) = &mut answer.planning {
            return planning.set_positions(model, positions, *adjacency, *accuracy);
        }
        #[cfg(feature = "threads")]
        if let Some(traversal) = &answer.traversal {
            return traversal.install(|| model.set_positions_with_threads(positions));
        }
        model.set_positions(positions)
    }

    /// All pairs that meet, sorted.
    pub fn all(&mut self, model: &Model) -> &[TrianglePair] {
        let question = self.question(model);
        self.answer.all(&question)
    }

    /// Some pair that meets, if any does; stops at the first.
    pub fn any(&mut self, model: &Model) -> Option<TrianglePair> {
        let question = self.question(model);
        self.answer.any(&question)
    }

    /// How many pairs meet.
    pub fn count(&mut self, model: &Model) -> u64 {
        let question = self.question(model);
        self.answer.count(&question)
    }

    /// Calls `visit` for each pair that meets, in no particular order, until it breaks. Uses no
    /// buffer at all, and only the calling thread.
    pub fn visit(
        &mut self,
        model: &Model,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let question = self.question(model);
        let query = question.query(self.accuracy);
        query.visit(&mut query.start(), visit)
    }

    /// All pairs that meet, sorted, with the segment in which they do and their normals. For
    /// triangles that share a vertex or an edge the segment may include what they share.
    pub fn contacts(&mut self, model: &Model) -> &[(TrianglePair, Contact)] {
        let question = self.question(model);
        self.answer.contacts(&question)
    }

    fn question<'m>(&self, model: &'m Model) -> OfOne<'m> {
        OfOne { model, adjacency: self.adjacency, accuracy: self.accuracy }
    }
}
