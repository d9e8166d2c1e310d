//! Arrays of NumPy, in and out.

use numpy::ndarray::{Array2, Array3};
use numpy::{Element, IntoPyArray, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pfront::{AnyPose, Pose, Pose64, TrianglePair};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// The entries of an array in C order; `as_slice` alone would take Fortran's.
fn entries<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [T]> {
    if !array.is_c_contiguous() {
        return Err(PyTypeError::new_err("an array is not in C order"));
    }
    Ok(array.as_slice()?)
}

/// A copy of the rows of an (n, 3) array.
pub(crate) fn triples<T: Element + Copy>(
    array: &PyReadonlyArrayDyn<'_, T>,
) -> PyResult<Vec<[T; 3]>> {
    match array.shape() {
        [_, 3] => Ok(entries(array)?.as_chunks::<3>().0.to_vec()),
        shape => Err(PyValueError::new_err(format!("an array of shape {shape:?} is not (n, 3)"))),
    }
}

/// A copy of numbers.
pub(crate) fn numbers<T: Element + Copy>(array: &PyReadonlyArrayDyn<'_, T>) -> PyResult<Vec<T>> {
    Ok(entries(array)?.to_vec())
}

/// Poses out of an (k, 3, 4) array of float32 or float64; one of shape (3, 4) is one pose.
pub(crate) fn poses(array: &Bound<'_, PyUntypedArray>) -> PyResult<Vec<AnyPose>> {
    if let Ok(array) = array.extract::<PyReadonlyArrayDyn<'_, f64>>() {
        let (poses, _) = entries(&array)?.as_chunks::<12>();
        return Ok(poses.iter().map(of_f64).collect());
    }
    let array = array.extract::<PyReadonlyArrayDyn<'_, f32>>()?;
    let (poses, _) = entries(&array)?.as_chunks::<12>();
    Ok(poses.iter().map(of_f32).collect())
}

/// A pose out of a (3, 4) or (4, 4) array, whose last row the Python half has looked at.
pub(crate) fn pose(array: Option<&Bound<'_, PyAny>>) -> PyResult<AnyPose> {
    let Some(array) = array else { return Ok(AnyPose::F32(Pose::IDENTITY)) };
    let wrong = || PyValueError::new_err("a pose has 3 or 4 rows of 4 numbers");
    if let Ok(array) = array.extract::<PyReadonlyArrayDyn<'_, f64>>() {
        return Ok(of_f64(entries(&array)?.first_chunk().ok_or_else(wrong)?));
    }
    let array = array.extract::<PyReadonlyArrayDyn<'_, f32>>()?;
    Ok(of_f32(entries(&array)?.first_chunk().ok_or_else(wrong)?))
}

fn of_f32(entries: &[f32; 12]) -> AnyPose {
    let [x, y, z] = [0, 4, 8].map(|row| [0, 1, 2, 3].map(|column| entries[row + column]));
    AnyPose::F32(Pose::new([x, y, z]))
}

/// The identity moves nothing in either precision.
fn of_f64(entries: &[f64; 12]) -> AnyPose {
    let [x, y, z] = [0, 4, 8].map(|row| [0, 1, 2, 3].map(|column| entries[row + column]));
    let pose = Pose64::new([x, y, z]);
    if pose == Pose64::IDENTITY { AnyPose::F32(Pose::IDENTITY) } else { AnyPose::F64(pose) }
}

/// An (n, 2) array of pairs, in their memory.
pub(crate) fn pair_array(py: Python<'_>, pairs: Vec<TrianglePair>) -> PyResult<Py<PyAny>> {
    let rows = pairs.len();
    let flat = match bytemuck::allocation::try_cast_vec::<TrianglePair, u32>(pairs) {
        Ok(flat) => flat,
        // A capacity that does not fit, which has to be copied.
        Err((_, pairs)) => pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect(),
    };
    table(py, flat, rows, 2)
}

/// An array of `rows` by `columns`.
pub(crate) fn table<T: Element>(
    py: Python<'_>,
    flat: Vec<T>,
    rows: usize,
    columns: usize,
) -> PyResult<Py<PyAny>> {
    let array = Array2::from_shape_vec((rows, columns), flat);
    let array = array.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py).into_any().unbind())
}

/// An array of two points a row.
pub(crate) fn points<T: Element>(py: Python<'_>, rows: Vec<[[T; 3]; 2]>) -> PyResult<Py<PyAny>> {
    let count = rows.len();
    let flat: Vec<T> = rows.into_iter().flatten().flatten().collect();
    let array = Array3::from_shape_vec((count, 2, 3), flat);
    let array = array.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py).into_any().unbind())
}

/// An array of one dimension.
pub(crate) fn list<T: Element>(py: Python<'_>, list: Vec<T>) -> Py<PyAny> {
    list.into_pyarray(py).into_any().unbind()
}
