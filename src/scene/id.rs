//! Names of bodies.

use std::fmt;

/// Names a body of one scene for good: no id is ever used again. Ids ascend in the order of adding.
///
/// It means nothing in another scene, nor in one that is filled again from a file: store [`BodyOptions::user_data`](crate::BodyOptions::user_data) there.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId(pub(super) u64);

impl BodyId {
    /// Returns the id as a number, for what knows numbers only, as other languages and files do.
    ///
    /// # Examples
    /// ```
    /// # use pfront::{BodyId, Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut scene = SceneQuery::new();
    /// let body = scene.add(tile, Pose::IDENTITY)?;
    /// assert_eq!(BodyId::from_bits(body.to_bits()), body);
    /// assert!(scene.body(BodyId::from_bits(99)).is_err());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[must_use]
    pub const fn to_bits(self) -> u64 {
        self.0
    }

    /// The id that [`BodyId::to_bits`] makes this number of; any other number is the id of no body.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }
}

impl fmt::Display for BodyId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {}", self.0)
    }
}
