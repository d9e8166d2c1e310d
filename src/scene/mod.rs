//! Many posed models.

mod bodies;
mod body;
mod broad;
mod cache;
mod check;
#[cfg(feature = "gpu")]
mod device;
#[cfg(not(feature = "gpu"))]
#[path = "no_device.rs"]
mod device;
mod edit;
mod frame;
mod hit;
mod id;
mod impacts;
mod nearest;
mod pairs;
mod report;
mod segment;
mod split;

pub use body::{Body, BodyOptions, Groups};
pub use edit::Piece;
pub use hit::SceneHit;
pub use id::BodyId;
pub use report::{Allowed, CheckReport, CheckedPair};
pub use segment::BodyLocation;

use crate::environment::{Environment, with_default};
use crate::executor::{Answer, Backend, CpuPart, History, Meeting, Plan, Verb, visit as search};
use crate::memory::{extend, push};
use crate::{Aabb, Contact, Distance, Error, Executor, TrianglePair};
use bodies::Bodies;
use broad::Broad;
use cache::{Cache, merge};
use device::DeviceScene;
use frame::SceneFrame;
use pairs::{BodyPairs, meeting};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;

/// Asks which triangles of many bodies meet, each body against each.
///
/// A body is a [`crate::Model`] in a pose. Bodies are added, removed, moved, deformed and split between
/// frames. Every vertex is posed into the world by [`crate::Pose::apply`], whatever the other body is, and
/// that decides what meets: a cube that rests on another is found to touch it where both are rounded
/// to the world, which is not where one would be rounded to the other's frame, as [`crate::PairQuery`]
/// does. Vertices of a body at [`crate::Pose::IDENTITY`] stay as they are. Two bodies are posed and decided in f64 if the
/// model or the pose of one is in f64.
///
/// Cloth is asked whether it meets itself in the same question, if [`BodyOptions::itself`] says so.
///
/// # Threads
/// On [`Executor::threads`] all pairs of bodies that have to be asked are one frame, which, if it is worth several
/// threads, is divided among the workers by one front under one bound (Zhang & Kim 2014, eq. 5). The cost of a pair of bodies is
/// remembered from one frame to the next in which it is asked. More pairs than 65,536 are asked in batches of as
/// many, which bounds the memory; then nothing is remembered. Contacts, and which bodies meet, are found by the same threads.
///
/// # GPU
/// On an executor with a GPU, pairs with a body in f64, bodies themselves, and after [`SceneQuery::within`] all pairs are asked about on the
/// CPU, all others by the GPU; contacts, visits, distances and which bodies meet are found on the CPU. [`SceneQuery::plan`] tells.
///
/// # Still bodies
/// Hits that [`SceneQuery::all`] and [`SceneQuery::contacts`] find are kept: as long as neither of two bodies
/// moves, deforms or is replaced, these do not ask them again, nor do [`SceneQuery::any`], [`SceneQuery::count`],
/// [`SceneQuery::intersecting_bodies`] and [`SceneQuery::visit`], which keep nothing themselves. A body that is set to the pose, the
/// positions, the model or the groups that it has, to the bit, does not change.
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
#[derive(Clone, Default)]
pub struct SceneQuery {
    bodies: Bodies,
    broad: Broad,
    hits: Cache<SceneHit>,
    contacts: Cache<(SceneHit, Contact)>,
    /// Hits and contacts of the bodies that have changed.
    new_hits: Vec<SceneHit>,
    new_contacts: Vec<(SceneHit, Contact)>,
    history: History<[BodyId; 2]>,
    device: DeviceScene,
    /// The body that was nearest to one, and the nearest pair, for the next search.
    nearest: BTreeMap<BodyId, (BodyId, TrianglePair)>,
}

/// Without the bodies, which may be many.
impl fmt::Debug for SceneQuery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneQuery")
            .field("bodies", &self.len())
            .field("hits", &self.hits().len())
            .finish_non_exhaustive()
    }
}

impl SceneQuery {
    /// An exact query of no bodies.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same by an executor; see [`crate::PairQuery::on`]. Bodies, and what is known of those that stay, are kept.
    #[must_use]
    pub fn on(mut self, executor: &Executor) -> Self {
        self.history = History::on(executor);
        self.device = DeviceScene::default();
        self
    }

