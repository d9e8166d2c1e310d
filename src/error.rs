//! One error for everything a call can refuse.

use crate::BodyId;
use pfront_blob::BlobError;
use pfront_core::motion::MotionError;
use pfront_core::pose::PoseError;
use pfront_core::relation::NotSolid;
use pfront_core::{CapacityError, DistanceError, MeshError};

/// Why a call could not answer. Each variant names the vertex, triangle, entry or size at fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The positions and indices are not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Bytes are no blob, or the BVH in it is none of its mesh.
    #[error(transparent)]
    Blob(BlobError),
    /// A mesh cannot be posed so.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// Two models are not the start and the end of one motion.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A distance within which pairs are asked for is NaN, infinite or negative.
    #[error(transparent)]
    Distance(#[from] DistanceError),
    /// A mesh is no solid.
    #[error(transparent)]
    Solid(#[from] NotSolid),
    /// A body is no longer in the scene.
    #[error("{id} is not in the scene; it has been removed or split")]
    StaleBody {
        /// The body asked for.
        id: BodyId,
    },
    /// A body is given more than one end of a motion.
    #[error("{id} is given two ends of its motion")]
    TwoEnds {
        /// The first such body.
        id: BodyId,
    },
    /// A question of a batch that asks for distances is about a model and itself.
    #[error(
        "question {question} of the batch is about a model and itself, between which there is no distance"
    )]
    NotAPair {
        /// The first such question.
        question: usize,
    },
    /// A buffer of the core was too small.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
    /// An answer or a mesh does not fit into memory. Nothing has changed; the call can be made again.
    #[error("no memory for a list of {needed} bytes")]
    Memory {
        /// The bytes of the list that could not grow.
        needed: usize,
    },
    /// A ticket was cancelled, or the flag of [`Executor::with_cancel`](crate::Executor::with_cancel) was set.
    #[error("the ticket or the query was cancelled")]
    Cancelled,
    /// A ticket was read again.
    #[error("the ticket has been read; its answers are handed out once")]
    AlreadyRead,
    /// A thread panicked while it answered a ticket.
    #[error("a thread panicked while it answered the ticket")]
    Panicked,
    /// A GPU refused or failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(crate::gpu::GpuError),
}

#[cfg(feature = "gpu")]
impl From<crate::gpu::GpuError> for Error {
    fn from(error: crate::gpu::GpuError) -> Self {
        match error {
            crate::gpu::GpuError::Memory { needed } => Self::Memory { needed },
            crate::gpu::GpuError::Cancelled => Self::Cancelled,
            error => Self::Gpu(error),
        }
    }
}

impl From<BlobError> for Error {
    fn from(error: BlobError) -> Self {
        match error {
            BlobError::Mesh(error) => Self::Mesh(error),
            BlobError::Capacity(error) => Self::Capacity(error),
            error => Self::Blob(error),
        }
    }
}
