//! Changes to a scene between frames.

use super::SceneQuery;
use super::body::{Body, BodyOptions};
use super::id::BodyId;
use super::split::{Cutter, parts};
use crate::environment::with_default;
use crate::model::ONE_THREAD;
use crate::{AnyPose, Error, Model, Scalar};
use std::sync::Arc;

/// A body that [`SceneQuery::split`] makes of one part of another.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Piece {
    /// The new body.
    pub body: BodyId,
    /// The number of the part.
    pub part: u32,
    /// The way back: triangle i of the new body was triangle `triangles[i]` of the old one. Ascending.
    pub triangles: Vec<u32>,
}

/// Nothing changes where a call fails.
impl SceneQuery {
    /// Adds a body in the pose `world_from_body`. Many bodies may share one model.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose is not finite or takes the model out of range.
    pub fn add(
        &mut self,
        model: impl Into<Arc<Model>>,
        world_from_body: impl Into<AnyPose>,
    ) -> Result<BodyId, Error> {
        self.add_with(model, world_from_body, BodyOptions::default())
    }

    /// [`SceneQuery::add`] with options.
    ///
    /// # Errors
    /// As [`SceneQuery::add`].
    pub fn add_with(
        &mut self,
        model: impl Into<Arc<Model>>,
        world_from_body: impl Into<AnyPose>,
        options: BodyOptions,
    ) -> Result<BodyId, Error> {
        let (model, world_from_body) = (model.into(), world_from_body.into());
        with_default(|| self.bodies.add(model, world_from_body, options))
    }

    /// Takes a body out and returns it. [`SceneQuery::hits`] and [`SceneQuery::last_contacts`] list nothing of it any more.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    ///
    /// # Complexity
    /// O(m log n) if m of n ignored pairs are of this body, amortised over the bodies that are removed. The next call of
    /// [`SceneQuery::hits`] or [`SceneQuery::last_contacts`] looks through the list once.
    pub fn remove(&mut self, id: BodyId) -> Result<Body, Error> {
        self.bodies.get(id)?;
        self.before_loss()?;
        self.nearest.remove(&id);
        self.bodies.remove(id)
    }

    /// To be called before a body or its mesh goes, of which the kept lists tell.
    fn before_loss(&mut self) -> Result<(), Error> {
        self.hits.before_loss()?;
        self.contacts.before_loss()
    }

