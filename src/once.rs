//! Questions that are asked once, on the calling thread, without a query to keep.

use crate::memory::copy;
use crate::{AnyPose, Error, Gap, Model, PairQuery, SelfQuery, TrianglePair};

/// All intersecting pairs of two models, sorted, the second in the pose `a_from_b`.
///
/// A [`PairQuery`] that is kept answers the next question sooner, on any [`Executor`](crate::Executor), and without allocating.
///
/// # Errors
/// [`Error::Pose`] if the pose is not finite or takes `b` out of range; [`Error::Memory`] if the list does not fit into memory.
///
/// # Examples
/// ```
/// use pfront::{Model, Pose, TrianglePair};
/// let floor = Model::new(vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], vec![[0, 1, 2]])?;
/// let blade = Model::new(vec![[1.0, 1.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0]], vec![[0, 1, 2]])?;
/// assert_eq!(pfront::pairs(&floor, &blade, Pose::IDENTITY)?, [TrianglePair { a: 0, b: 0 }]);
/// assert!(pfront::any(&floor, &blade, Pose::from_translation([0.0, 0.0, 2.0]))?.is_none());
/// # Ok::<(), pfront::Error>(())
/// ```
pub fn pairs(
    a: &Model,
    b: &Model,
    a_from_b: impl Into<AnyPose>,
) -> Result<Vec<TrianglePair>, Error> {
    copy(PairQuery::new().all(a, b, a_from_b)?)
}

/// Some intersecting pair of two models, if there is one; stops at the first.
///
/// # Errors
/// [`Error::Pose`] if the pose is not finite or takes `b` out of range.
///
/// # Examples
/// ```
/// # use pfront::{Model, Pose};
/// # let model = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
/// assert!(pfront::any(&model, &model, Pose::IDENTITY)?.is_some());
/// # Ok::<(), pfront::Error>(())
/// ```
pub fn any(
    a: &Model,
    b: &Model,
    a_from_b: impl Into<AnyPose>,
) -> Result<Option<TrianglePair>, Error> {
    PairQuery::new().any(a, b, a_from_b)
}

/// The number of intersecting pairs of two models.
///
/// # Errors
/// As [`any`].
///
/// # Examples
/// ```
/// # use pfront::{Model, Pose};
/// # let model = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
/// assert_eq!(pfront::count(&model, &model, Pose::IDENTITY)?, 1);
/// # Ok::<(), pfront::Error>(())
/// ```
pub fn count(a: &Model, b: &Model, a_from_b: impl Into<AnyPose>) -> Result<u64, Error> {
    PairQuery::new().count(a, b, a_from_b)
}

/// The smallest distance of two models in the frame of `a`, 0 if they intersect; `None` if one has no triangles.
///
/// # Errors
/// As [`any`].
///
/// # Examples
/// ```
/// # use pfront::{Model, Pose};
/// # let model = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
/// let gap = pfront::distance(&model, &model, Pose::IDENTITY)?.expect("both have triangles");
/// assert_eq!(gap.interval, [0.0; 2]);
/// # Ok::<(), pfront::Error>(())
/// ```
pub fn distance(a: &Model, b: &Model, a_from_b: impl Into<AnyPose>) -> Result<Option<Gap>, Error> {
    PairQuery::new().distance(a, b, a_from_b)
}

/// All pairs of triangles of one model that intersect, sorted, `a` before `b`. Vertices and edges that
/// two triangles share by index do not count.
///
/// # Errors
/// [`Error::Memory`] if the list does not fit into memory.
///
/// # Examples
/// ```
/// use pfront::{Model, TrianglePair};
/// let positions = vec![
///     [0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0],
///     [1.0, 1.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0],
/// ];
/// let model = Model::new(positions, vec![[0, 1, 2], [3, 4, 5]])?;
/// assert_eq!(pfront::self_pairs(&model)?, [TrianglePair { a: 0, b: 1 }]);
/// # Ok::<(), pfront::Error>(())
/// ```
pub fn self_pairs(model: &Model) -> Result<Vec<TrianglePair>, Error> {
    copy(SelfQuery::new().all(model)?)
}
