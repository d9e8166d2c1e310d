//! Meshes with positions in f64.
//!
//! A mesh in f64 is an ordinary f32 mesh, its *shadow*, and the exact positions beside. The shadow is the positions minus an
//! origin, the middle of their box, rounded to f32: a vertex of it is off by less than 2^-23 of the extent of the mesh,
//! wherever in the world that is. All that only has to be conservative reads the shadow: builds, refits, boxes, and the
//! filter in vector lanes, which allows for its error. The positions decide.

use super::check::{check_environment, check_position, same_length};
use super::{Mesh, MeshError};
use glam::{DVec3, Vec3};

impl<'a> Mesh<'a> {
    /// Checks a mesh whose positions are in f64, and fills its shadow: as many positions in f32, on which queries do what
    /// need not be exact. The pairs that they find are those of the positions given.
    ///
    /// # Errors
    /// As [`Mesh::new`]; [`MeshError::Range`] if a coordinate is beyond ±2^125; [`MeshError::VertexCount`] if `shadow` has
    /// not as many positions.
    ///
    /// # Complexity
    /// O(vertices + triangles).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// // A metre in a coordinate system of the earth: f32 knows such positions to half a metre.
    /// let points = [[500_000.1, 5_000_000.2, 0.0], [500_001.1, 5_000_000.2, 0.0], [500_000.1, 5_000_001.2, 0.0]];
    /// let mut shadow = [[0.0; 3]; 3];
    /// let mesh = Mesh::from_f64(&points, &[[0, 1, 2]], &mut shadow)?;
    /// assert_eq!(mesh.positions_f64(), Some(&points[..]));
    /// assert!((mesh.shadow()[1][0] - 0.5).abs() < 1e-6);
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn from_f64(
        positions: &'a [[f64; 3]],
        triangles: &'a [[u32; 3]],
        shadow: &'a mut [[f32; 3]],
    ) -> Result<Self, MeshError> {
        let origin = fill(shadow, positions, None)?;
        Ok(Self::new(shadow, triangles)?.with_origin(Some(positions), origin))
    }

    /// The same triangles over other positions in f64, as a deforming mesh has each frame. The origin of the shadow stays where
    /// it is as long as it is in their box.
    ///
    /// # Errors
    /// As [`Mesh::from_f64`]; [`MeshError::OtherPrecision`] if this mesh has positions in f32.
    ///
    /// # Complexity
    /// O(vertices).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// let (points, moved) = ([[0.1; 3]; 3], [[0.3; 3]; 3]);
    /// let (mut shadow, mut after) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    /// let mesh = Mesh::from_f64(&points, &[[0, 1, 2]], &mut shadow)?;
    /// let mesh = mesh.with_positions_f64(&moved, &mut after)?;
    /// assert_eq!(mesh.origin(), [0.3; 3]);
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn with_positions_f64(
        self,
        positions: &'a [[f64; 3]],
        shadow: &'a mut [[f32; 3]],
    ) -> Result<Self, MeshError> {
        let Some(before) = self.origin else { return Err(MeshError::OtherPrecision) };
        same_length(self.vertex_count(), positions.len())?;
        let origin = fill(shadow, positions, Some(before))?;
        Ok(Self::new_unchecked(shadow, self.triangles).with_origin(Some(positions), origin))
    }

    /// The same mesh in f64: posed and decided there. Its positions stay those in f32, and take no memory in f64.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// let mesh = Mesh::new(&[[0.5; 3]; 3], &[[0, 1, 2]])?.widened();
    /// assert!(mesh.is_f64() && mesh.positions_f64().is_none());
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    #[must_use]
    pub fn widened(self) -> Self {
        if self.is_f64() { self } else { self.with_origin(None, DVec3::ZERO) }
    }

