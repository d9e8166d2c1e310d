//! Two models.

use crate::environment::with_default;
use crate::executor::Plan;
use crate::subject::Subject;
use crate::subject_query::SubjectQuery;
use crate::{
    AnyPose, Contact, ContactPatch, Distance, Error, Executor, Gap, Model, Pose64, TrianglePair,
};
use std::ops::ControlFlow;

/// Asks which triangles of two models meet, the second in the pose `a_from_b`.
///
/// Make one for each two models that are asked about every frame: it keeps its buffers, what its executor learned of
/// earlier frames, and the last answer, which is that to the next question if neither the models nor the pose have
/// changed. Other models may be asked about: costs of earlier frames then tell nothing any more. A frame that finds no more pairs than an
/// earlier one allocates nothing on one thread.
///
/// # Complexity
/// A frame takes O(n + k) for n pairs of boxes that overlap, in the order of the triangles near the intersection, and k hits, and
/// O(k log k) to sort them; in the worst case, the product of the triangles of both. Lists are kept: 8 bytes a pair and, once contacts are asked
/// for, 60 a contact, as many as the fullest frame had; a copy of the pairs while threads merge theirs, and of the front what
/// `threads::Settings::max_nodes` allows. Impacts are 24 bytes each and the caller's.
///
/// # Examples
/// ```
/// use pfront::{Model, PairQuery, Pose, TrianglePair};
/// let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
/// let b = Model::new(vec![[0.0; 3], [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]], vec![[0, 1, 2]])?;
/// let mut query = PairQuery::new();
/// assert_eq!(query.all(&a, &b, Pose::IDENTITY)?, [TrianglePair { a: 0, b: 0 }]);
/// assert_eq!(query.count(&a, &b, Pose::from_translation([0.0, 0.0, 1e-45]))?, 0);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct PairQuery {
    pub(crate) within: Distance,
    pub(crate) query: SubjectQuery,
}

impl PairQuery {
    /// A query with empty buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same by an executor; a new query is sequential. Lists and counts stay the same to the bit, and what was remembered
    /// of earlier frames is forgotten.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Executor, Model, PairQuery, Pose};
    /// # let a = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut query = PairQuery::new().on(&Executor::auto());
    /// assert_eq!(query.all(&a, &a, Pose::IDENTITY)?.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[must_use]
    pub fn on(self, executor: &Executor) -> Self {
        Self { query: self.query.on(executor), ..self }
    }

    /// Asks for pairs at most `distance` apart in place of those that intersect, exactly: touching counts at the distance, too, and
    /// at 0 the pairs are those that intersect. The distance is in the units and the frame of `a`. A GPU certifies most of them, and leaves to the CPU what f32 does not tell; distances
    /// above a quarter of the range of f32 only a CPU answers. Contacts are those of the pairs that intersect.
    ///
    /// # Errors
    /// [`Error::Distance`] if the distance is NaN, infinite or negative.
    ///
    /// # Complexity
    /// As without, for boxes that are grown by the distance, and the pairs that are then near.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose};
    /// let triangle = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let above = Pose::from_translation([0.0, 0.0, 0.02]);
    /// assert_eq!(PairQuery::new().count(&triangle, &triangle, above)?, 0);
    /// assert_eq!(PairQuery::new().within(0.02)?.count(&triangle, &triangle, above)?, 1);
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

    /// All pairs that meet, sorted; `a` and `b` of a pair are triangles of `a` and `b`.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose is not finite or takes `b` out of range; [`Error::Cancelled`] by the flag of
    /// [`Executor::with_cancel`]; [`Error::Memory`]; `Error::Gpu` if a GPU fails that is to answer everything.
    pub fn all(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<&[TrianglePair], Error> {
        let subject = self.subject(a, b, a_from_b)?;
        self.query.all(&subject)
    }

    /// Some pair that meets, if any does; stops at the first.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    pub fn any(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<Option<TrianglePair>, Error> {
        let subject = self.subject(a, b, a_from_b)?;
        self.query.any(&subject)
    }

