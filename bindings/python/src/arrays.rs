//! Arrays of NumPy, in and out.

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
        [_, 3] => Ok(entries(array)?.as_chunks::<3>().0.to_vec()),
        shape => Err(PyValueError::new_err(format!("an array of shape {shape:?} is not (n, 3)"))),
    }
}

/// A copy of numbers.
pub(crate) fn numbers<T: Element + Copy>(array: &PyReadonlyArrayDyn<'_, T>) -> PyResult<Vec<T>> {
    Ok(entries(array)?.to_vec())
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
