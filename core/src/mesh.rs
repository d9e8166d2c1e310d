//! A borrowed triangle mesh, checked once.
//!
//! All other modules rely on a [`Mesh`]: indices are in range and coordinates finite, so no traversal checks either
//! again.

mod exact;
#[cfg(test)]
mod tests;

pub(crate) use exact::check_position;
use exact::{Shadowed, same_length};

use crate::aabb::Bounds;
use crate::environment;
use crate::index::at;
use glam::Vec3A;

/// Corner positions of one triangle, in the units of the mesh.
pub type Triangle = [[f32; 3]; 3];

/// The most triangles one mesh may have: 2^31 − 1, so that a node index of its BVH and the sum of two triangle counts
/// fit in a `u32`, and a triangle index shares a `u64` with a 33-bit Morton code.
pub const MAX_TRIANGLES: usize = (1 << 31) - 1;

/// A triangle mesh borrowed from the caller and checked once, by [`Mesh::new`].
///
/// Copying is free (slices). Duplicate triangles, zero-area triangles, unreferenced vertices
/// and an empty mesh are all fine.
///
/// # Examples
/// ```
/// use pfront_core::Mesh;
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// assert_eq!(mesh.shadow_triangle(0)[1], [1.0, 0.0, 0.0]);
/// # Ok::<(), pfront_core::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// The positions in f32, or the shadow of those in f64.
    shadow: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    /// The positions in f64, if the shadow has others.
    positions_f64: Option<&'a [[f64; 3]]>,
    /// Set for a mesh in f64.
    shadowed: Option<Shadowed>,
}

