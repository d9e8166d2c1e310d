//! Impacts of bodies that move: which triangles of which bodies meet on the way, and when first.

use super::SceneQuery;
use super::bodies::Bodies;
use super::body::Body;
use super::broad::{Broad, Places};
use super::cache::Cache;
use super::hit::SceneHit;
use super::id::BodyId;
use super::pairs::tree;
use crate::environment::with_default;
use crate::executor::impacts::{AT_START, AnyMovingBvtt, MovingSubjects, SubjectNodePair};
use crate::executor::{Backend, History, check};
use crate::memory::push;
use crate::{AnyPose, Error, Impact};
use pfront_core::bvtt::PairBvtt;
use pfront_core::motion::MovingBvh;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

impl SceneQuery {
    /// All pairs of triangles of bodies that meet while some of these move, sorted, each with when they first do, as
    /// [`PairQuery::impacts`](crate::PairQuery::impacts) has them. Every body starts where [`SceneQuery::set_pose`] has put it, and those that are
    /// given with a pose go there, their corners in straight lines as those of [`Motion::new`](crate::Motion::new); all others stay. The scene is
    /// the same afterwards.
    ///
    /// Pairs that [`SceneQuery::all`] has are among them, from 0 on, and of bodies that stay no others. Groups and
    /// [ignored](SceneQuery::ignore) pairs are heeded; after [`SceneQuery::within`] pairs are those that come within the distance. A body that is asked
    /// about itself is so in its own frame, where it rests. At either end two bodies are posed in f64 if the model or the pose of one is in f64.
    ///
    /// The threads of the executor divide pairs of bodies and the node pairs of each; a GPU is not asked.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if a body is not there, [`Error::TwoEnds`] if one is given twice, [`Error::Pose`] if a pose is not finite or takes
    /// the model out of range; else as [`SceneQuery::intersecting_bodies`].
    ///
    /// # Complexity
    /// O(n) for n bodies, and what those pairs take whose boxes overlap at a common time, so that bodies which move side by side have as many
    /// as bodies at rest. Kept hits of still bodies that stay are not asked about again.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Pose, SceneQuery};
    /// let tile = Model::new(vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// let at = |z| Pose::from_translation([0.0, 0.0, z]);
    /// let (wall, shot, roof) = (scene.add(tile.clone(), at(0.0))?, scene.add(tile.clone(), at(1.0))?, scene.add(tile, at(5.0))?);
    /// // The shot flies through the wall; the roof goes with it, and meets nothing.
    /// let impacts = scene.impacts(&[(shot, at(-3.0)), (roof, at(1.0))])?;
    /// assert_eq!(impacts.len(), 1);
    /// let (hit, impact) = impacts[0];
    /// assert!(hit.bodies == [wall, shot] && impact.from <= 0.25 && 0.25 <= impact.to);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn impacts(
        &mut self,
        ends: &[(BodyId, impl Into<AnyPose> + Copy)],
    ) -> Result<Vec<(SceneHit, Impact)>, Error> {
        with_default(|| {
            let (scene, broad, history) = self.moving(ends)?;
            let subjects = scene.subjects(broad, history.executor().cancel_flag())?;
            let mut all = Vec::new();
            for hit in scene.kept() {
                push(&mut all, (hit, AT_START))?;
            }
            MovingSubjects::new(history, &subjects, |two| scene.tree(two)).all(&mut all)?;
            history.sort(&mut all, |hit| hit.0);
            Ok(all)
        })
    }

    /// The pair of triangles that meets first while some bodies move, by `from`, then by the bodies and the pair, and when, if any does.
    ///
    /// # Errors
    /// As [`SceneQuery::impacts`].
    ///
    /// # Complexity
    /// As [`SceneQuery::impacts`]; pairs of bodies whose boxes overlap first are asked first, and those that do so later than the answer are left out.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// # let at = |z| Pose::from_translation([0.0, 0.0, z]);
    /// let (near, far) = (scene.add(tile.clone(), at(0.0))?, scene.add(tile.clone(), at(-2.0))?);
    /// let shot = scene.add(tile, at(1.0))?;
    /// let (hit, impact) = scene.first_impact(&[(shot, at(-3.0))])?.expect("it flies through both");
    /// assert_eq!(hit.bodies, [near, shot]);
    /// // It may go so far.
    /// assert!(impact.from <= 0.25 && 0.249 < impact.from);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn first_impact(
        &mut self,
        ends: &[(BodyId, impl Into<AnyPose> + Copy)],
    ) -> Result<Option<(SceneHit, Impact)>, Error> {
        with_default(|| {
            let (scene, broad, history) = self.moving(ends)?;
            let subjects = scene.subjects(broad, history.executor().cancel_flag())?;
            let known = scene.kept().next().map(|hit| (hit, AT_START));
            MovingSubjects::new(history, &subjects, |two| scene.tree(two)).first(known)
        })
    }

    /// Some pair of triangles that meets while some bodies move, if any does: one that certainly meets, unless all that
    /// [`SceneQuery::impacts`] has are open. Executors may name different pairs.
    ///
    /// # Errors
    /// As [`SceneQuery::impacts`].
    ///
    /// # Complexity
    /// Stops at the first pair that certainly meets; pairs of bodies whose boxes overlap first are asked first.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// # let at = |z| Pose::from_translation([0.0, 0.0, z]);
    /// scene.add(tile.clone(), at(0.0))?;
    /// let link = scene.add(tile, at(1.0))?;
    /// assert!(scene.any_impact(&[(link, at(0.5))])?.is_none());
    /// assert!(scene.any_impact(&[(link, at(-1.0))])?.is_some_and(|(_, impact)| impact.is_proven()));
    /// assert_eq!(scene.count_impacts(&[(link, at(-1.0))])?, [1, 1]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn any_impact(
        &mut self,
        ends: &[(BodyId, impl Into<AnyPose> + Copy)],
    ) -> Result<Option<(SceneHit, Impact)>, Error> {
        with_default(|| {
            let (scene, broad, history) = self.moving(ends)?;
            if let Some(hit) = scene.kept().next() {
                return Ok(Some((hit, AT_START)));
            }
            let subjects = scene.subjects(broad, history.executor().cancel_flag())?;
            MovingSubjects::new(history, &subjects, |two| scene.tree(two)).any()
        })
    }

    /// How many pairs of triangles meet while some bodies move: at least the first number, of those that certainly do, and at most the
    /// second, of all that [`SceneQuery::impacts`] has. No list of them is kept.
    ///
    /// # Errors
    /// As [`SceneQuery::impacts`].
    ///
    /// # Complexity
    /// The time of [`SceneQuery::impacts`], but for its list.
    ///
    /// # Examples
    /// See [`SceneQuery::any_impact`].
    pub fn count_impacts(
        &mut self,
        ends: &[(BodyId, impl Into<AnyPose> + Copy)],
    ) -> Result<[u64; 2], Error> {
        with_default(|| {
            let (scene, broad, history) = self.moving(ends)?;
            let subjects = scene.subjects(broad, history.executor().cancel_flag())?;
            let kept = scene.kept().count() as u64;
            let counts = MovingSubjects::new(history, &subjects, |two| scene.tree(two)).count()?;
            Ok(counts.map(|count| kept + count))
        })
    }

    /// The bodies as they move, with what finds their pairs.
    fn moving(
        &mut self,
        ends: &[(BodyId, impl Into<AnyPose> + Copy)],
    ) -> Result<(MovingBodies<'_>, &Broad, &mut History<[BodyId; 2]>), Error> {
        self.start();
        let ends = checked(&self.bodies, ends)?;
        self.find_overlaps()?;
        self.history.note_cpu(Backend::Sequential);
        let Self { bodies, broad, hits, history, .. } = self;
        Ok((MovingBodies { bodies, ends, hits }, broad, history))
    }
}

