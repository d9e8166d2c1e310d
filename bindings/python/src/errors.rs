//! Errors of the library as exceptions, which are written in Python: `pfront/_errors.py`.

use pfront::{Error, MeshError, NotSolid, PoseError};
use pfront_files::ReadError;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::error::Error as _;
use std::io;
use std::path::Path;

mod python {
    pyo3::import_exception!(pfront._errors, MeshError);
    pyo3::import_exception!(pfront._errors, NotSolid);
    pyo3::import_exception!(pfront._errors, PoseError);
    pyo3::import_exception!(pfront._errors, BlobError);
    pyo3::import_exception!(pfront._errors, StaleBody);
    pyo3::import_exception!(pfront._errors, DeviceError);
}

/// Imports all exceptions.
pub(crate) fn load(py: Python<'_>) -> PyResult<()> {
    for error in [
        python::MeshError::new_err(""),
        python::NotSolid::new_err(""),
        python::PoseError::new_err(""),
        python::BlobError::new_err(""),
        python::StaleBody::new_err(""),
        python::DeviceError::new_err(""),
    ] {
        error.value(py);
    }
    Ok(())
}

/// The exception that says the same; `pose` is the index of the pose at fault, if there are many.
pub(crate) fn exception(py: Python<'_>, error: Error, pose: Option<usize>) -> PyErr {
    let text = match error {
        // Nothing is split here.
        Error::StaleBody { id } => {
            format!("{id} is not in the scene: it was never added, or has been removed")
        }
        Error::Solid(error) => return not_solid(py, &error, None),
        _ => error.to_string(),
    };
    let text = pose.map_or(text.clone(), |pose| format!("pose {pose}: {text}"));
    let (raised, names) = match error {
        Error::Mesh(error) => (python::MeshError::new_err(text), of_mesh(&error)),
        Error::Pose(error) => (python::PoseError::new_err(text), of_pose(&error)),
        Error::Blob(_) => (python::BlobError::new_err(text), None),
        Error::Distance(_) | Error::Motion(_) | Error::TwoEnds { .. } => {
            (PyValueError::new_err(text), None)
        }
        Error::StaleBody { .. } => (python::StaleBody::new_err(text), None),
        Error::Gpu(_) => (python::DeviceError::new_err(text), None),
        Error::Memory { .. } => (PyMemoryError::new_err(text), None),
        _ => (PyRuntimeError::new_err(text), None),
    };
    for (name, value) in names.into_iter().chain(pose.map(|pose| ("pose", pose))) {
        if let Err(refused) = raised.value(py).setattr(name, value) {
            return refused;
        }
    }
    raised
}

/// The exception that a mesh, of this name among those of the question, is no solid.
pub(crate) fn not_solid(py: Python<'_>, error: &NotSolid, mesh: Option<&str>) -> PyErr {
    let text = mesh.map_or(error.to_string(), |mesh| format!("{mesh} is no solid: {error}"));
    let raised = python::NotSolid::new_err(text);
    let value = raised.value(py);
    let set = match *error {
        NotSolid::OpenEdge { triangle, edge } => {
            value.setattr("face", triangle).and_then(|()| value.setattr("edge", edge))
        }
        NotSolid::MeetsItself { pair } => value.setattr("pair", (pair.a, pair.b)),
        _ => Ok(()),
    };
    match set.and_then(|()| value.setattr("mesh", mesh)) {
        Ok(()) => raised,
        Err(refused) => refused,
    }
}

/// The error of an object that a parent's thread was using when this process was forked.
pub(crate) fn forked() -> PyErr {
    PyRuntimeError::new_err(
        "another thread was using this scene when the process was forked, and may have left it half changed: make the scene \
         again here, or start processes by multiprocessing's \"spawn\" or \"forkserver\"",
    )
}

/// A device that cannot be had.
pub(crate) fn device(text: String) -> PyErr {
    python::DeviceError::new_err(text)
}

/// A mesh file that cannot be read, or is none.
pub(crate) fn unread(error: &ReadError, path: &Path) -> PyErr {
    let io = error.source().and_then(|source| source.downcast_ref::<io::Error>());
    match io.and_then(|io| Some((io.raw_os_error()?, io.to_string()))) {
        Some((number, text)) => PyOSError::new_err((number, text, path.to_owned())),
        None => python::MeshError::new_err(error.to_string()),
    }
}

/// Poses that do not fit the question.
pub(crate) fn poses(text: String) -> PyErr {
    python::PoseError::new_err(text)
}

/// The name of what is at fault in a mesh, and its number.
fn of_mesh(error: &MeshError) -> Option<(&'static str, usize)> {
    match *error {
        MeshError::NonFinite { vertex } | MeshError::Range { vertex } => Some(("vertex", vertex)),
        MeshError::IndexOutOfRange { triangle, .. } => Some(("face", triangle)),
        _ => None,
    }
}

fn of_pose(error: &PoseError) -> Option<(&'static str, usize)> {
    match *error {
        PoseError::NonFinite { row, .. } | PoseError::Range { row } => Some(("row", row)),
        _ => None,
    }
}