    /// Moves a body to the pose `world_from_body`. In the pose that it has, to the bit, it does not move: a zero of the other
    /// sign is another number, as it is to [`Model::set_positions`].
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there, [`Error::Pose`] as for [`SceneQuery::add`].
    ///
    /// # Complexity
    /// O(log n) for n bodies.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (tile, mut scene) = (std::sync::Arc::new(tile), SceneQuery::new());
    /// # scene.add(tile.clone(), Pose::IDENTITY)?;
    /// let lid = scene.add(tile, Pose::IDENTITY)?;
    /// assert_eq!(scene.count()?, 1);
    /// scene.set_pose(lid, Pose::from_translation([0.0, 0.0, 0.1]))?;
    /// assert_eq!(scene.count()?, 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_pose(
        &mut self,
        id: BodyId,
        world_from_body: impl Into<AnyPose>,
    ) -> Result<(), Error> {
        let world_from_body = world_from_body.into();
        with_default(|| match self.bodies.get(id)?.pose().same_bits(&world_from_body) {
            true => Ok(()),
            false => self.bodies.change(id, |body| body.set_pose(world_from_body)),
        })
    }

    /// Gives a body another model, in the pose that it has. If the model holds what that of the body holds, as
    /// [`Model::stamp`] tells, nothing has changed. If it has another mesh, [`SceneQuery::hits`] and
    /// [`SceneQuery::last_contacts`] list nothing of the body any more until it is asked about again.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if the body is not there, [`Error::Pose`] if its pose takes the model out of range.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// let tile = |x| Model::new(vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]], vec![[0, 1, 2]]);
    /// let mut scene = SceneQuery::new();
    /// let (_, b) = (scene.add(tile(0.0)?, Pose::IDENTITY)?, scene.add(tile(0.5)?, Pose::IDENTITY)?);
    /// assert_eq!(scene.all()?.len(), 1);
    /// scene.set_model(b, tile(5.0)?)?;
    /// assert_eq!(scene.all()?.len(), 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_model(&mut self, id: BodyId, model: impl Into<Arc<Model>>) -> Result<(), Error> {
        let model = model.into();
        let (stamp, body) = (model.stamp(), self.bodies.get_mut(id)?);
        if body.model().stamp() == stamp {
            body.model = model;
            return Ok(());
        }
        if body.model().stamp().mesh() != stamp.mesh() {
            self.before_loss()?;
            return with_default(|| self.bodies.set_mesh(id, model));
        }
        with_default(|| {
            self.bodies.change(id, |body| {
                body.pose().check(model.bvh())?;
                body.model = model;
                body.reshaped();
                Ok(())
            })
        })
    }

    /// Moves the vertices of a body, given in its own frame, as [`Model::set_positions`] does, or on the
    /// threads of the executor. Positions that the body has, to the bit, move nothing.
    ///
    /// If the model is shared, with another body or a caller that has kept an [`Arc`] of it, it is copied
    /// first, which takes as long as the refit and its [`Model::bytes`] of memory; from then on this body
    /// has its own.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if the body is not there, [`Error::Mesh`] if a coordinate is not finite or
    /// the number of vertices differs or they are not in the precision of the model, [`Error::Pose`] if its pose takes a vertex out of range.
    pub fn set_positions<S: Scalar>(
        &mut self,
        id: BodyId,
        positions: &[[S; 3]],
    ) -> Result<(), Error> {
        if S::is_same(self.bodies.get(id)?.model(), positions) {
            return Ok(());
        }
        let executor = self.history.executor();
        with_default(|| {
            self.bodies.change(id, |body| {
                let checked = S::check(body.model(), positions, ONE_THREAD)?;
                body.pose().check_bounds(&S::bounds(positions, &checked))?;
                let model = Model::make_mut(&mut body.model)?;
                executor.refit_checked(model, positions, checked);
                body.reshaped();
                Ok(())
            })
        })
    }

    /// Gives a body other options.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{BodyOptions, Groups, Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let tile = std::sync::Arc::new(tile);
    /// let mut scene = SceneQuery::new();
    /// let bodies = [0; 2].map(|_| scene.add(tile.clone(), Pose::IDENTITY));
    /// assert_eq!(scene.count()?, 1);
    /// for body in bodies {
    ///     let groups = Groups { memberships: 0b1, filter: 0b10 };
    ///     scene.set_options(body?, BodyOptions { groups, ..BodyOptions::default() })?;
    /// }
    /// assert_eq!(scene.count()?, 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_options(&mut self, id: BodyId, options: BodyOptions) -> Result<(), Error> {
        let body = self.bodies.get_mut(id)?;
        if body.options == (BodyOptions { user_data: body.options.user_data, ..options }) {
            // A number of the caller's changes no answer.
            body.options = options;
            return Ok(());
        }
        self.bodies.change(id, |body| {
            body.options = options;
            Ok(())
        })
    }

    /// Ignores two bodies, as the links of a joint that overlap by design, or no longer.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if one of them is not there.
    ///
    /// # Complexity
    /// O(log n) for n ignored pairs.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let link = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let (link, mut arm) = (std::sync::Arc::new(link), SceneQuery::new());
    /// let (upper, lower) = (arm.add(link.clone(), Pose::IDENTITY)?, arm.add(link, Pose::IDENTITY)?);
    /// assert_eq!(arm.count()?, 1);
    /// arm.ignore(upper, lower, true)?;
    /// assert_eq!(arm.count()?, 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn ignore(&mut self, a: BodyId, b: BodyId, ignored: bool) -> Result<(), Error> {
        self.bodies.ignore([a, b], ignored)
    }

    /// The pairs of bodies that are ignored, in ascending order.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let tile = std::sync::Arc::new(tile);
    /// let mut scene = SceneQuery::new();
    /// let (a, b) = (scene.add(tile.clone(), Pose::IDENTITY)?, scene.add(tile, Pose::IDENTITY)?);
    /// scene.ignore(b, a, true)?;
    /// assert!(scene.ignored().eq([[a, b]]));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn ignored(&self) -> impl Iterator<Item = [BodyId; 2]> {
        self.bodies.ignored()
    }

    /// Breaks a body into one for each part, that is each value of `part_of` over its triangles. The
    /// pieces stay where they are, in f32 or f64 as the body was, with the same options; their ids follow all others, in ascending
    /// order of the parts. Nobody ignores them.
    ///
    /// The triangles of a piece keep their order and are numbered anew, as [`Piece::triangles`] tells;
    /// its vertices are those that its triangles use, so that one on the cut is doubled. The body itself
    /// is gone afterwards, even if there is one piece, or none because there was no triangle.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if the body is not there; [`Error::Pose`] if its pose takes a piece out of range, whose box may reach farther
    /// than that of the whole by its rounding; [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n log n) for n triangles, all of whose BVHs are built anew.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Pose, SceneQuery};
    /// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    /// let square = Model::new(points, vec![[0, 1, 2], [1, 3, 2]])?;
    /// let mut scene = SceneQuery::new();
    /// let whole = scene.add(square, Pose::IDENTITY)?;
    /// let pieces = scene.split(whole, |triangle| 1 - triangle)?;
    /// assert_eq!(pieces[0].triangles, [1]);
    /// assert_eq!(scene.body(pieces[0].body)?.model().mesh().triangles(), [[0, 1, 2]]);
    /// // They touch along the cut.
    /// assert_eq!(scene.count()?, 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn split(&mut self, id: BodyId, part_of: impl Fn(u32) -> u32) -> Result<Vec<Piece>, Error> {
        let body = self.bodies.get(id)?;
        let (model, pose) = (body.model().clone(), body.pose());
        let options = body.options();
        let mut cutter = Cutter::new(&model);
        let parts = parts(model.mesh().triangles().len() as u32, part_of);
        let models = parts.iter().map(|(_, triangles)| cutter.cut(triangles));
        let models: Vec<Model> = models.collect::<Result<_, _>>()?;
        models.iter().try_for_each(|model| with_default(|| pose.check(model.bvh())))?;
        self.bodies.reserve(models.len())?;
        self.remove(id)?;
        let pieces = parts.into_iter().zip(models).map(|((part, triangles), model)| {
            let body = with_default(|| self.bodies.add(model.into(), pose, options))?;
            Ok(Piece { body, part, triangles })
        });
        pieces.collect()
    }

    /// A body.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    pub fn body(&self, id: BodyId) -> Result<&Body, Error> {
        self.bodies.get(id)
    }

    /// The bodies in the order in which they were added.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter()
    }

    /// How many bodies there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there is no body.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