impl<'a> Mesh<'a> {
    /// Checks every coordinate and every index.
    ///
    /// `positions` are `[x, y, z]`, `triangles` indices into `positions`. A mesh borrows this one layout: strided vertices
    /// and 16-bit indices have to be copied into it.
    ///
    /// # Errors
    /// [`MeshError`] names the first vertex or triangle at fault, or the calling thread's
    /// [floating-point environment](MeshError::FloatEnvironment).
    ///
    /// # Complexity
    /// O(vertices + triangles).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{Mesh, MeshError};
    /// let broken = Mesh::new(&[[0.0, f32::NAN, 0.0]], &[]);
    /// assert_eq!(broken.err(), Some(MeshError::NonFinite { vertex: 0 }));
    /// ```
    /// Flat arrays, and slices of vectors that bytemuck knows, are borrowed without a copy:
    /// ```
    /// use glam::Vec3;
    /// use pfront_core::Mesh;
    /// let (flat, indices) = ([0.0_f32; 9], [0_u32, 1, 2]);
    /// let mesh = Mesh::new(flat.as_chunks().0, indices.as_chunks().0)?;
    /// let vectors = [Vec3::X, Vec3::Y, Vec3::Z];
    /// let mesh = Mesh::new(bytemuck::cast_slice(&vectors), mesh.triangles())?;
    /// assert_eq!(mesh.shadow_triangle(0)[0], [1.0, 0.0, 0.0]);
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn new(positions: &'a [[f32; 3]], triangles: &'a [[u32; 3]]) -> Result<Self, MeshError> {
        if triangles.len() > MAX_TRIANGLES {
            return Err(MeshError::TooManyTriangles { triangles: triangles.len() });
        }
        check_positions(positions)?;
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&i| i as usize >= positions.len()) {
                let vertices = positions.len();
                return Err(MeshError::IndexOutOfRange { triangle, index, vertices });
            }
        }
        Ok(Self::new_unchecked(positions, triangles))
    }

    /// Returns the same triangles over other positions, as a deforming mesh has each frame.
    ///
    /// Only the positions are checked again.
    ///
    /// # Errors
    /// [`MeshError::NonFinite`], [`MeshError::VertexCount`] if the number of vertices differs,
    /// [`MeshError::OtherPrecision`] if this mesh has positions in f64, or [`MeshError::FloatEnvironment`].
    ///
    /// # Complexity
    /// O(vertices).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// let mesh = Mesh::new(&[[0.0; 3]; 3], &[[0, 1, 2]])?;
    /// let moved = [[1.0; 3]; 3];
    /// assert_eq!(mesh.with_positions(&moved)?.shadow_triangle(0)[0], [1.0; 3]);
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn with_positions(self, positions: &'a [[f32; 3]]) -> Result<Self, MeshError> {
        same_length(self.vertex_count(), positions.len())?;
        if self.positions_f64().is_some() {
            return Err(MeshError::OtherPrecision);
        }
        check_positions(positions)?;
        Ok(Self { shadow: positions, ..self })
    }

    /// Makes a mesh of arrays that [`Mesh::new`] has accepted before, without checking them again.
    ///
    /// Not `unsafe`: memory safety never depends on the arrays.
    ///
    /// # Panics and wrong answers
    /// With other arrays, queries may give wrong pairs or panic.
    ///
    /// # Complexity
    /// O(1).
    #[inline]
    #[must_use]
    pub fn new_unchecked(positions: &'a [[f32; 3]], triangles: &'a [[u32; 3]]) -> Self {
        Self { shadow: positions, triangles, positions_f64: None, shadowed: None }
    }

    /// The vertex positions, if they are in f32: `None` if those that decide are
    /// [in f64](Mesh::positions_f64).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// let (points, mut shadow) = ([[0.1_f64; 3]; 3], [[0.0_f32; 3]; 3]);
    /// let mesh = Mesh::from_f64(&points, &[[0, 1, 2]], &mut shadow)?;
    /// assert!(mesh.positions().is_none() && mesh.positions_f64().is_some());
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    #[must_use]
    pub fn positions(self) -> Option<&'a [[f32; 3]]> {
        self.positions_f64().is_none().then_some(self.shadow)
    }

    /// The shadow: the positions in f32, or, of positions in f64, these minus [`Mesh::origin`], rounded to f32. Builds and
    /// refits of a BVH read it, and all else that only has to be conservative. It decides nothing if there are positions in
    /// f64.
    #[must_use]
    pub fn shadow(self) -> &'a [[f32; 3]] {
        self.shadow
    }

    /// The number of vertices.
    #[must_use]
    pub fn vertex_count(self) -> usize {
        self.shadow.len()
    }

    /// The vertex indices of each triangle.
    #[must_use]
    pub fn triangles(self) -> &'a [[u32; 3]] {
        self.triangles
    }

    /// The corners of triangle `index` of the [shadow](Mesh::shadow): its corner positions, if these are in f32.
    ///
    /// # Panics
    /// If `index` is not below `self.triangles().len()`.
    #[inline]
    #[must_use]
    pub fn shadow_triangle(self, index: u32) -> Triangle {
        let [a, b, c] = *at(self.triangles, index);
        [*at(self.shadow, a), *at(self.shadow, b), *at(self.shadow, c)]
    }

    /// The box of triangle `index` of the shadow.
    #[inline]
    pub(crate) fn bounds(self, index: u32) -> Bounds {
        let [a, b, c] = self.shadow_triangle(index).map(Vec3A::from_array);
        Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
    }
}

/// Vertices that are checked between two branches, so that the check compiles to vector instructions.
const AT_ONCE: usize = 256;

fn check_environment() -> Result<(), MeshError> {
    if environment::is_default() { Ok(()) } else { Err(MeshError::FloatEnvironment) }
}

fn check_positions(positions: &[[f32; 3]]) -> Result<(), MeshError> {
    check_environment()?;
    for (chunk, first) in positions.chunks(AT_ONCE).zip((0..).step_by(AT_ONCE)) {
        if !chunk.as_flattened().iter().fold(true, |well, x| well & x.is_finite()) {
            let at_fault = chunk.iter().position(|p| !p.iter().all(|x| x.is_finite()));
            return Err(MeshError::NonFinite { vertex: first + at_fault.unwrap_or(0) });
        }
    }
    Ok(())
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
