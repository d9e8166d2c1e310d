//! Questions about two models in many poses.

use crate::arrays::{list, pair_array, poses};
use crate::errors::exception;
use crate::executor::Executor;
use crate::model::Model;
use crate::question::{together, wait};
use numpy::PyUntypedArray;
use pfront::{Batch, Error, Ticket};
use pyo3::prelude::*;

/// Poses that are asked about in one submission.
const CHUNK: usize = 1 << 14;

/// Asks about many poses, in chunks of which progress is told.
fn many<T: Send>(
    py: Python<'_>,
    (a, b): (&Model, &Model),
    array: &Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    verb: fn(&mut Batch, &pfront::Executor) -> Result<Ticket<T>, Error>,
    mut read: impl FnMut(T),
) -> PyResult<()> {
    let poses = poses(array)?;
    let executor = together(py, on)?;
    let mut batch = Batch::new();
    let mut done = 0;
    for chunk in poses.chunks(CHUNK) {
        let start = || {
            batch.clear();
            for (i, pose) in chunk.iter().enumerate() {
                batch.pair(&a.0, &b.0, pose).map_err(|error| (error, Some(done + i)))?;
            }
            verb(&mut batch, &executor).map_err(|error| (error, None))
        };
        let ticket = py.detach(start).map_err(|(error, pose)| exception(py, error, pose))?;
        read(wait(py, ticket)?);
        done += chunk.len();
        if let Some(progress) = &progress {
            progress.call1((done, poses.len()))?;
        }
    }
    Ok(())
}

/// For each pose, whether some pair meets.
#[pyfunction]
pub fn batch_any(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    poses: Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let mut found = Vec::<bool>::new();
    many(py, (a, b), &poses, on, progress, Batch::any, |answers| {
        found.extend(answers.iter().map(Option::is_some));
    })?;
    Ok(list(py, found))
}

/// For each pose, the number of pairs that meet.
#[pyfunction]
pub fn batch_count(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    poses: Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let mut counts = Vec::<i64>::new();
    many(py, (a, b), &poses, on, progress, Batch::count, |answers| {
        counts.extend(answers.iter().map(|&count| count as i64));
    })?;
    Ok(list(py, counts))
}

/// The pairs that meet for all poses, and where those of each begin and end.
#[pyfunction]
pub fn batch_all(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    poses: Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
    let (mut pairs, mut offsets) = (Vec::new(), vec![0_i64]);
    many(py, (a, b), &poses, on, progress, Batch::all, |lists| {
        let first = pairs.len();
        let ends = lists.iter().scan(first, |end, list| {
            *end += list.len();
            Some(*end as i64)
        });
        offsets.extend(ends);
        pairs.extend_from_slice(lists.pairs());
    })?;
    Ok((pair_array(py, pairs)?, list(py, offsets)))
}