/// The places of bodies that move and their poses at the end, ascending.
fn checked(
    bodies: &Bodies,
    given: &[(BodyId, impl Into<AnyPose> + Copy)],
) -> Result<Vec<(u32, AnyPose)>, Error> {
    let mut ends = Vec::new();
    for &(id, pose) in given {
        let ((place, body), pose) = (bodies.placed(id)?, pose.into());
        pose.check(body.model().bvh())?;
        push(&mut ends, (place, pose))?;
    }
    ends.sort_unstable_by_key(|end| end.0);
    let twice = ends.windows(2).find(|two| two[0].0 == two[1].0);
    if let Some(body) = twice.and_then(|two| bodies.at(two[0].0)) {
        return Err(Error::TwoEnds { id: body.id() });
    }
    ends.retain(|(place, pose)| bodies.at(*place).is_some_and(|body| !body.pose().same_bits(pose)));
    Ok(ends)
}

/// The bodies of a scene of which some move.
struct MovingBodies<'s> {
    bodies: &'s Bodies,
    /// The places of those that move, ascending, and their poses at the end.
    ends: Vec<(u32, AnyPose)>,
    /// Hits that are known of bodies that have not changed since.
    hits: &'s Cache<SceneHit>,
}

impl<'s> MovingBodies<'s> {
    fn end(&self, place: u32) -> Option<&AnyPose> {
        self.ends.binary_search_by_key(&place, |end| end.0).ok().map(|i| &self.ends[i].1)
    }

