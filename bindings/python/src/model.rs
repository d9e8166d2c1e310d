//! Models: meshes with their BVHs.

use crate::arrays::{table, triples};
use crate::errors::exception;
use crate::executor::Executor;
use numpy::PyReadonlyArrayDyn;
use pfront::{BuildOptions, Error};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::Arc;

/// From so many triangles on, threads pay for a build.
const MANY: usize = 50_000;

/// A mesh and its BVH, which never change.
#[pyclass(frozen, module = "pfront._pfront")]
pub struct Model(pub(crate) Arc<pfront::Model>);

#[pymethods]
impl Model {
    /// A model of float32 positions.
    #[staticmethod]
    fn from_f32(
        py: Python<'_>,
        vertices: PyReadonlyArrayDyn<'_, f32>,
        faces: PyReadonlyArrayDyn<'_, u32>,
        on: &Executor,
    ) -> PyResult<Self> {
        let (positions, triangles) = (triples(&vertices)?, triples(&faces)?);
        drop((vertices, faces));
        Self::made(py, || build(positions, triangles, on))
    }

    /// A model of float64 positions, or of the same in float32 if that holds them all.
    #[staticmethod]
    fn from_f64(
        py: Python<'_>,
        vertices: PyReadonlyArrayDyn<'_, f64>,
        faces: PyReadonlyArrayDyn<'_, u32>,
        on: &Executor,
    ) -> PyResult<Self> {
        let (positions, triangles) = (triples(&vertices)?, triples(&faces)?);
        drop((vertices, faces));
        Self::made(py, || {
            let is_f32 = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
            if positions.as_flattened().iter().all(is_f32) {
                let narrow = positions.iter().map(|p| p.map(|x| x as f32)).collect();
                return build(narrow, triangles, on);
            }
            pfront::Model::from_f64(positions, triangles)
        })
    }

    /// A model out of the bytes of a `.pfb`.
    #[staticmethod]
    fn from_blob(py: Python<'_>, bytes: PyReadonlyArrayDyn<'_, u8>) -> PyResult<Self> {
        let bytes = crate::arrays::numbers(&bytes)?;
        Self::made(py, || pfront::Model::from_blob(&bytes))
    }

    /// The bytes of a `.pfb`.
    fn to_blob<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.0.to_blob()).map_err(|error| exception(py, error, None))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A copy of the positions.
    fn vertices(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mesh = self.0.mesh();
        match mesh.positions_f64().filter(|_| self.0.is_f64()) {
            Some(positions) => table(py, positions.as_flattened().to_vec(), positions.len(), 3),
            None => {
                let positions = mesh.positions();
                table(py, positions.as_flattened().to_vec(), positions.len(), 3)
            }
        }
    }

    /// A copy of the corners of triangles.
    fn faces(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let triangles = self.0.mesh().triangles();
        table(py, triangles.as_flattened().to_vec(), triangles.len(), 3)
    }

    /// The numbers of vertices and faces.
    fn counts(&self) -> (usize, usize) {
        let mesh = self.0.mesh();
        (mesh.positions().len(), mesh.triangles().len())
    }

    /// Whether positions are in float64.
    fn is_f64(&self) -> bool {
        self.0.is_f64()
    }

    /// Bytes of memory.
    fn nbytes(&self) -> usize {
        self.0.bytes()
    }
}

impl Model {
    fn made(
        py: Python<'_>,
        make: impl FnOnce() -> Result<pfront::Model, Error> + Send,
    ) -> PyResult<Self> {
        let model = py.detach(make).map_err(|error| exception(py, error, None))?;
        Ok(Self(Arc::new(model)))
    }
}

fn build(
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    on: &Executor,
) -> Result<pfront::Model, Error> {
    match on.pool() {
        Some(pool) if triangles.len() >= MANY => pool.install(|| {
            pfront::Model::new_with_threads(positions, triangles, BuildOptions::default())
        }),
        _ => pfront::Model::new(positions, triangles),
    }
}
