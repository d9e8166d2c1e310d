//! A borrowed triangle mesh, checked once.
//!
//! All other modules rely on a [`Mesh`]: indices are in range and coordinates finite, so no traversal checks either
//! again.

mod check;
#[cfg(feature = "f64")]
mod shadow;
#[cfg(all(test, feature = "f64"))]
mod tests;

pub(crate) use check::check_position;
pub use check::{MAX_TRIANGLES, MeshError};

use crate::aabb::Bounds;
use crate::scalar::IN_F64;
use check::{check_positions, same_length};
use glam::{DVec3, Vec3A};

/// Corner positions of one triangle, in the units of the mesh.
pub type Triangle = [[f32; 3]; 3];

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
    /// Where the shadow of a mesh in f64 has its origin.
    origin: Option<DVec3>,
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
        if self.positions_f64.is_some() {
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
        Self { shadow: positions, triangles, positions_f64: None, origin: None }
    }

    /// The vertex positions, if they are in f32: `None` if those that decide are
    /// [in f64](Mesh::positions_f64).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// let points = [[0.1; 3]; 3];
    /// let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// assert!(mesh.positions() == Some(&points[..]) && mesh.positions_f64().is_none());
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

    /// Whether it is in f64: posed and decided there, whatever the pose and the other mesh.
    #[must_use]
    pub fn is_f64(self) -> bool {
        IN_F64 && self.origin.is_some()
    }

    /// The positions in f64; `None` if f32 holds them.
    #[must_use]
    pub fn positions_f64(self) -> Option<&'a [[f64; 3]]> {
        self.positions_f64
    }

    /// The position that the shadow has at zero; that is zero in a mesh without one.
    #[must_use]
    pub fn origin(self) -> [f64; 3] {
        self.origin.map_or([0.0; 3], |origin| origin.to_array())
    }

    /// The same positions with other triangles, whose indices are in range.
    #[cfg(feature = "relation")]
    pub(crate) fn with_triangles(self, triangles: &'a [[u32; 3]]) -> Self {
        Self { triangles, ..self }
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
        let [a, b, c] = self.triangles[index as usize];
        [self.shadow[a as usize], self.shadow[b as usize], self.shadow[c as usize]]
    }

    /// The corners of a triangle in f64, exact in a mesh of either kind.
    pub(crate) fn triangle_f64(self, index: u32) -> [[f64; 3]; 3] {
        self.triangles[index as usize].map(|vertex| self.position_f64(vertex))
    }

    /// The position of a vertex in f64, exact in a mesh of either kind.
    pub(crate) fn position_f64(self, vertex: u32) -> [f64; 3] {
        match self.positions_f64 {
            Some(positions) => positions[vertex as usize],
            None => self.shadow[vertex as usize].map(f64::from),
        }
    }

    /// The box of triangle `index` of the shadow.
    #[inline]
    pub(crate) fn bounds(self, index: u32) -> Bounds {
        let [a, b, c] = self.shadow_triangle(index).map(Vec3A::from_array);
        Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
    }
}
