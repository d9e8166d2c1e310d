//! One model with itself.

use crate::environment::with_default;
use crate::executor::{History, Plan};
use crate::subject::{Subject, itself};
use crate::subject_query::SubjectQuery;
use crate::{Adjacency, Contact, Distance, Error, Executor, Model, Scalar, TrianglePair};
use std::ops::ControlFlow;

/// Asks which triangles of one model meet each other; each unordered pair is reported once, with
/// `a < b`.
///
/// Make one for each model that is asked about every frame: it keeps, and takes, what [`crate::PairQuery`] does. Two
/// triangles have no contact in a vertex or an edge that they share by index.
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
/// assert_eq!(SelfQuery::new().all(&model)?, [TrianglePair { a: 0, b: 2 }]);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SelfQuery {
    adjacency: Adjacency,
    within: Distance,
    query: SubjectQuery,
}

impl SelfQuery {
    /// A query under the shared-index rule, with empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with another rule for triangles that share a vertex.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Adjacency, Model, SelfQuery};
    /// // Two triangles with a common corner, which cross beyond it.
    /// let points = vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [2.0, 2.0, -1.0], [1.0, 1.0, 1.0]];
    /// let model = Model::new(points, vec![[0, 1, 2], [0, 3, 4]])?;
    /// assert_eq!(SelfQuery::new().count(&model)?, 1);
    /// assert_eq!(SelfQuery::new().with_adjacency(Adjacency::SkipNeighbours).count(&model)?, 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        Self { adjacency, ..self }
    }

    /// The same by an executor; see [`crate::PairQuery::on`].
    #[must_use]
    pub fn on(self, executor: &Executor) -> Self {
        Self { query: self.query.on(executor), ..self }
    }

    /// Asks for pairs at most `distance` apart in place of those that intersect, exactly: touching counts at the distance, too, and
    /// at 0 the pairs are those that intersect. CPUs answer, whatever the executor. Contacts are those of the pairs that
    /// intersect.
    ///
    /// Triangles that share a vertex are decided by the rule for neighbours, whatever the distance; all others by their
    /// distance, so that neighbours of neighbours are hits from an edge's length on.
    ///
    /// # Errors
    /// [`Error::Distance`] if the distance is NaN, infinite or negative.
    ///
    /// # Complexity
    /// As without, for boxes that are grown by the distance, and the pairs that are then near.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, SelfQuery};
    /// // Two sheets with a gap of 0.02.
    /// let sheet = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    /// let positions = [sheet(0.0), sheet(0.02)].concat();
    /// let model = Model::new(positions, vec![[0, 1, 2], [3, 4, 5]])?;
    /// assert_eq!(SelfQuery::new().count(&model)?, 0);
    /// assert_eq!(SelfQuery::new().within(0.02)?.count(&model)?, 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn within(self, distance: f32) -> Result<Self, Error> {
        Ok(Self { within: Distance::new(distance)?, ..self })
    }

    /// Counts and times of the last frame on threads; see [`Report`](crate::threads::Report).
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn report(&self) -> Option<&crate::threads::Report> {
        self.query.report()
    }

    /// Forgets the last answer, so that the same question is answered anew, as a measurement wants it.
    pub fn forget(&mut self) {
        self.query.forget();
    }

    /// The backend that answered the last frame, and the reason; `None` before the first.
    #[must_use]
    pub fn plan(&self) -> Option<&Plan> {
        self.query.plan()
    }

    /// Moves the vertices of a model before it is asked about, as [`Model::set_positions`] does, on the threads of the
    /// executor; on a GPU nothing has to be refitted here.
    ///
    /// # Errors
    /// As [`Model::set_positions`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, SelfQuery};
    /// let mut cloth = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut query = SelfQuery::new();
    /// query.set_positions(&mut cloth, &[[0.0_f32; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]])?;
    /// assert_eq!(query.count(&cloth)?, 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions<S: Scalar>(
        &mut self,
        model: &mut Model,
        positions: &[[S; 3]],
    ) -> Result<(), Error> {
        self.query.set_positions(model, positions)
    }

    /// All pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::Cancelled`] by the flag of [`Executor::with_cancel`]; [`Error::Memory`]; `Error::Gpu` if a GPU fails that is to answer
    /// everything.
    pub fn all(&mut self, model: &Model) -> Result<&[TrianglePair], Error> {
        let subject = self.subject(model);
        self.query.all(&subject)
    }

    /// Some pair that meets, if any does; stops at the first.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn any(&mut self, model: &Model) -> Result<Option<TrianglePair>, Error> {
        let subject = self.subject(model);
        self.query.any(&subject)
    }

    /// How many pairs meet.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn count(&mut self, model: &Model) -> Result<u64, Error> {
        let subject = self.subject(model);
        self.query.count(&subject)
    }

    /// Calls `visit` for each pair that meets, in no particular order, until it breaks. Uses no
    /// buffer at all and only the calling thread, whatever the executor; `visit` runs in the caller's floating-point environment.
    ///
    /// # Errors
    /// [`Error::Cancelled`] by the flag of the executor; the pairs visited until then are true.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, SelfQuery};
    /// use std::ops::ControlFlow;
    /// // Two triangles that cross.
    /// let points = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [1.0, 1.0, 1.0]];
    /// let model = Model::new(points, vec![[0, 1, 2], [3, 4, 5]])?;
    /// let mut found = None;
    /// let end = SelfQuery::new().visit(&model, |pair| {
    ///     found = Some(pair);
    ///     ControlFlow::Break(())
    /// })?;
    /// assert!(end.is_break() && found.is_some_and(|pair| (pair.a, pair.b) == (0, 1)));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn visit(
        &mut self,
        model: &Model,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error> {
        let tree = with_default(|| itself(model, self.adjacency, self.within));
        self.query.visit(&tree, visit)
    }

    /// All pairs that meet, sorted, with the segment in which they do and their normals. For
    /// triangles that share a vertex or an edge the segment may include what they share.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn contacts(&mut self, model: &Model) -> Result<&[(TrianglePair, Contact)], Error> {
        let subject = self.subject(model);
        self.query.contacts(&subject)
    }

    /// [`SelfQuery::contacts`] in f64, in a list of their own.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, SelfQuery};
    /// let tile = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    /// let blade = [[0.1, 1.0, -1.0], [0.1, 1.0, 1.0], [0.1, 0.5, -1.0]];
    /// let model = Model::from_f64([tile, blade].concat(), vec![[0, 1, 2], [3, 4, 5]])?;
    /// let contacts = SelfQuery::new().contacts_f64(&model)?;
    /// assert_eq!(contacts[0].1.segment, [[0.1, 1.0, 0.0], [0.1, 0.75, 0.0]]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn contacts_f64(
        &mut self,
        model: &Model,
    ) -> Result<Vec<(TrianglePair, Contact<f64>)>, Error> {
        let subject = self.subject(model);
        self.query.contacts_f64(&subject)
    }

    pub(crate) fn adjacency(&self) -> Adjacency {
        self.adjacency
    }

    pub(crate) fn distance(&self) -> Distance {
        self.within
    }

    pub(crate) fn history(&mut self) -> &mut History<()> {
        self.query.history()
    }

    fn subject<'m>(&self, model: &'m Model) -> Subject<&'m Model> {
        Subject::Itself { models: [model], adjacency: self.adjacency, within: self.within }
    }
}
