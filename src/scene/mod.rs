//! Many posed models.

mod asker;
mod bodies;
mod broad;
#[cfg(feature = "threads")]
mod crew;
#[cfg(feature = "gpu")]
mod device;
mod edit;
mod frame;
mod kept;
mod planned;
mod split;
mod ways;

pub use bodies::{Body, BodyId};
pub use edit::Piece;

use crate::answer::Want;
use crate::planner::{Plan, Planner};
#[cfg(feature = "threads")]
use crate::threads;
use crate::{Accuracy, Contact, Error, TrianglePair};
use asker::Asker;
use bodies::Bodies;
use broad::Broad;
use frame::{Found, Frame, meeting};
use kept::Kept;
use pfront_core::bvtt::Query;
use std::ops::ControlFlow;

/// Two triangles of different bodies that meet. The order is that of `bodies`, then `pair`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SceneHit {
    /// The bodies, the one that was added first before the other.
    pub bodies: [BodyId; 2],
    /// A triangle of the first body and one of the second.
    pub pair: TrianglePair,
}

/// Asks which triangles of many bodies meet, each body against each.
///
/// A body is a [`crate::Model`] in a pose. Bodies are added, removed, moved, deformed and split between
/// frames. Every vertex is posed into the world by [`crate::Pose::apply`], whatever the other body is, and
/// that decides what meets: a cube that rests on another is found to touch it where both are rounded
/// to the world, which is not where one would be rounded to the other's frame, as [`crate::PairQuery`]
/// does. Vertices of a body at [`crate::Pose::IDENTITY`] stay as they are.
///
/// A deforming body is not asked whether it meets itself; [`crate::SelfQuery`] does that.
///
/// # Threads
/// With [`SceneQuery::with_threads`] all pairs of bodies that have to be asked are divided among the workers
/// together, by one front under one bound (Zhang & Kim 2014, eq. 5). What a pair of bodies cost is
/// remembered from one frame to the next in which it is asked. More pairs than 65,536 are asked in batches of as
/// many, which bounds the memory; then nothing is remembered.
///
/// # Still bodies
/// What [`SceneQuery::all`] and [`SceneQuery::contacts`] find is kept: as long as neither of two bodies
/// moves, deforms or is replaced, these do not ask them again, nor do [`SceneQuery::any`] and
/// [`SceneQuery::count`], which keep nothing themselves. A body that is set to the pose it has does not move.
///
/// # Complexity
/// A frame takes O(n) for the boxes of n bodies, O(n log n) if one has come or gone; what those pairs take
/// whose bounds overlap and of which one has changed; and O(hits) to copy what is kept, of which there are
/// two lists in turn, of 24 bytes a hit. Buffers are kept: a frame in which no body comes or goes, no more
/// bodies change and no more is found, of these and in all, than in earlier ones allocates nothing on a single
/// thread, unless bodies have scattered so far that the BVH of their boxes is built anew.
///
/// # Examples
/// ```
/// use pfront::{Model, Pose, SceneQuery};
/// use std::sync::Arc;
/// let tile = Arc::new(Model::new(
///     vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
///     vec![[0, 1, 2]],
/// )?);
/// let mut scene = SceneQuery::new();
/// let below = scene.add(tile.clone(), Pose::IDENTITY)?;
/// let above = scene.add(tile, Pose::from_translation([0.0, 0.0, 1.0]))?;
/// assert_eq!(scene.count()?, 0);
///
/// scene.set_pose(above, Pose::IDENTITY)?;
/// let hits = scene.all()?;
/// assert_eq!(hits.len(), 1);
/// assert_eq!(hits[0].bodies, [below, above]);
///
/// scene.remove(below)?;
/// assert_eq!(scene.count()?, 0);
/// assert!(scene.body(below).is_err());
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SceneQuery {
    accuracy: Accuracy,
    bodies: Bodies,
    broad: Broad,
    hits: Kept<SceneHit>,
    contacts: Kept<(SceneHit, Contact)>,
    /// Hits and contacts of the bodies that have changed.
    new_hits: Vec<SceneHit>,
    new_contacts: Vec<(SceneHit, Contact)>,
    asker: Asker,
}

impl SceneQuery {
    /// An exact query of no bodies.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with another [`Accuracy`].
    #[must_use]
    pub fn with_accuracy(mut self, accuracy: Accuracy) -> Self {
        self.accuracy = accuracy;
        self.hits.forget();
        self.contacts.forget();
        self
    }

    /// The same on several threads; see [`crate::PairQuery::with_threads`].
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn with_threads(self, workers: usize) -> Self {
        self.with_traversal(threads::Traversal::new(workers))
    }

    /// [`SceneQuery::with_threads`] with a pool and settings of your own.
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn with_traversal(mut self, traversal: threads::Traversal) -> Self {
        self.asker = Asker::Crew(Box::new(crew::Crew::new(traversal)));
        self
    }

    /// What the last frame on threads did in which something had changed; see [`threads::Report`].
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn report(&self) -> Option<&threads::Report> {
        match &self.asker {
            Asker::Crew(crew) => Some(crew.report()),
            _ => None,
        }
    }