    /// How many pairs meet.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    pub fn count(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<u64, Error> {
        let subject = self.subject(a, b, a_from_b)?;
        self.query.count(&subject)
    }

    /// Calls `visit` for each pair that meets, in no particular order, until it breaks. Uses no
    /// buffer at all and only the calling thread, whatever the executor; `visit` runs in the caller's floating-point environment.
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
    /// let end = PairQuery::new().visit(&a, &a, Pose::IDENTITY, |pair| {
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
        a_from_b: impl Into<AnyPose>,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error> {
        let subject = self.subject(a, b, a_from_b)?;
        let tree = with_default(|| subject.tree())?;
        self.query.visit(&tree, visit)
    }

    /// All pairs that meet, sorted, with the segment in which they do and their normals, in the
    /// frame of `a`; rounded to f32, also of what is in f64.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    pub fn contacts(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<&[(TrianglePair, Contact)], Error> {
        let subject = self.subject(a, b, a_from_b)?;
        self.query.contacts(&subject)
    }

    /// [`PairQuery::contacts`] in f64, in a list of their own.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose64};
    /// // A blade that stands in a floor, a nanometre from its corner.
    /// let floor = Model::from_f64(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let blade = Model::from_f64(vec![[0.0, 1.0, -1.0], [0.0, 1.0, 1.0], [0.0, 0.5, -1.0]], vec![[0, 1, 2]])?;
    /// let contacts = PairQuery::new().contacts_f64(&floor, &blade, Pose64::from_translation([1e-9, 0.0, 0.0]))?;
    /// assert_eq!(contacts[0].1.segment, [[1e-9, 1.0, 0.0], [1e-9, 0.75, 0.0]]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn contacts_f64(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<Vec<(TrianglePair, Contact<f64>)>, Error> {
        let subject = self.subject(a, b, a_from_b)?;
        self.query.contacts_f64(&subject)
    }

    /// All that two surfaces have in common, the second in the pose `a_from_b`, in connected patches, in the order of their lowest pairs.
    /// Exact signs tell which triangles belong together, dimensions, and whether a patch is closed. Lengths and areas are intervals that
    /// hold the true values for the positions as they are posed, in the frame and the units of `a`. Each point is within 2^-42 of the length of
    /// the edge that it lies on and 2^-50 of its coordinates, and intervals are as wide as that and the roundings of sums make them.
    ///
    /// Equal positions are one vertex. Where a mesh meets itself, what it covers twice counts twice, and what is joined only there counts as
    /// two patches; lines along triangles without area count from nothing to in full.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    ///
    /// # Complexity
    /// As [`PairQuery::all`], some microseconds a pair, which several threads divide, and O(n log n) for n pairs. Takes some 400 bytes a
    /// pair, and 1,300 one of flush triangles.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose};
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let model = Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// // Their surfaces cross in one curve that comes back to where it began.
    /// let patches = PairQuery::new().patches(&model, &model, Pose::from_translation([0.25, 0.125, 0.0625]))?;
    /// assert!(patches.len() == 1 && patches[0].dimension == 1 && patches[0].is_closed);
    /// // And they touch in a corner.
    /// let patches = PairQuery::new().patches(&model, &model, Pose::from_translation([1.0, 0.0, 0.0]))?;
    /// assert!(patches.len() == 1 && patches[0].dimension == 0 && patches[0].points == [[1.0, 0.0, 0.0]]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn patches(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<Vec<ContactPatch>, Error> {
        self.patches_in([a, b], a_from_b.into(), &Pose64::IDENTITY)
    }

    /// The same measured in a world, in which the first model is posed.
    pub(crate) fn patches_in(
        &mut self,
        models: [&Model; 2],
        pose: AnyPose,
        world_from_a: &Pose64,
    ) -> Result<Vec<ContactPatch>, Error> {
        with_default(|| {
            let subject = Subject::pair(models, pose, Distance::default())?;
            self.query.patches(&subject, world_from_a)
        })
    }

    /// The smallest distance of the two models in the frame of `a`, and where it is; 0 if they intersect, whatever
    /// [`PairQuery::within`] says. `None` if a model has no triangles. CPUs answer, whatever the executor; the same to the bit, but for
    /// which of the intersecting pairs is named.
    ///
    /// The pair that was nearest in the last frame is tried first.
    ///
    /// # Errors
    /// As [`PairQuery::all`].
    ///
    /// # Complexity
    /// Time grows with the number of triangles that are about equally near.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose};
    /// let a = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut query = PairQuery::new();
    /// let gap = query.distance(&a, &a, Pose::from_translation([0.0, 0.0, 0.1]))?.expect("both have triangles");
    /// let [low, high] = gap.interval;
    /// assert!(low <= f64::from(0.1_f32) && f64::from(0.1_f32) <= high && high - low < 1e-7);
    /// let [on_a, on_b] = gap.points;
    /// assert_eq!(on_b[2] - on_a[2], f64::from(0.1_f32));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn distance(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<Option<Gap>, Error> {
        self.nearest(a, b, a_from_b.into(), None)
    }

    /// [`PairQuery::distance`], if it is at most `limit`: exactly, and sooner, as all that is farther is left out.
    ///
    /// # Errors
    /// As [`PairQuery::all`]; [`Error::Distance`] if the limit is NaN, infinite or negative.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose};
    /// # let a = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let (mut query, above) = (PairQuery::new(), Pose::from_translation([0.0, 0.0, 0.1]));
    /// assert!(query.distance_below(&a, &a, above, 0.1)?.is_some());
    /// assert!(query.distance_below(&a, &a, above, 0.1_f32.next_down())?.is_none());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn distance_below(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: impl Into<AnyPose>,
        limit: f32,
    ) -> Result<Option<Gap>, Error> {
        self.nearest(a, b, a_from_b.into(), Some(Distance::new(limit)?))
    }

    fn nearest(
        &mut self,
        a: &Model,
        b: &Model,
        a_from_b: AnyPose,
        at_most: Option<Distance>,
    ) -> Result<Option<Gap>, Error> {
        let subject = with_default(|| Subject::pair([a, b], a_from_b, Distance::default()))?;
        self.query.distance(&subject, at_most)
    }

    fn subject<'m>(
        &self,
        a: &'m Model,
        b: &'m Model,
        a_from_b: impl Into<AnyPose>,
    ) -> Result<Subject<&'m Model>, Error> {
        with_default(|| Subject::pair([a, b], a_from_b.into(), self.within))
    }
}
