//! Arrays of NumPy, in and out.

use crate::errors::exception;
use crate::memory::copy;
use bytemuck::Pod;
use numpy::ndarray::{Array2, Array3};
use numpy::{Element, IntoPyArray, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pfront::TrianglePair;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// The entries of an array in C order; `as_slice` alone would take Fortran's.
pub(crate) fn entries<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [T]> {
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
        [_, 3] => {
            let rows = copy(entries(array)?.as_chunks::<3>().0);
            rows.map_err(|error| exception(array.py(), error, None))
        }
        shape => Err(PyValueError::new_err(format!("an array of shape {shape:?} is not (n, 3)"))),
    }
}

/// A copy of numbers.
pub(crate) fn numbers<T: Element + Copy>(array: &PyReadonlyArrayDyn<'_, T>) -> PyResult<Vec<T>> {
    copy(entries(array)?).map_err(|error| exception(array.py(), error, None))
}

/// An (n, 2) array of pairs, in their memory.
pub(crate) fn pair_array(py: Python<'_>, pairs: Vec<TrianglePair>) -> PyResult<Py<PyAny>> {
    let rows = pairs.len();
    table::<u32>(py, flat(py, pairs)?, rows, 2)
}

/// A copy of rows of three.
pub(crate) fn rows<T: Element + Pod>(py: Python<'_>, rows: &[[T; 3]]) -> PyResult<Py<PyAny>> {
    let flat = copy(rows.as_flattened()).map_err(|error| exception(py, error, None))?;
    table(py, flat, rows.len(), 3)
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

/// An array of two points a row, in their memory.
pub(crate) fn points<T: Element + Pod>(
    py: Python<'_>,
    rows: Vec<[[T; 3]; 2]>,
) -> PyResult<Py<PyAny>> {
    let array = Array3::from_shape_vec((rows.len(), 2, 3), flat::<_, T>(py, rows)?);
    let array = array.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(array.into_pyarray(py).into_any().unbind())
}

/// An array of one dimension.
pub(crate) fn list<T: Element>(py: Python<'_>, list: Vec<T>) -> Py<PyAny> {
    list.into_pyarray(py).into_any().unbind()
}

/// The numbers of rows, in their memory.
fn flat<R: Pod, T: Pod>(py: Python<'_>, rows: Vec<R>) -> PyResult<Vec<T>> {
    bytemuck::allocation::try_cast_vec(rows).or_else(|(_, rows)| {
        // A capacity that does not fit, which has to be copied.
        copy(bytemuck::cast_slice(&rows)).map_err(|error| exception(py, error, None))
    })
}
