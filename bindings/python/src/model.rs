//! Models: meshes with their BVHs.

use crate::arrays::{rows, triples};
use crate::errors::{exception, not_solid};
use crate::executor::Executor;
use crate::lock::lock;
use crate::memory;
use crate::threads::{apart, heard};
use numpy::PyReadonlyArrayDyn;
use pfront::{BuildOptions, Error, Scalar, Solid};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::{Arc, Mutex};

/// From so many triangles on, a build takes longer than signals may wait.
pub(crate) const MANY: usize = 50_000;
/// Bytes of a blob that are read or written on a thread of their own.
const LARGE: usize = 4 << 20;

/// A mesh and its BVH, which never change, and what has to be known of it as a solid, once that was asked for.
#[pyclass(frozen, module = "pfront._pfront")]
pub struct Model(pub(crate) Arc<pfront::Model>, Mutex<Option<Arc<Solid>>>);

impl From<Arc<pfront::Model>> for Model {
    fn from(model: Arc<pfront::Model>) -> Self {
        Self(model, Mutex::default())
    }
}

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
        let (is_long, cpu) = on.cpu_for(py, triangles.len());
        Self::made(py, Some(on), is_long, move || {
            cpu.build(positions, triangles, BuildOptions::default())
        })
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
        let (is_long, cpu) = on.cpu_for(py, triangles.len());
        Self::made(py, Some(on), is_long, move || match narrowed(&positions)? {
            Some(narrow) => cpu.build(narrow, triangles, BuildOptions::default()),
            None => cpu.build(positions, triangles, BuildOptions::default()),
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
        let own = self.0.clone();
        let (is_long, cpu) = on.cpu_for(py, own.mesh().triangles().len());
        if let Ok(vertices) = vertices.extract::<PyReadonlyArrayDyn<'_, f32>>() {
            let positions = triples(&vertices)?;
            drop(vertices);
            return Self::made(py, Some(on), is_long, move || {
                if own.is_f64() {
                    let wide = positions.iter().map(|p| p.map(f64::from));
                    return refitted(&own, &memory::collect(wide)?, &cpu);
                }
                refitted(&own, &positions, &cpu)
            });
        }
        let vertices = vertices.extract::<PyReadonlyArrayDyn<'_, f64>>()?;
        let positions = triples(&vertices)?;
        drop(vertices);
        Self::made(py, Some(on), is_long, move || {
            if own.is_f64() {
                return refitted(&own, &positions, &cpu);
            }
            match narrowed(&positions)? {
                Some(narrow) => refitted(&own, &narrow, &cpu),
                // Its faces are checked against the new positions.
                None => pfront::Model::from_f64(positions, memory::copy(own.mesh().triangles())?),
            }
        })
    }

    /// A model out of the bytes of a `.pfb`.
    #[staticmethod]
    fn from_blob(py: Python<'_>, bytes: PyReadonlyArrayDyn<'_, u8>) -> PyResult<Self> {
        let bytes = crate::arrays::numbers(&bytes)?;
        Self::made(py, None, bytes.len() > LARGE, move || pfront::Model::from_blob(&bytes))
    }

    /// The bytes of a `.pfb`.
    fn to_blob<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let model = self.0.clone();
        let bytes = on_thread_if(py, model.bytes() > LARGE, move || model.to_blob())?;
        let bytes = bytes.map_err(|error| exception(py, error, None))?;
        PyBytes::new_with(py, bytes.len(), |out| {
            out.copy_from_slice(&bytes);
            Ok(())
        })
    }

    /// A copy of the positions.
    fn vertices(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let mesh = self.0.mesh();
        match mesh.positions_f64().filter(|_| self.0.is_f64()) {
            Some(positions) => rows(py, positions),
            None => rows(py, mesh.shadow()),
        }
    }

    /// A copy of the corners of triangles.
    fn faces(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        rows(py, self.0.mesh().triangles())
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
        on: Option<&Executor>,
        is_long: bool,
        make: impl FnOnce() -> Result<pfront::Model, Error> + Send + 'static,
    ) -> PyResult<Self> {
        let work = on.filter(|_| is_long).map(|on| on.made(py).use_pool());
        let make = move || {
            let made = make();
            drop(work);
            made
        };
        let made = on_thread_if(py, is_long, make)?.map_err(|error| exception(py, error, None))?;
        Ok(Arc::new(made).into())
    }

    /// Its solid, which is made when it is asked for first; an error tells the name of the mesh.
    pub(crate) fn solid(&self, py: Python<'_>, name: &str) -> PyResult<Arc<Solid>> {
        if let Some(solid) = lock(&self.1).as_ref() {
            return Ok(solid.clone());
        }
        let (model, is_long) = (self.0.clone(), self.counts().1 >= MANY);
        let solid = match on_thread_if(py, is_long, move || Solid::new(model))? {
            Ok(solid) => Arc::new(solid),
            Err(Error::Solid(error)) => return Err(not_solid(py, &error, Some(name))),
            Err(error) => return Err(exception(py, error, None)),
        };
        // Another thread may have made one meanwhile.
        Ok(lock(&self.1).get_or_insert(solid).clone())
    }
}

/// Calls a function, on a thread of its own if it takes longer than signals may wait.
fn on_thread_if<T: Send + 'static>(
    py: Python<'_>,
    is_long: bool,
    make: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    if is_long { heard(py, &Arc::default(), make) } else { Ok(apart(py, make)) }
}

/// Positions in float32, if that holds them all to the bit.
fn narrowed(positions: &[[f64; 3]]) -> Result<Option<Vec<[f32; 3]>>, Error> {
    let is_f32 = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
    let all = positions.as_flattened().iter().all(is_f32);
    all.then(|| memory::collect(positions.iter().map(|p| p.map(|x| x as f32)))).transpose()
}

fn refitted<S: Scalar>(
    own: &pfront::Model,
    positions: &[[S; 3]],
    cpu: &pfront::Executor,
) -> Result<pfront::Model, Error> {
    let mut model = own.try_clone()?;
    cpu.refit(&mut model, positions)?;
    Ok(model)
}

impl Executor {
    /// Whether a mesh of so many triangles takes longer than signals may wait, and the executor for it: all threads only then.
    fn cpu_for(&self, py: Python<'_>, triangles: usize) -> (bool, pfront::Executor) {
        match triangles >= MANY {
            true => (true, self.made(py).cpu),
            false => (false, pfront::Executor::sequential()),
        }
    }
}