    /// Whether neither of two bodies moves against the other: both rest, or they are one.
    fn rest(&self, [a, b]: Places) -> bool {
        a == b || self.end(a).is_none() && self.end(b).is_none()
    }

    /// The known hits of bodies that rest, sorted.
    fn kept(&self) -> impl Iterator<Item = SceneHit> {
        let pieces = self.hits.still_true(self.bodies);
        let rest = |two: [BodyId; 2]| {
            let [a, b] = two.map(|id| self.bodies.placed(id).map(|(place, _)| place));
            a.and_then(|a| Ok(self.rest([a, b?]))).unwrap_or(false)
        };
        pieces.filter(move |piece| rest(piece[0].bodies)).flatten().copied()
    }

    /// Pairs of bodies to be asked about, by the time before which they do not meet.
    fn subjects(
        &self,
        broad: &Broad,
        flag: Option<&AtomicBool>,
    ) -> Result<Vec<SubjectNodePair<Places>>, Error> {
        let mut subjects = Vec::new();
        let mut add = |two| {
            check(flag)?;
            let is_kept = || self.bodies.changed_at(two) <= self.hits.at();
            if !self.bodies.may_meet(two) || self.rest(two) && is_kept() {
                return Ok(());
            }
            let tree = self.tree(two).map(|(_, tree)| tree);
            match tree.and_then(|tree| tree.first_overlap()) {
                Some(from) => push(&mut subjects, SubjectNodePair::root(two, from)),
                None => Ok(()),
            }
        };
        for (_, place) in self.bodies.iter().zip(0..) {
            add([place; 2])?;
        }
        let mut boxes = Vec::new();
        for &(place, pose) in &self.ends {
            let aabb = self.bodies.at(place).map(|body| pose.place(body.model().bvh()).aabb());
            push(&mut boxes, (place, aabb.flatten()))?;
        }
        let mut added = Ok(());
        broad.while_moving(&boxes, self.bodies.within, |two| {
            added = add(two);
            if added.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })?;
        added?;
        subjects.sort_unstable_by(|x, y| x.from.total_cmp(&y.from).then(x.subject.cmp(&y.subject)));
        Ok(subjects)
    }

    /// The names and the tree of two bodies, or of one and itself.
    fn tree(&self, two: Places) -> Option<([BodyId; 2], AnyMovingBvtt<'_>)> {
        let [a, b] = [self.bodies.at(two[0])?, self.bodies.at(two[1])?];
        let side = |place, body: &'s Body| {
            let start = body.placed();
            let end = self.end(place).map_or(start, |pose| pose.place(body.model().bvh()));
            MovingBvh::new_unchecked(start, end)
        };
        let within = self.bodies.within;
        let tree = match self.rest(two) {
            true => AnyMovingBvtt::Still(tree(a, b, within)),
            false => {
                let moving = PairBvtt::moving(side(two[0], a), side(two[1], b));
                AnyMovingBvtt::Pair(moving.within(within))
            }
        };
        Some(([a.id(), b.id()], tree))
    }
}
