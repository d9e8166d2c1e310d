//! Hits of scenes.

use super::id::BodyId;
use crate::TrianglePair;

/// Two triangles of different bodies that meet. The order is that of `bodies`, then `pair`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SceneHit {
    /// The bodies, the one that was added first before the other.
    pub bodies: [BodyId; 2],
    /// A triangle of the first body and one of the second.
    pub pair: TrianglePair,
}
