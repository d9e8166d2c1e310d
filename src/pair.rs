//! Two models.

use crate::answer::{Answer, OfTwo, Planning, Question};
use crate::planner::{Plan, Planner};
#[cfg(feature = "threads")]
use crate::threads;
use crate::{Accuracy, Contact, Error, Model, Pose, TrianglePair};
use pfront_core::bvtt::Query;
use std::ops::ControlFlow;

/// Asks which triangles of two models meet, the second in the pose `a_from_b`.
///
/// Keeps its buffers: make one and use it every frame, for any models. A frame that finds no more
/// pairs than an earlier one allocates nothing.
///
/// # Examples
/// ```
/// use pfront::{Model, PairQuery, Pose, TrianglePair};
/// let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
/// let b = Model::new(vec![[0.0; 3], [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]], vec![[0, 1, 2]])?;
/// let mut query = PairQuery::new();
/// assert_eq!(query.all(&a, &b, &Pose::IDENTITY)?, [TrianglePair { a: 0, b: 0 }]);
/// assert_eq!(query.count(&a, &b, &Pose::from_translation([0.0, 0.0, 1e-45]))?, 0);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct PairQuery {
    accuracy: Accuracy,
    answer: Answer,
}

impl PairQuery {
    /// An exact query with empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self }
    }

    /// The same on several threads: each frame is divided into `workers` parts, which run in the rayon
    /// pool of whoever asks. The answers stay the same to the bit, whatever the number; one beyond what
    /// [`threads::Traversal::new`] takes is lowered to that.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose};
    /// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut query = PairQuery::new().with_threads(8);
    /// assert_eq!(query.all(&a, &a, &Pose::IDENTITY)?.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn with_threads(self, workers: usize) -> Self {
        self.with_traversal(threads::Traversal::new(workers))
    }

    /// [`PairQuery::with_threads`] with a pool and settings of your own.
    ///
    /// # Examples
    /// ```
    /// use pfront::threads::{Schedule, Settings, Traversal};
    /// let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
    /// let query = pfront::PairQuery::new().with_traversal(Traversal::new(8).with_settings(settings));
    /// ```
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

    /// The same by a [`Planner`]: the query decides for itself, from frame to frame, who answers. The answers
    /// stay the same to the bit.
    ///
    /// # Examples
    /// ```
    /// use pfront::{PairQuery, planner::{Machine, Planner}};
    /// let query = PairQuery::new().with_planner(Planner::new(Machine::typical()));
    /// ```
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

    /// All pairs that meet, sorted; `a` and `b` of a pair are triangles of `a` and `b`.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose is not finite or takes `b` out of range.
    pub fn all(&mut self, a: &Model, b: &Model, a_from_b: &Pose) -> Result<&[TrianglePair], Error> {
        let question = self.question(a, b, a_from_b)?;
        Ok(self.answer.all(&question))
    }

    /// Some pair that meets, if any does; stops at the first.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    pub fn any(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: &Pose,
    ) -> Result<Option<TrianglePair>, Error> {
        let question = self.question(a, b, a_from_b)?;
        Ok(self.answer.any(&question))
    }

    /// How many pairs meet.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    pub fn count(&mut self, a: &Model, b: &Model, a_from_b: &Pose) -> Result<u64, Error> {
        let question = self.question(a, b, a_from_b)?;
        Ok(self.answer.count(&question))
    }

    /// Calls `visit` for each pair that meets, in no particular order, until it breaks. Uses no
    /// buffer at all, and only the calling thread.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    ///
    /// # Examples
    /// ```
    /// use std::ops::ControlFlow;
    /// # use pfront::{Model, PairQuery, Pose};
    /// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut left = 10;
    /// let end = PairQuery::new().visit(&a, &a, &Pose::IDENTITY, |pair| {
    ///     left -= 1;
    ///     if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    /// })?;
    /// assert!(end.is_continue());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn visit(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: &Pose,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error> {
        let question = self.question(a, b, a_from_b)?;
        let query = question.query(self.accuracy);
        Ok(query.visit(&mut query.start(), visit))
    }

    /// All pairs that meet, sorted, with the segment in which they do and their normals, in the
    /// frame of `a`.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    pub fn contacts(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: &Pose,
    ) -> Result<&[(TrianglePair, Contact)], Error> {
        let question = self.question(a, b, a_from_b)?;
        Ok(self.answer.contacts(&question))
    }

    fn question<'m>(
        &self,
        a: &'m Model,
        b: &'m Model,
        a_from_b: &Pose,
    ) -> Result<OfTwo<'m>, Error> {
        OfTwo::new([a, b], a_from_b, self.accuracy)
    }
}
