//! Checks of positions, and the errors of a mesh.

use crate::environment;
use crate::scalar::LIMIT;
use glam::DVec3;

/// The most triangles one mesh may have: 2^31 − 1, so that a node index of its BVH and the sum of two triangle counts
/// fit in a `u32`, and a triangle index shares a `u64` with a 33-bit Morton code.
pub const MAX_TRIANGLES: usize = (1 << 31) - 1;

/// Vertices that are checked between two branches, so that the check compiles to vector instructions. A policy: many
/// of these, and few to go through again where one is at fault.
const AT_ONCE: usize = 256;

pub(super) fn check_environment() -> Result<(), MeshError> {
    if environment::is_default() { Ok(()) } else { Err(MeshError::FloatEnvironment) }
}

pub(super) fn check_positions(positions: &[[f32; 3]]) -> Result<(), MeshError> {
    check_environment()?;
    for (chunk, first) in positions.chunks(AT_ONCE).zip((0..).step_by(AT_ONCE)) {
        if !chunk.as_flattened().iter().fold(true, |well, x| well & x.is_finite()) {
            let at_fault = chunk.iter().position(|p| !p.iter().all(|x| x.is_finite()));
            return Err(MeshError::NonFinite { vertex: first + at_fault.unwrap_or(0) });
        }
    }
    Ok(())
}

/// The position of a vertex, if it is in range.
pub(crate) fn check_position(vertex: usize, position: [f64; 3]) -> Result<DVec3, MeshError> {
    let p = DVec3::from_array(position);
    if p.abs().cmple(DVec3::splat(LIMIT)).all() {
        Ok(p)
    } else if p.is_finite() {
        Err(MeshError::Range { vertex })
    } else {
        Err(MeshError::NonFinite { vertex })
    }
}

pub(super) fn same_length(expected: usize, found: usize) -> Result<(), MeshError> {
    if found == expected { Ok(()) } else { Err(MeshError::VertexCount { expected, found }) }
}

/// Positions and indices that are not a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a NaN or infinite coordinate")]
    NonFinite {
        /// The vertex with that coordinate.
        vertex: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// The triangle at fault.
        triangle: usize,
        /// The index it holds.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A coordinate in f64 is beyond ±2^125, the limit of poses.
    #[error("vertex {vertex} has a coordinate beyond ±2^125")]
    Range {
        /// The vertex with that coordinate.
        vertex: usize,
    },
    /// A position of a shadow is not that of the mesh in f64 minus its origin.
    #[error("vertex {vertex} of the shadow is not its position in f64 minus the origin")]
    Shadow {
        /// The vertex.
        vertex: usize,
    },
    /// Positions in f32 were given for a mesh in f64, or in f64 for one in f32.
    #[error("positions were given in f32 for a mesh in f64, or in f64 for one in f32")]
    OtherPrecision,
    /// More triangles than [`MAX_TRIANGLES`].
    #[error("{triangles} triangles are more than the {MAX_TRIANGLES} supported")]
    TooManyTriangles {
        /// The number of triangles.
        triangles: usize,
    },
    /// New positions for a deforming mesh differ in number.
    #[error("{found} positions were given for a mesh of {expected} vertices")]
    VertexCount {
        /// The number of vertices of the mesh.
        expected: usize,
        /// The number of positions given.
        found: usize,
    },
    /// The calling thread flushes subnormal numbers or does not round to nearest, so that answers could
    /// be wrong. Restore the default environment before each call: MXCSR 0x1f80 on x86, FPCR 0 on Arm.
    #[error(
        "this thread flushes subnormal numbers or does not round to nearest: \
         set MXCSR to 0x1f80 (x86) or FPCR to 0 (Arm) before calling"
    )]
    FloatEnvironment,
}
