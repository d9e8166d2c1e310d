//! Models that move.

use crate::environment::with_default;
use crate::memory::copy;
use crate::{AnyPose, Error, Model, Pose};
use pfront_core::bvh::{Refit, refit};
use pfront_core::bvtt::PosedBvh;
use pfront_core::motion::{MotionError, MovingBvh};
use pfront_core::{Bvh, Node};

/// A model at the start of a motion, the time 0, and at its end, the time 1: at rest, rigid in two poses, or deforming between two sets of
/// positions. Every corner goes in a straight line at constant speed. Motions that are asked about together share one world.
///
/// # Examples
/// ```
/// use pfront::{Model, Motion, PairQuery, Pose};
/// let wall = Model::new(vec![[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 2.0]], vec![[0, 1, 2]])?;
/// let bullet = Model::new(vec![[0.0; 3], [0.01, 0.0, 0.0], [0.0, 0.0, 0.01]], vec![[0, 1, 2]])?;
/// let at = |y| Pose::from_translation([0.0, y, 0.0]);
/// // In no frame it is in the wall, which it flies through.
/// let shot = Motion::new(&bullet, at(0.25), at(-0.75))?;
/// let (_, impact) = PairQuery::new().first_impact(&Motion::at_rest(&wall), &shot)?.expect("it hits");
/// assert!(impact.from <= 0.25 && 0.25 <= impact.to && impact.to - impact.from < 1e-6);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Motion<'m> {
    start: &'m Model,
    end: &'m Model,
    poses: [AnyPose; 2],
    /// The nodes at the end, if it is another model.
    nodes: Vec<Node>,
}

impl<'m> Motion<'m> {
    /// A model that stays where it is, its coordinates those of the world; for one elsewhere, [`Motion::new`] with one pose twice.
    #[must_use]
    pub fn at_rest(model: &'m Model) -> Self {
        let poses = [AnyPose::F32(Pose::IDENTITY); 2];
        Self { start: model, end: model, poses, nodes: Vec::new() }
    }

    /// A rigid body that goes from one pose to another in the world.
    ///
    /// Its corners go in straight lines, also if it turns: a corner at the distance r from the axis about which it turns by an angle θ is up
    /// to r θ²/8 away from where a turn at constant speed has it. Divide a motion that turns far, or ask within a distance: within
    /// (r_A θ_A² + r_B θ_B²)/8, with the largest r and the angle of each body, no contact of two turns at constant speed is missed, and none is
    /// earlier than said.
    ///
    /// # Errors
    /// [`Error::Pose`] if a pose is not finite or takes the model out of range.
    pub fn new(
        model: &'m Model,
        start: impl Into<AnyPose>,
        end: impl Into<AnyPose>,
    ) -> Result<Self, Error> {
        let poses = [start.into(), end.into()];
        with_default(|| poses.iter().try_for_each(|pose| pose.check(model.bvh())))?;
        Ok(Self { poses, ..Self::at_rest(model) })
    }

    /// A deforming mesh that goes from the positions of one model to those of another with the same triangles, both in the world.
    ///
    /// # Errors
    /// [`Error::Motion`] names the first triangle that differs; [`Error::Memory`] if there is none for the nodes at the end.
    ///
    /// # Complexity
    /// O(triangles): a refit.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, Motion, SelfQuery};
    /// let sheets = |gap| {
    ///     let sheet = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    ///     Model::new([sheet(0.0), sheet(gap)].concat(), vec![[0, 1, 2], [3, 4, 5]])
    /// };
    /// // They change sides, and intersect in neither frame.
    /// let (before, after) = (sheets(0.5)?, sheets(-0.5)?);
    /// let mut query = SelfQuery::new();
    /// assert_eq!(query.count(&before)? + query.count(&after)?, 0);
    /// assert_eq!(query.impacts(&Motion::between(&before, &after)?)?.len(), 1);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn between(start: &'m Model, end: &'m Model) -> Result<Self, Error> {
        with_default(|| {
            let (of_start, of_end) = (start.mesh().triangles(), end.mesh().triangles());
            let differs = of_start.iter().zip(of_end).position(|(p, q)| p != q);
            let shorter = of_start.len().min(of_end.len());
            if let Some(triangle) = differs.or((of_start.len() != of_end.len()).then_some(shorter))
            {
                return Err(MotionError::Triangle { triangle }.into());
            }
            let bvh = start.bvh();
            let mut nodes = copy(bvh.nodes())?;
            refit(end.mesh(), &mut nodes, bvh.order(), Refit::default())?;
            Ok(Self { end, nodes, ..Self::at_rest(start) })
        })
    }

    pub(crate) fn bvh(&self) -> MovingBvh<'_> {
        let start = self.start.bvh();
        let end = match std::ptr::eq(self.start, self.end) {
            true => start,
            false => Bvh::new_unchecked(self.end.mesh(), &self.nodes, start.order()),
        };
        let place = |pose: &AnyPose, bvh| -> PosedBvh<'_> { pose.place(bvh) };
        let [from, to] = &self.poses;
        // `between` has compared the triangles, and refitted the same nodes.
        MovingBvh::new_unchecked(place(from, start), place(to, end))
    }
}
