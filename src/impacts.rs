//! Impacts of models that move: which triangles meet on the way, and when first, by the CPU of an executor.

use crate::environment::with_default;
use crate::executor::History;
use crate::executor::impacts::{AnyMovingBvtt, MovingSubjects, SubjectNodePair};
use crate::{Error, Impact, Motion, PairQuery, SelfQuery, TrianglePair};
use pfront_core::bvtt::{PairBvtt, SelfBvtt};

impl PairQuery {
    /// All pairs of triangles of two models that meet while both move, sorted, each with when they first do: they do not meet before `from`, and
    /// certainly meet before `to`, if that is finite; 0 is the start and 1 the end. CPUs answer, whatever the executor; the same to the
    /// bit. After [`PairQuery::within`], all pairs that come within the distance, and when first.
    ///
    /// No pair is missed. A pair is open, with an infinite `to`, if it comes near but neither a meeting nor a miss is proven: where triangles
    /// touch and do not pass, move in one plane for ever, have coordinates of more than 356 bits, or pass each other at a gap far below
    /// rounding errors; within a distance, where they come as near as it is and no nearer. See [`pfront_core::motion`].
    ///
    /// # Errors
    /// [`Error::Memory`]; [`Error::Cancelled`] if the flag of the executor is set.
    ///
    /// # Complexity
    /// Two boxes of each node are compared at a common time, so that bodies which move side by side have as many pairs as bodies at rest. Two
    /// triangles whose boxes meet at a time take some ten nanoseconds if they stay well apart, else some microseconds.
    ///
    /// # Examples
    /// See [`Motion`].
    pub fn impacts(
        &mut self,
        a: &Motion<'_>,
        b: &Motion<'_>,
    ) -> Result<Vec<(TrianglePair, Impact)>, Error> {
        self.ask(a, b, all)
    }

    /// The pair of triangles that meets first, by `from` and then by the pair, and when, if any does.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Complexity
    /// Node pairs that meet first are visited first, and those that do so later than the answer are left out.
    pub fn first_impact(
        &mut self,
        a: &Motion<'_>,
        b: &Motion<'_>,
    ) -> Result<Option<(TrianglePair, Impact)>, Error> {
        self.ask(a, b, first)
    }

    /// Some pair of triangles that meets while both move, with when it does, if any does: one that certainly meets, unless all that
    /// [`PairQuery::impacts`] has are open. So nothing meets if there is none, something certainly does if it is
    /// [proven](Impact::is_proven), and else that is open. Executors may name different pairs.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Complexity
    /// Stops at the first pair that certainly meets, whenever that is; what meets nowhere takes as long as [`PairQuery::impacts`].
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Motion, PairQuery, Pose};
    /// let tile = Model::new(vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let at = |z| Pose::from_translation([0.0, 0.0, z]);
    /// let (mut query, rest) = (PairQuery::new(), Motion::at_rest(&tile));
    /// assert!(query.any_impact(&rest, &Motion::new(&tile, at(1.0), at(0.25))?)?.is_none());
    /// let (_, impact) = query.any_impact(&rest, &Motion::new(&tile, at(1.0), at(-3.0))?)?.expect("it flies through");
    /// assert!(impact.is_proven());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn any_impact(
        &mut self,
        a: &Motion<'_>,
        b: &Motion<'_>,
    ) -> Result<Option<(TrianglePair, Impact)>, Error> {
        self.ask(a, b, any)
    }

    /// How many pairs of triangles meet while both move: at least the first number, of those that certainly do, and at most the second, of all
    /// that [`PairQuery::impacts`] has. The same from every executor, and no list is kept.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Complexity
    /// The time of [`PairQuery::impacts`], but for its list.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Motion, PairQuery, Pose};
    /// # let tile = Model::new(vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let at = |z| Pose::from_translation([0.0, 0.0, z]);
    /// let (mut query, rest) = (PairQuery::new(), Motion::at_rest(&tile));
    /// assert_eq!(query.count_impacts(&rest, &Motion::new(&tile, at(1.0), at(-3.0))?)?, [1, 1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn count_impacts(&mut self, a: &Motion<'_>, b: &Motion<'_>) -> Result<[u64; 2], Error> {
        self.ask(a, b, count)
    }

    fn ask<T>(&mut self, a: &Motion<'_>, b: &Motion<'_>, verb: Verb<T>) -> Result<T, Error> {
        let (within, history) = (self.within, self.query.history());
        let tree = || PairBvtt::moving(a.bvh(), b.bvh()).within(within);
        with_default(|| verb(history, AnyMovingBvtt::Pair(tree())))
    }
}

