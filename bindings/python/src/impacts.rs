//! Triangles that meet while meshes move.

use crate::arrays::{list, table};
use crate::asking::ask;
use crate::errors;
use crate::executor::Executor;
use crate::model::{MANY, Model};
use crate::poses::Poses;
use pfront::{AnyPose, Error, Impact, Motion, PairQuery, SelfQuery, TrianglePair};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Columns of impacts: pairs, and the times from and to.
type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>);

type Timed = Vec<(TrianglePair, Impact)>;

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

fn ends(start: &Model, end: Option<&Model>) -> Ends {
    (start.0.clone(), end.map(|end| end.0.clone()))
}

fn arrays(py: Python<'_>, found: &Timed) -> PyResult<Arrays> {
    let pairs = found.iter().flat_map(|(pair, _)| [pair.a, pair.b]).collect();
    let times = |of: fn(&Impact) -> f64| found.iter().map(|(_, impact)| of(impact)).collect();
    let (from, to) = (times(|impact| impact.from), times(|impact| impact.to));
    Ok((table::<u32>(py, pairs, found.len(), 2)?, list(py, from), list(py, to)))
}

/// All pairs of two models, or of one that deforms, that meet on the way, or the first of them, with when they do.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are those of the function in Python")]
pub fn impacts(
    py: Python<'_>,
    a: &Model,
    a_end: Option<&Model>,
    b: Option<&Model>,
    b_end: Option<&Model>,
    poses: [Option<Bound<'_, PyAny>>; 2],
    first: bool,
    on: &Executor,
) -> PyResult<Arrays> {
    let [start, end] = poses.each_ref().map(|pose| one_pose(py, pose.as_ref()));
    let poses = [start?, end?];
    let (a, b) = (ends(a, a_end), b.map(|b| ends(b, b_end)));
    let count = |(model, _): &Ends| model.mesh().triangles().len();
    let triangles = count(&a) + b.as_ref().map_or(0, count);
    let cancel = Arc::<AtomicBool>::default();
    let found = ask(py, on, &cancel, triangles >= MANY, move |executor| {
        let of_a = moving(&a)?;
        match &b {
            Some(b) => {
                let of_b = match &b.1 {
                    None => Motion::new(&b.0, poses[0], poses[1])?,
                    Some(_) => moving(b)?,
                };
                let mut query = PairQuery::new().on(executor);
                let found: Timed = match first {
                    true => query.first_impact(&of_a, &of_b)?.into_iter().collect(),
                    false => query.impacts(&of_a, &of_b)?,
                };
                Ok((found, query.plan().cloned()))
            }
            None => {
                let mut query = SelfQuery::new().on(executor);
                let found: Timed = match first {
                    true => query.first_impact(&of_a)?.into_iter().collect(),
                    false => query.impacts(&of_a)?,
                };
                Ok((found, query.plan().cloned()))
            }
        }
    })?;
    arrays(py, &found)
}
