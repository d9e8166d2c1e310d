//! Triangles that segments meet, and the location of points.

use crate::arrays::{list, triples};
use crate::asking::ask;
use crate::executor::Executor;
use crate::memory;
use crate::model::Model;
use numpy::PyReadonlyArrayDyn;
use pfront::{Error, Location, SegmentHit};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Points or segments between two looks at the flag that cancels.
const CHUNK: usize = 1 << 8;

/// So many of them take longer than signals may wait.
const MANY: usize = 1 << 14;

/// Columns of hits: triangles and parameters.
pub(crate) type Arrays = (Py<PyAny>, Py<PyAny>);

/// The code of a location.
pub(crate) fn code(location: Location) -> u8 {
    match location {
        Location::Outside => 0,
        Location::Inside => 1,
        Location::Surface => 2,
    }
}

/// Answers for each item on the calling thread, or on one of its own if there are many.
fn each<I: Send + Sync + 'static, T: Send + 'static>(
    py: Python<'_>,
    on: &Executor,
    items: Vec<I>,
    answer: impl Fn(&I) -> Result<T, Error> + Send + Sync + 'static,
) -> PyResult<Vec<T>> {
    let cancel = Arc::<AtomicBool>::default();
    let flag = cancel.clone();
    ask(py, on, &cancel, items.len() >= MANY, move |_| {
        let mut answers = Vec::new();
        memory::reserve(&mut answers, items.len())?;
        for chunk in items.chunks(CHUNK) {
            if flag.load(Relaxed) {
                return Err(Error::Cancelled);
            }
            for item in chunk {
                answers.push(answer(item)?);
            }
        }
        Ok((answers, None))
    })
}

/// Where each point is, as a solid sees it: 0 outside, 1 inside, 2 on the surface.
#[pyfunction]
pub fn inside(
    py: Python<'_>,
    model: &Model,
    points: PyReadonlyArrayDyn<'_, f64>,
    on: &Executor,
) -> PyResult<Py<PyAny>> {
    let points = triples(&points)?;
    let solid = model.solid(py, "mesh")?;
    Ok(list(py, each(py, on, points, move |point| Ok(code(solid.inside(*point)?)))?))
}

/// The triangles that a segment meets, sorted, and the parameters.
#[pyfunction]
pub fn segment(
    py: Python<'_>,
    model: &Model,
    ends: [[f64; 3]; 2],
    on: &Executor,
) -> PyResult<Arrays> {
    let model = model.0.clone();
    let hits = ask(py, on, &Arc::default(), false, move |_| {
        let [from, to] = ends;
        Ok((model.segment(from, to)?, None))
    })?;
    let faces = hits.iter().map(|hit| hit.triangle).collect();
    Ok((list::<u32>(py, faces), list::<f64>(py, hits.iter().map(|hit| hit.at).collect())))
}

/// The first triangle along each segment, or −1, and the parameter, or NaN.
#[pyfunction]
pub fn segment_first(
    py: Python<'_>,
    model: &Model,
    starts: PyReadonlyArrayDyn<'_, f64>,
    ends: PyReadonlyArrayDyn<'_, f64>,
    on: &Executor,
) -> PyResult<Arrays> {
    let segments = triples(&starts)?.into_iter().zip(triples(&ends)?).collect();
    let model = model.0.clone();
    let first = each(py, on, segments, move |&(from, to)| model.segment_first(from, to))?;
    let face = |hit: &Option<SegmentHit>| hit.map_or(-1, |hit| i64::from(hit.triangle));
    let at = |hit: &Option<SegmentHit>| hit.map_or(f64::NAN, |hit| hit.at);
    Ok((list(py, first.iter().map(face).collect()), list(py, first.iter().map(at).collect())))
}