    /// The same by a [`Planner`]; see [`crate::PairQuery::with_planner`].
    #[must_use]
    pub fn with_planner(mut self, planner: Planner) -> Self {
        self.asker = Asker::Planned(Box::new(planned::Planned::new(planner)));
        self
    }

    /// How the last frame was answered by a planner, and why so.
    #[must_use]
    pub fn plan(&self) -> Option<Plan> {
        match &self.asker {
            Asker::Planned(planned) => planned.plan(),
            _ => None,
        }
    }

    /// All pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::Mesh`] if there are more than 2^31 bodies.
    pub fn all(&mut self) -> Result<&[SceneHit], Error> {
        let since = self.start();
        if since == self.bodies.time() {
            self.asker.keep();
            return Ok(self.hits.list());
        }
        match self.ask(since, Want::All)? {
            Found::New(_) => self.hits.complete(&self.new_hits, &self.bodies),
            Found::All(_) => self.hits.replace(&mut self.new_hits, &self.bodies),
        }
        if self.asker.has_conceded() {
            self.hits.distrust();
        }
        Ok(self.hits.list())
    }

    /// Some pair that meets, if any does; stops at the first.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn any(&mut self) -> Result<Option<SceneHit>, Error> {
        let since = self.start();
        if let Some(hits) = self.hits.still_true(&self.bodies).next() {
            self.asker.keep();
            return Ok(hits.first().copied());
        }
        if since == self.bodies.time() {
            self.asker.keep();
            return Ok(None);
        }
        Ok(self.ask(since, Want::Any)?.get().first)
    }

    /// How many pairs meet.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn count(&mut self) -> Result<u64, Error> {
        let since = self.start();
        let kept = self.hits.still_true(&self.bodies).map(|hits| hits.len() as u64).sum::<u64>();
        if since == self.bodies.time() {
            self.asker.keep();
            return Ok(kept);
        }
        Ok(match self.ask(since, Want::Count)? {
            Found::New(given) => kept + given.count,
            Found::All(given) => given.count,
        })
    }

    /// Calls `visit` for each pair that meets, bodies in order and their triangles in none, until it
    /// breaks. Uses only the calling thread, and what is kept only where nothing has changed.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    ///
    /// # Examples
    /// ```
    /// use std::ops::ControlFlow;
    /// # let mut scene = pfront::SceneQuery::new();
    /// let mut bodies = Vec::new();
    /// let _ = scene.visit(|hit| {
    ///     bodies.extend(hit.bodies);
    ///     if bodies.len() < 20 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    /// })?;
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn visit(
        &mut self,
        mut visit: impl FnMut(SceneHit) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error> {
        if self.start() == self.bodies.time() {
            return Ok(self.hits.list().iter().try_for_each(|&hit| visit(hit)));
        }
        self.asker.update(&mut self.broad, &mut self.bodies)?;
        let frame = Frame::since(0, self.accuracy, &self.bodies, &self.broad);
        let end = frame.queries().try_for_each(|(bodies, query)| {
            query.visit(&mut query.start(), |pair| visit(SceneHit { bodies, pair }))
        });
        Ok(end)
    }

    /// All pairs that meet, sorted, with the segment in which they do and their normals, in the world. A
    /// pair that only `Conservative` or `Fast` reports meets nowhere and is left out.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn contacts(&mut self) -> Result<&[(SceneHit, Contact)], Error> {
        self.all()?;
        if self.contacts.at() == self.bodies.time() {
            return Ok(self.contacts.list());
        }
        self.new_contacts.clear();
        for of_two in self.hits.list().chunk_by(|x, y| x.bodies == y.bodies) {
            let [a, b] = of_two[0].bodies;
            if self.bodies.changed([a, b]) <= self.contacts.at() {
                continue;
            }
            let query = meeting(self.bodies.get(a)?, self.bodies.get(b)?);
            let found = of_two.iter().filter_map(|&hit| Some((hit, query.contact(hit.pair)?)));
            self.new_contacts.extend(found);
        }
        self.contacts.complete(&self.new_contacts, &self.bodies);
        // Those of hits that were not all are not all either.
        if self.asker.has_conceded() {
            self.contacts.distrust();
        }
        Ok(self.contacts.list())
    }

    /// Begins a frame. Hits are known of the bodies that have not changed since the time that is returned.
    fn start(&mut self) -> u64 {
        self.asker.start();
        self.bodies.compact();
        self.hits.at()
    }

    /// Asks of the bodies that have changed since then, or of all; lists new hits if all are wanted.
    fn ask(&mut self, since: u64, want: Want) -> Result<Found, Error> {
        self.new_hits.clear();
        let Self { accuracy, bodies, broad, asker, new_hits, .. } = self;
        if let Some(given) = asker.ask_ahead(*accuracy, bodies, want, new_hits) {
            return Ok(Found::All(given));
        }
        asker.update(broad, bodies)?;
        let frame = Frame::since(since, *accuracy, bodies, broad);
        Ok(asker.ask(&frame, want, new_hits))
    }
}
