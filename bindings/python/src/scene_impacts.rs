//! Triangles of bodies of a scene that meet while some of these move.

use crate::arrays::{list, pair_array, table};
use crate::errors::exception;
use crate::executor::Executor;
use crate::memory;
use crate::poses::one_for_each;
use crate::scene::{Scene, bodies_of, of_hit};
use numpy::PyReadonlyArrayDyn;
use pfront::{AnyPose, BodyId, Error, Impact, SceneHit, SceneQuery};
use pyo3::prelude::*;

/// Columns of impacts: bodies, pairs, and the times from and to.
type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>);

/// One impact: its bodies and its pair, and the times from and to.
type Row = ([i64; 2], (u32, u32), f64, f64);

type Timed = (SceneHit, Impact);

/// Bodies that move, and the poses to which they go.
type Ends<'py> = (PyReadonlyArrayDyn<'py, u64>, Bound<'py, PyAny>);

/// A verb about bodies that move.
type Verb<T> = fn(&mut SceneQuery, &[(BodyId, AnyPose)]) -> Result<T, Error>;

fn asked<T: Send + 'static>(
    py: Python<'_>,
    scene: &Scene,
    (ids, poses): Ends<'_>,
    on: &Bound<'_, Executor>,
    verb: Verb<T>,
) -> PyResult<T> {
    let (ids, poses, _) = one_for_each(py, &ids, &poses)?;
    let ends = ids.into_iter().map(BodyId::from_bits).zip(poses);
    let ends = memory::collect(ends).map_err(|error| exception(py, error, None))?;
    scene.ask(py, on, move |query| verb(query, &ends))
}

fn row((hit, impact): Timed) -> Row {
    (of_hit(&hit), (hit.pair.a, hit.pair.b), impact.from, impact.to)
}

/// All pairs of triangles of bodies that meet on the way, with when they do.
#[pyfunction]
pub fn scene_impacts(
    py: Python<'_>,
    scene: &Scene,
    ends: Ends<'_>,
    on: &Bound<'_, Executor>,
) -> PyResult<Arrays> {
    let (bodies, pairs, from, to) = asked(py, scene, ends, on, |query, ends| {
        let found = query.impacts(ends)?;
        let bodies = bodies_of(found.iter().map(|(hit, _)| hit))?;
        let pairs = memory::collect(found.iter().map(|(hit, _)| hit.pair))?;
        let times = |of: fn(&Impact) -> f64| memory::collect(found.iter().map(|hit| of(&hit.1)));
        Ok((bodies, pairs, times(|impact| impact.from)?, times(|impact| impact.to)?))
    })?;
    Ok((
        table(py, bodies, pairs.len(), 2)?,
        pair_array(py, pairs)?,
        list::<f64>(py, from),
        list::<f64>(py, to),
    ))
}

/// The pair that meets first.
#[pyfunction]
pub fn scene_first_impact(
    py: Python<'_>,
    scene: &Scene,
    ends: Ends<'_>,
    on: &Bound<'_, Executor>,
) -> PyResult<Option<Row>> {
    Ok(asked(py, scene, ends, on, |query, ends| query.first_impact(ends))?.map(row))
}

/// Some pair that meets, one that certainly does if there is one.
#[pyfunction]
pub fn scene_any_impact(
    py: Python<'_>,
    scene: &Scene,
    ends: Ends<'_>,
    on: &Bound<'_, Executor>,
) -> PyResult<Option<Row>> {
    Ok(asked(py, scene, ends, on, |query, ends| query.any_impact(ends))?.map(row))
}

/// How many pairs certainly meet, and how many do or are open.
#[pyfunction]
pub fn scene_count_impacts(
    py: Python<'_>,
    scene: &Scene,
    ends: Ends<'_>,
    on: &Bound<'_, Executor>,
) -> PyResult<(u64, u64)> {
    Ok(asked(py, scene, ends, on, |query, ends| query.count_impacts(ends))?.into())
}
