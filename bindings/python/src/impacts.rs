//! Triangles that meet while meshes move.

use crate::arrays::{list, table};
use crate::asking::ask;
use crate::errors;
use crate::executor::Executor;
use crate::model::{MANY, Model};
use crate::poses::Poses;
use crate::question::Within;
use pfront::{AnyPose, Error, Impact, Motion, PairQuery, SelfQuery, TrianglePair};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Columns of impacts: pairs, and the times from and to.
type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>);

/// One impact: its pair, and the times from and to.
type Row = ((u32, u32), f64, f64);

type Timed = (TrianglePair, Impact);

/// A model at the start, and at the end if that is another.
type Ends = (Arc<pfront::Model>, Option<Arc<pfront::Model>>);

fn one_pose(py: Python<'_>, pose: Option<&Bound<'_, PyAny>>) -> PyResult<AnyPose> {
    match Poses::new(py, pose)? {
        Poses::One(pose) => Ok(pose),
        Poses::Many(_) => Err(errors::poses("a motion has one pose at each end".to_owned())),
    }
}

fn moving((start, end): &Ends) -> Result<Motion<'_>, Error> {
    match end {
        Some(end) => Motion::between(start, end),
        None => Ok(Motion::at_rest(start)),
    }
}

fn ends(start: &Py<Model>, end: Option<Py<Model>>) -> Ends {
    (start.get().0.clone(), end.map(|end| end.get().0.clone()))
}

fn row((pair, impact): Timed) -> Row {
    ((pair.a, pair.b), impact.from, impact.to)
}

fn arrays(py: Python<'_>, found: &[Timed]) -> PyResult<Arrays> {
    let pairs = found.iter().flat_map(|(pair, _)| [pair.a, pair.b]).collect();
    let times = |of: fn(&Impact) -> f64| found.iter().map(|(_, impact)| of(impact)).collect();
    let (from, to) = (times(|impact| impact.from), times(|impact| impact.to));
    Ok((table::<u32>(py, pairs, found.len(), 2)?, list(py, from), list(py, to)))
}

/// The models of both motions at times 0 and 1, and the poses of the second.
type Motions<'py> = (
    Py<Model>,
    Option<Py<Model>>,
    Option<Py<Model>>,
    Option<Py<Model>>,
    [Option<Bound<'py, PyAny>>; 2],
);

/// Asks a verb about two models that move, or about one that deforms.
fn asked<T: Send + 'static>(
    py: Python<'_>,
    (a, a_end, b, b_end, poses): Motions<'_>,
    Within(within): Within,
    on: &Executor,
    of_two: fn(&mut PairQuery, &Motion<'_>, &Motion<'_>) -> Result<T, Error>,
    of_one: fn(&mut SelfQuery, &Motion<'_>) -> Result<T, Error>,
) -> PyResult<T> {
    let [start, end] = poses.each_ref().map(|pose| one_pose(py, pose.as_ref()));
    let poses = [start?, end?];
    let (a, b) = (ends(&a, a_end), b.map(|b| ends(&b, b_end)));
    let count = |(model, _): &Ends| model.mesh().triangles().len();
    let triangles = count(&a) + b.as_ref().map_or(0, count);
    let cancel = Arc::<AtomicBool>::default();
    ask(py, on, &cancel, triangles >= MANY, move |executor| {
        let of_a = moving(&a)?;
        match &b {
            Some(b) => {
                let of_b = match &b.1 {
                    None => Motion::new(&b.0, poses[0], poses[1])?,
                    Some(_) => moving(b)?,
                };
                let mut query = PairQuery::new().within(within.get())?.on(executor);
                Ok((of_two(&mut query, &of_a, &of_b)?, query.plan().cloned()))
            }
            None => {
                let mut query = SelfQuery::new().within(within.get())?.on(executor);
                Ok((of_one(&mut query, &of_a)?, query.plan().cloned()))
            }
        }
    })
}

/// All pairs of two models, or of one that deforms, that meet on the way, with when they do.
#[pyfunction]
pub fn impacts(
    py: Python<'_>,
    motions: Motions<'_>,
    within: Within,
    on: &Executor,
) -> PyResult<Arrays> {
    arrays(py, &asked(py, motions, within, on, PairQuery::impacts, SelfQuery::impacts)?)
}

/// The pair that meets first.
#[pyfunction]
pub fn first_impact(
    py: Python<'_>,
    motions: Motions<'_>,
    within: Within,
    on: &Executor,
) -> PyResult<Option<Row>> {
    let first = asked(py, motions, within, on, PairQuery::first_impact, SelfQuery::first_impact)?;
    Ok(first.map(row))
}

/// Some pair that meets, one that certainly does if there is one.
#[pyfunction]
pub fn any_impact(
    py: Python<'_>,
    motions: Motions<'_>,
    within: Within,
    on: &Executor,
) -> PyResult<Option<Row>> {
    Ok(asked(py, motions, within, on, PairQuery::any_impact, SelfQuery::any_impact)?.map(row))
}

/// How many pairs certainly meet, and how many do or are open.
#[pyfunction]
pub fn count_impacts(
    py: Python<'_>,
    motions: Motions<'_>,
    within: Within,
    on: &Executor,
) -> PyResult<(u64, u64)> {
    Ok(asked(py, motions, within, on, PairQuery::count_impacts, SelfQuery::count_impacts)?.into())
}
