//! Hits of scenes.

use super::id::BodyId;
use crate::TrianglePair;

/// Two triangles of different bodies that meet, or of one that is asked about itself. The order is that of `bodies`, then `pair`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SceneHit {
    /// The bodies, the one that was added first before the other; twice the same if it meets itself.
    pub bodies: [BodyId; 2],
    /// A triangle of the first body and one of the second; of one body, the smaller number first.
    pub pair: TrianglePair,
}