    /// Asks from now on for pairs of bodies at most `distance` apart in the world, in its units, as [`PairQuery::within`](crate::PairQuery::within) says;
    /// bodies that are asked about themselves, too, in their own frames, whose units are others if poses scale. The list of hits is empty until the next question.
    ///
    /// # Errors
    /// [`Error::Distance`] if the distance is NaN, infinite or negative.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Pose, SceneQuery};
    /// use std::sync::Arc;
    /// let part = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let (part, mut scene) = (Arc::new(part), SceneQuery::new());
    /// scene.within(0.02)?;
    /// scene.add(part.clone(), Pose::IDENTITY)?;
    /// scene.add(part.clone(), Pose::from_translation([0.0, 0.0, 0.02]))?;
    /// scene.add(part, Pose::from_translation([0.0, 0.0, 0.05]))?;
    /// assert_eq!(scene.all()?.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn within(&mut self, distance: f32) -> Result<(), Error> {
        self.bodies.within = Distance::new(distance)?;
        (self.broad, self.device) = Default::default();
        (self.hits, self.contacts) = Default::default();
        Ok(())
    }

    /// Counts and times of the last frame on threads in which something had changed; see [`Report`](crate::threads::Report).
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn report(&self) -> Option<&crate::threads::Report> {
        self.history.report()
    }

    /// The backend that answered the last question, whatever it was and however it ended, and the reason; `None` before the
    /// first. Kept hits of still bodies are no backend's work, unless they are the whole answer.
    #[must_use]
    pub fn plan(&self) -> Option<&Plan> {
        self.history.plan()
    }

    /// All pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::Mesh`] if there are more than 2^31 bodies; [`Error::Cancelled`] by the flag of [`Executor::with_cancel`];
    /// [`Error::Memory`]; `Error::Gpu` if a GPU fails that is to answer everything.
    pub fn all(&mut self) -> Result<&[SceneHit], Error> {
        self.find_hits()?;
        Ok(self.hits.list(&self.bodies))
    }

    /// Finds what [`SceneQuery::all`] finds, for [`SceneQuery::hits`], which leaves the scene free to be looked into.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// let floor = scene.add(tile.clone(), Pose::IDENTITY)?;
    /// let lid = scene.add(tile, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// scene.update()?;
    /// for hit in scene.hits() {
    ///     let [a, b] = hit.bodies;
    ///     println!("{:?} meets {:?}", scene.body(a)?.pose(), scene.body(b)?.pose());
    /// }
    /// assert_eq!(scene.hits()[0].bodies, [floor, lid]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn update(&mut self) -> Result<(), Error> {
        self.find_hits()
    }

    /// The list of the last [`SceneQuery::update`], [`SceneQuery::all`] or [`SceneQuery::contacts`], whatever has moved since,
    /// but without bodies and meshes that have gone since; empty before the first.
    #[must_use]
    pub fn hits(&self) -> &[SceneHit] {
        self.hits.list(&self.bodies)
    }

    /// Some pair that meets, if any does; stops at the first.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn any(&mut self) -> Result<Option<SceneHit>, Error> {
        let since = self.start();
        if let Some(hits) = self.hits.still_true(&self.bodies).next() {
            self.history.keep();
            return Ok(hits.first().copied());
        }
        if since == self.bodies.time() {
            self.history.keep();
            return Ok(None);
        }
        Ok(self.ask(since, Verb::Any)?.first)
    }

    /// How many pairs meet.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn count(&mut self) -> Result<u64, Error> {
        let since = self.start();
        let kept = self.hits.still_true(&self.bodies).map(|hits| hits.len() as u64).sum::<u64>();
        if since == self.bodies.time() {
            self.history.keep();
            return Ok(kept);
        }
        Ok(kept + self.ask(since, Verb::Count)?.count)
    }

    /// The pairs of bodies that meet, sorted, each with the body that was added first before the other: every two are asked
    /// until their first hit, so that this takes far less than [`SceneQuery::all`] where bodies share many hits. Several threads
    /// divide the pairs of bodies; a GPU is not asked. A body that meets itself, if it is asked, is there twice: `[a, a]`.
    /// Keeps nothing.
    ///
    /// # Errors
    /// As [`SceneQuery::all`], without a GPU.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let tile = std::sync::Arc::new(tile);
    /// let mut scene = SceneQuery::new();
    /// let (a, b) = (scene.add(tile.clone(), Pose::IDENTITY)?, scene.add(tile, Pose::IDENTITY)?);
    /// assert_eq!(scene.intersecting_bodies()?, [[a, b]]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn intersecting_bodies(&mut self) -> Result<Vec<[BodyId; 2]>, Error> {
        let since = self.start();
        let mut pairs = Vec::new();
        for of_two in self.hits.still_true(&self.bodies) {
            push(&mut pairs, of_two[0].bodies)?;
        }
        if since == self.bodies.time() {
            self.history.keep();
            return Ok(pairs);
        }
        with_default(|| {
            self.find_overlaps()?;
            let candidates = BodyPairs::since(since, &self.bodies, &self.broad);
            let mut asked = Vec::new();
            candidates.pairs().try_for_each(|places| push(&mut asked, places))?;
            let part = CpuPart::new();
            let intersecting = self.history.intersecting(&asked, |places| {
                part.works();
                candidates.query(places)
            });
            self.history.note_cpu(part.backend());
            merge(&mut pairs, &intersecting?)?;
            Ok(pairs)
        })
    }

    /// The bodies whose box in the world, [`Body::aabb`], overlaps this one, sorted; touching counts. Every body is among them of
    /// which a point lies in the box. On the calling thread.
    ///
    /// # Errors
    /// As [`SceneQuery::intersecting_bodies`].
    ///
    /// # Complexity
    /// For the first question after a change, which bodies may meet is found, as for any verb; then O(log n + found) for n bodies.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Aabb, Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let tile = std::sync::Arc::new(tile);
    /// let mut scene = SceneQuery::new();
    /// let near = scene.add(tile.clone(), Pose::IDENTITY)?;
    /// scene.add(tile, Pose::from_translation([9.0, 0.0, 0.0]))?;
    /// assert_eq!(scene.bodies_in(Aabb { min: [0.0; 3], max: [2.0; 3] })?, [near]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn bodies_in(&mut self, aabb: Aabb) -> Result<Vec<BodyId>, Error> {
        self.start();
        with_default(|| {
            self.find_overlaps()?;
            self.history.note_cpu(Backend::Sequential);
            let (mut found, mut pushed) = (Vec::new(), Ok(()));
            self.broad.in_box(&aabb, |place| {
                if let (Ok(()), Some(body)) = (&pushed, self.bodies.at(place)) {
                    pushed = push(&mut found, body.id());
                }
            });
            pushed?;
            found.sort_unstable();
            Ok(found)
        })
    }

    /// Calls `visit` for each pair that meets, bodies in order and their triangles in none, until it
    /// breaks. Uses only the calling thread; `visit` runs in the caller's floating-point environment.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    ///
    /// # Examples
    /// ```
    /// use std::ops::ControlFlow;
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// # scene.add(tile.clone(), Pose::IDENTITY)?;
    /// # scene.add(tile, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let mut bodies = Vec::new();
    /// let end = scene.visit(|hit| {
    ///     bodies.extend(hit.bodies);
    ///     if bodies.len() < 20 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    /// })?;
    /// assert!(end.is_continue() && bodies.len() == 2);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn visit(
        &mut self,
        mut visit: impl FnMut(SceneHit) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error> {
        let since = self.start();
        if since == self.bodies.time() {
            self.history.keep();
            return Ok(self.hits().iter().try_for_each(|&hit| visit(hit)));
        }
        let callers = Environment::current();
        let mut tell = |hit| callers.run(|| visit(hit));
        with_default(|| {
            self.find_overlaps()?;
            self.history.note_cpu(Backend::Sequential);
            let cancel = self.history.executor().cancel_flag();
            let mut kept = self.hits.still_true(&self.bodies).peekable();
            let candidates = BodyPairs::since(since, &self.bodies, &self.broad);
            for (bodies, two) in candidates.bodies() {
                let mut end = ControlFlow::Continue(());
                while end.is_continue()
                    && let Some(of_two) = kept.next_if(|of_two| of_two[0].bodies < bodies)
                {
                    end = of_two.iter().try_for_each(|&hit| tell(hit));
                }
                if end.is_continue() {
                    search(&two.tree(), cancel, |pair| {
                        end = tell(SceneHit { bodies, pair });
                        end
                    })?;
                }
                if end.is_break() {
                    return Ok(end);
                }
            }
            Ok(kept.flatten().try_for_each(|&hit| tell(hit)))
        })
    }

    /// All pairs that meet, sorted, with the segment in which they do and their normals, in the world. Finds the hits
    /// too, for [`SceneQuery::hits`].
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// # scene.add(tile.clone(), Pose::IDENTITY)?;
    /// # scene.add(tile, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// scene.contacts()?;
    /// for (hit, contact) in scene.last_contacts() {
    ///     println!("{} at {:?}", scene.body(hit.bodies[0])?.options().user_data, contact.segment[0]);
    /// }
    /// assert_eq!(scene.last_contacts().len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn contacts(&mut self) -> Result<&[(SceneHit, Contact)], Error> {
        self.find_hits()?;
        let Self { bodies, hits, new_hits, contacts, new_contacts, history, .. } = self;
        if contacts.at() != bodies.time() {
            let mut changed = hits.list(bodies);
            if !bodies.all_changed_since(contacts.at()) {
                new_hits.clear();
                for piece in changed.chunk_by(|x, y| x.bodies == y.bodies) {
                    if bodies.changed(piece[0].bodies) > contacts.at() {
                        extend(new_hits, piece.iter().copied())?;
                    }
                }
                changed = new_hits;
            }
            new_contacts.clear();
            with_default(|| {
                let meeting = |two| meeting(bodies, two);
                history.contacts(changed, meeting, Meeting::contact, new_contacts)?;
                contacts.complete(new_contacts, bodies, history.executor().cancel_flag())
            })?;
        }
        Ok(contacts.list(bodies))
    }

    /// [`SceneQuery::contacts`] in f64, in a list of their own. Nothing of it is kept from frame to frame but the hits.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// # scene.add(tile.clone(), Pose::IDENTITY)?;
    /// # scene.add(tile, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let contacts = scene.contacts_f64()?;
    /// for (hit, contact) in &contacts {
    ///     println!("{:?} at {:?}", hit.bodies, contact.segment[0]);
    /// }
    /// assert_eq!(contacts.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn contacts_f64(&mut self) -> Result<Vec<(SceneHit, Contact<f64>)>, Error> {
        self.find_hits()?;
        let Self { bodies, hits, history, .. } = self;
        let (hits, mut contacts) = (hits.list(bodies), Vec::new());
        let meeting = |two| meeting(bodies, two);
        with_default(|| history.contacts(hits, meeting, Meeting::contact_f64, &mut contacts))?;
        Ok(contacts)
    }

    /// The list of the last [`SceneQuery::contacts`], whatever has moved since, but without bodies and meshes that have gone
    /// since; empty before the first. The scene is free to be looked into meanwhile.
    #[must_use]
    pub fn last_contacts(&self) -> &[(SceneHit, Contact)] {
        self.contacts.list(&self.bodies)
    }

    /// Begins a frame. Hits are known of the bodies that have not changed since the time that is returned.
    fn start(&mut self) -> u64 {
        self.bodies.compact();
        self.hits.at()
    }

    /// Completes the list of hits; `new_hits` is free for other use afterwards.
    fn find_hits(&mut self) -> Result<(), Error> {
        let since = self.start();
        if since == self.bodies.time() {
            self.history.keep();
            return Ok(());
        }
        self.ask(since, Verb::All)?;
        let Self { bodies, hits, new_hits, history, .. } = self;
        hits.complete(new_hits, bodies, history.executor().cancel_flag())
    }

    /// Finds which bodies may meet, on the calling thread.
    fn find_overlaps(&mut self) -> Result<(), Error> {
        let found = self.broad.update(&mut self.bodies, self.history.executor().cancel_flag());
        if found.is_err() {
            self.history.note_cpu(Backend::Sequential);
        }
        found
    }

    /// Asks of the bodies that have changed since then; lists new hits if all are wanted.
    fn ask(&mut self, since: u64, verb: Verb) -> Result<Answer<SceneHit>, Error> {
        self.new_hits.clear();
        with_default(|| {
            self.find_overlaps()?;
            let mut frame = SceneFrame {
                pairs: BodyPairs::since(since, &self.bodies, &self.broad),
                hits: &mut self.new_hits,
                device: &mut self.device,
                beside: None,
            };
            let answer = self.history.ask(&mut frame, verb);
            if let Some(part) = frame.beside {
                self.history.note_also(part);
            }
            answer
        })
    }
}
