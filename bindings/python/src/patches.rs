//! Contacts as connected patches.

use crate::arrays::{pair_array, rows, table};
use crate::asking::ask;
use crate::errors;
use crate::executor::Executor;
use crate::model::{MANY, Model};
use crate::poses::Poses;
use pfront::{ContactPatch, PairQuery};
use pyo3::prelude::*;
use std::sync::Arc;

/// A patch: its dimension, whether it is closed, intervals of its length and area, its pairs, points and segments.
type Told = (usize, bool, (f64, f64), (f64, f64), Py<PyAny>, Py<PyAny>, Py<PyAny>);

fn told(py: Python<'_>, patch: ContactPatch) -> PyResult<Told> {
    let ContactPatch { dimension, is_closed, length, area, pairs, points, segments } = patch;
    let count = segments.len();
    let segments = table(py, segments.into_flattened(), count, 2)?;
    let (pairs, points) = (pair_array(py, pairs)?, rows(py, &points)?);
    Ok((dimension, is_closed, length.into(), area.into(), pairs, points, segments))
}

/// All that two models have in common in a pose, in connected patches.
#[pyfunction]
pub fn patches(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
) -> PyResult<Vec<Told>> {
    let Poses::One(pose) = Poses::new(py, pose.as_ref())? else {
        return Err(errors::poses("patches are told of one pose".to_owned()));
    };
    let models = [a.0.clone(), b.0.clone()];
    let count = models.iter().map(|model| model.mesh().triangles().len()).sum::<usize>();
    let found = ask(py, on, &Arc::default(), count >= MANY, move |executor| {
        let mut query = PairQuery::new().on(executor);
        let found = query.patches(&models[0], &models[1], pose)?;
        Ok((found, query.plan().cloned()))
    })?;
    found.into_iter().map(|patch| told(py, patch)).collect()
}
