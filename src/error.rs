//! One error for everything a call can refuse.

use pfront_core::pose::PoseError;
use pfront_core::{CapacityError, MeshError};

/// Why a call could not answer. Each variant names the vertex, triangle, entry or size at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The positions and indices are not a mesh.
    #[error("not a mesh: {0}")]
    Mesh(#[from] MeshError),
    /// The second mesh cannot be posed so.
    #[error("pose refused: {0}")]
    Pose(#[from] PoseError),
    /// A buffer of the core was too small.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
}