impl SelfQuery {
    /// All pairs of triangles of one model that meet while it deforms, as [`PairQuery::impacts`] has them. Triangles that share a vertex are
    /// decided by [a rule of their own](pfront_core::motion::impact_in_mesh); poses do not matter.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Examples
    /// See [`Motion::between`].
    pub fn impacts(&mut self, motion: &Motion<'_>) -> Result<Vec<(TrianglePair, Impact)>, Error> {
        self.ask(motion, all)
    }

    /// The pair of triangles of one model that meets first while it deforms.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    pub fn first_impact(
        &mut self,
        motion: &Motion<'_>,
    ) -> Result<Option<(TrianglePair, Impact)>, Error> {
        self.ask(motion, first)
    }

    /// Some pair of triangles of one model that meets while it deforms, as [`PairQuery::any_impact`] has it.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Motion, SelfQuery};
    /// let sheets = |gap| {
    ///     let sheet = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    ///     Model::new([sheet(0.0), sheet(gap)].concat(), vec![[0, 1, 2], [3, 4, 5]])
    /// };
    /// let (before, after) = (sheets(0.5)?, sheets(-0.5)?);
    /// let (mut query, motion) = (SelfQuery::new(), Motion::between(&before, &after)?);
    /// assert!(query.any_impact(&motion)?.is_some_and(|(_, impact)| impact.is_proven()));
    /// assert_eq!(query.count_impacts(&motion)?, [1, 1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn any_impact(
        &mut self,
        motion: &Motion<'_>,
    ) -> Result<Option<(TrianglePair, Impact)>, Error> {
        self.ask(motion, any)
    }

    /// How many pairs of triangles of one model meet while it deforms, as [`PairQuery::count_impacts`] has it.
    ///
    /// # Errors
    /// As [`PairQuery::impacts`].
    ///
    /// # Examples
    /// See [`SelfQuery::any_impact`].
    pub fn count_impacts(&mut self, motion: &Motion<'_>) -> Result<[u64; 2], Error> {
        self.ask(motion, count)
    }

    fn ask<T>(&mut self, motion: &Motion<'_>, verb: Verb<T>) -> Result<T, Error> {
        let (adjacency, within) = (self.adjacency(), self.distance());
        let history = self.history();
        let tree = || SelfBvtt::moving(motion.bvh()).with_adjacency(adjacency).within(within);
        with_default(|| verb(history, AnyMovingBvtt::Itself(tree())))
    }
}

/// A verb about the one subject of a query.
type Verb<T> = fn(&mut History<()>, AnyMovingBvtt<'_>) -> Result<T, Error>;

/// All pairs of one subject, sorted.
fn all(
    history: &mut History<()>,
    tree: AnyMovingBvtt<'_>,
) -> Result<Vec<(TrianglePair, Impact)>, Error> {
    let mut all = Vec::new();
    MovingSubjects::new(history, root(&tree).as_slice(), |()| Some(((), tree))).all(&mut all)?;
    history.sort(&mut all, |hit| hit.0);
    Ok(all)
}

/// The first pair of one subject.
fn first(
    history: &mut History<()>,
    tree: AnyMovingBvtt<'_>,
) -> Result<Option<(TrianglePair, Impact)>, Error> {
    MovingSubjects::new(history, root(&tree).as_slice(), |()| Some(((), tree))).first(None)
}

/// Some pair of one subject.
fn any(
    history: &mut History<()>,
    tree: AnyMovingBvtt<'_>,
) -> Result<Option<(TrianglePair, Impact)>, Error> {
    MovingSubjects::new(history, root(&tree).as_slice(), |()| Some(((), tree))).any()
}

/// How many pairs of one subject certainly meet, and how many do or are open.
fn count(history: &mut History<()>, tree: AnyMovingBvtt<'_>) -> Result<[u64; 2], Error> {
    MovingSubjects::new(history, root(&tree).as_slice(), |()| Some(((), tree))).count()
}

/// The only subject, if its boxes overlap at a time.
fn root(tree: &AnyMovingBvtt<'_>) -> Option<SubjectNodePair<()>> {
    tree.first_overlap().map(|from| SubjectNodePair::root((), from))
}
