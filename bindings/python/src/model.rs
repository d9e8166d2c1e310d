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
        Self::made(py, || match narrowed(&positions) {
            Some(narrow) => build(narrow, triangles, on),
            None => pfront::Model::from_f64(positions, triangles),
        })
    }

    /// The same faces with their vertices elsewhere, by a refit of the BVH of this one. One whose positions are in
    /// float32 is built anew if those are not.
    fn with_vertices(
        &self,
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        on: &Executor,
    ) -> PyResult<Self> {
        let own = &self.0;
        if let Ok(vertices) = vertices.extract::<PyReadonlyArrayDyn<'_, f32>>() {
            let positions = triples(&vertices)?;
            drop(vertices);
            return Self::made(py, || {
                if own.is_f64() {
                    let wide: Vec<_> = positions.iter().map(|p| p.map(f64::from)).collect();
                    return refit_f64(own, &wide);
                }
                refit(own, &positions, on)
            });
        }
        let vertices = vertices.extract::<PyReadonlyArrayDyn<'_, f64>>()?;
        let positions = triples(&vertices)?;
        drop(vertices);
        Self::made(py, || {
            if own.is_f64() {
                return refit_f64(own, &positions);
            }
            match narrowed(&positions) {
                Some(narrow) => refit(own, &narrow, on),
                // Its faces are checked against the new positions.
                None => pfront::Model::from_f64(positions, own.mesh().triangles().to_vec()),
            }
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
                let positions = mesh.shadow();
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
        (mesh.vertex_count(), mesh.triangles().len())
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

/// Positions in float32, if that holds them all to the bit.
fn narrowed(positions: &[[f64; 3]]) -> Option<Vec<[f32; 3]>> {
    let is_f32 = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
    let all = positions.as_flattened().iter().all(is_f32);
    all.then(|| positions.iter().map(|p| p.map(|x| x as f32)).collect())
}

fn refit(
    own: &pfront::Model,
    positions: &[[f32; 3]],
    on: &Executor,
) -> Result<pfront::Model, Error> {
    let mut model = own.clone();
    match on.pool() {
        Some(pool) if own.mesh().triangles().len() >= MANY => {
            pool.install(|| model.set_positions_with_threads(positions))?;
        }
        _ => model.set_positions(positions)?,
    }
    Ok(model)
}

fn refit_f64(own: &pfront::Model, positions: &[[f64; 3]]) -> Result<pfront::Model, Error> {
    let mut model = own.clone();
    model.set_positions_f64(positions)?;
    Ok(model)
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