    /// Makes a mesh again of what [`Mesh::from_f64`] has checked and filled, and of its [`Mesh::origin`].
    ///
    /// Not `unsafe`: memory safety never depends on the arrays.
    ///
    /// # Panics and wrong answers
    /// With other arrays, queries may give wrong pairs or panic; they panic where `positions` are too few.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// let (points, triangles, mut shadow) = ([[0.1; 3]; 3], [[0, 1, 2]], [[0.0; 3]; 3]);
    /// let origin = Mesh::from_f64(&points, &triangles, &mut shadow)?.origin();
    /// let mesh = Mesh::from_f64_unchecked(&points, &shadow, origin, &triangles);
    /// assert_eq!(mesh.positions_f64(), Some(&points[..]));
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    #[must_use]
    pub fn from_f64_unchecked(
        positions: &'a [[f64; 3]],
        shadow: &'a [[f32; 3]],
        origin: [f64; 3],
        triangles: &'a [[u32; 3]],
    ) -> Self {
        debug_assert_eq!(
            positions.len(),
            shadow.len(),
            "one position in f64 for each of the shadow"
        );
        let origin = DVec3::from_array(origin);
        Self::new_unchecked(shadow, triangles).with_origin(Some(positions), origin)
    }

    /// [`Mesh::from_f64_unchecked`] of arrays that nobody has checked, such as those of a file; [`Mesh::widened`] if `positions`
    /// is empty.
    ///
    /// # Errors
    /// As [`Mesh::from_f64`]; [`MeshError::Shadow`] names the first vertex whose shadow is not its position minus `origin`.
    ///
    /// # Complexity
    /// O(vertices + triangles).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{Mesh, MeshError};
    /// let (points, triangles, shadow) = ([[2.5; 3]; 3], [[0, 1, 2]], [[0.5; 3]; 3]);
    /// assert!(Mesh::from_f64_parts(&points, &shadow, [2.0; 3], &triangles)?.is_f64());
    /// let wrong = Mesh::from_f64_parts(&points, &shadow, [1.0; 3], &triangles);
    /// assert_eq!(wrong.err(), Some(MeshError::Shadow { vertex: 0 }));
    /// # Ok::<(), MeshError>(())
    /// ```
    pub fn from_f64_parts(
        positions: &'a [[f64; 3]],
        shadow: &'a [[f32; 3]],
        origin: [f64; 3],
        triangles: &'a [[u32; 3]],
    ) -> Result<Self, MeshError> {
        let origin = DVec3::from_array(origin);
        let positions = Some(positions).filter(|positions| !positions.is_empty());
        if let Some(positions) = positions {
            same_length(shadow.len(), positions.len())?;
        }
        let mesh = Self::new(shadow, triangles)?.with_origin(positions, origin);
        for (vertex, &shadow) in shadow.iter().enumerate() {
            let position = check_position(vertex, mesh.position_f64(vertex as u32))?;
            let is_near = check_position(vertex, origin.to_array()).is_ok();
            if !is_near || (position - origin).as_vec3() != Vec3::from_array(shadow) {
                return Err(MeshError::Shadow { vertex });
            }
        }
        Ok(mesh)
    }

    fn with_origin(self, positions_f64: Option<&'a [[f64; 3]]>, origin: DVec3) -> Self {
        Self { positions_f64, origin: Some(origin), ..self }
    }
}

/// Fills a shadow, and returns its origin: the one given, if it is in the box of the positions, else the middle of that box.
fn fill(
    shadow: &mut [[f32; 3]],
    positions: &[[f64; 3]],
    origin: Option<DVec3>,
) -> Result<DVec3, MeshError> {
    check_environment()?;
    same_length(positions.len(), shadow.len())?;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (vertex, &position) in positions.iter().enumerate() {
        let p = check_position(vertex, position)?;
        (low, high) = (low.min(p), high.max(p));
    }
    let middle = if positions.is_empty() { DVec3::ZERO } else { low * 0.5 + high * 0.5 };
    let is_inside = |p: &DVec3| p.cmpge(low).all() && p.cmple(high).all();
    let origin = origin.filter(is_inside).unwrap_or(middle);
    for (shadow, &position) in shadow.iter_mut().zip(positions) {
        *shadow = (DVec3::from_array(position) - origin).as_vec3().to_array();
    }
    Ok(origin)
}
