//! Mesh files, read as the command reads them.

use crate::arrays::{list, rows};
use crate::errors::unread;
use crate::threads::heard;
use pfront_files::{ReadError, ReadOptions, TriangleMesh, open};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Vertices and faces of a file, the names of its bodies, each with the numbers of its faces, and notes of what was passed over.
type Read = (Py<PyAny>, Py<PyAny>, Vec<(String, Py<PyAny>)>, Vec<String>);

/// Reads a mesh file, while signals are heard.
#[pyfunction]
pub fn read(py: Python<'_>, path: PathBuf) -> PyResult<Read> {
    let read = {
        let path = path.clone();
        let read = move || open(&path, &ReadOptions::default())?.into_mesh(&path);
        heard(py, &Arc::default(), read)?
    };
    let file = read.map_err(|error: ReadError| unread(&error, &path))?;
    let bodies = file.source.triangles(file.mesh.triangles.len());
    let names = file.source.bodies().iter().cloned();
    let bodies = names.zip(bodies).map(|(name, faces)| (name, list(py, faces))).collect();
    let TriangleMesh { positions, triangles } = file.mesh;
    Ok((rows(py, &positions)?, rows(py, &triangles)?, bodies, file.notes))
}
