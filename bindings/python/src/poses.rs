//! Poses out of whatever a user holds.

use crate::arrays::{entries, numbers};
use crate::errors::{self, exception};
use crate::memory;
use numpy::{
    Element, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pfront::pfront_core::environment::with_default;
use pfront::{AnyPose, Pose, Pose64};
use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// The function that makes an array of shape (3, 4) or (k, 3, 4) of any other object, or refuses it.
pub(crate) fn load(py: Python<'_>) -> PyResult<&Bound<'_, PyAny>> {
    static MATRIX: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    MATRIX.import(py, "pfront._poses", "matrix")
}

/// One pose or many.
pub(crate) enum Poses {
    One(AnyPose),
    Many(Vec<AnyPose>),
}

impl Poses {
    /// The poses of an object; without one, the identity.
    pub(crate) fn new(py: Python<'_>, object: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(object) = object else { return Ok(Self::One(AnyPose::F32(Pose::IDENTITY))) };
        if let Some(pose) = plain(object) {
            return Ok(Self::One(pose));
        }
        let array = load(py)?.call1((object,))?;
        let is_one = array.cast::<PyUntypedArray>()?.ndim() == 2;
        let mut poses = match array.extract::<PyReadonlyArrayDyn<'_, f64>>() {
            Ok(array) => collected(py, entries(&array)?, of_f64)?,
            Err(_) => {
                let array = array.extract::<PyReadonlyArrayDyn<'_, f32>>()?;
                collected(py, entries(&array)?, of_f32)?
            }
        };
        match poses.pop() {
            Some(pose) if is_one => Ok(Self::One(pose)),
            last => {
                poses.extend(last);
                Ok(Self::Many(poses))
            }
        }
    }

    /// The poses in a list.
    pub(crate) fn into_list(self) -> Vec<AnyPose> {
        match self {
            Self::One(pose) => vec![pose],
            Self::Many(poses) => poses,
        }
    }
}

/// Ids of bodies and a pose for each, and whether one pose was given rather than many.
pub(crate) fn one_for_each(
    py: Python<'_>,
    ids: &PyReadonlyArrayDyn<'_, u64>,
    poses: &Bound<'_, PyAny>,
) -> PyResult<(Vec<u64>, Vec<AnyPose>, bool)> {
    let (ids, poses) = (numbers(ids)?, Poses::new(py, Some(poses))?);
    let is_one = matches!(poses, Poses::One(_));
    let poses = poses.into_list();
    if ids.len() != poses.len() {
        let text = format!("{} poses were given for {} bodies", poses.len(), ids.len());
        return Err(errors::poses(text));
    }
    Ok((ids, poses, is_one))
}

/// The poses of twelve entries each.
fn collected<T>(
    py: Python<'_>,
    entries: &[T],
    pose: fn(&[T; 12]) -> AnyPose,
) -> PyResult<Vec<AnyPose>> {
    let poses = with_default(|| memory::collect(entries.as_chunks().0.iter().map(pose)));
    poses.map_err(|error| exception(py, error, None))
}

/// The pose of an array of shape (4, 4) that can be read as it is, as most can; `None` of any other object. Subclasses are
/// looked at by the Python half: masked arrays are among them.
fn plain(object: &Bound<'_, PyAny>) -> Option<AnyPose> {
    if !object.get_type().is(PyUntypedArray::type_object(object.py())) {
        return None;
    }
    // Subnormal numbers are no zeros, whatever the caller's environment says.
    with_default(|| {
        if let Ok(array) = object.cast::<PyArray2<f64>>() {
            rows(array).as_ref().map(of_f64)
        } else {
            rows(object.cast::<PyArray2<f32>>().ok()?).as_ref().map(of_f32)
        }
    })
}

/// The first three rows of an aligned array in C order whose last row is that of a pose.
fn rows<T: Element + Copy + From<u8> + PartialEq>(
    array: &Bound<'_, PyArray2<T>>,
) -> Option<[T; 12]> {
    if array.shape() != [4, 4] || !array.is_c_contiguous() {
        return None;
    }
    let entries = array.to_vec().ok()?;
    let (rows, last) = entries.split_first_chunk()?;
    (last == [0, 0, 0, 1].map(T::from)).then_some(*rows)
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
