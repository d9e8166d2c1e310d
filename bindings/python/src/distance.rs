//! Smallest distances.

use crate::arrays::{points, table};
use crate::errors::exception;
use crate::executor::Executor;
use crate::memory::reserve;
use crate::model::Model;
use crate::question::{Question, Subject, Within};
use pfront::{Distance, Error, Gap, PairQuery};
use pyo3::prelude::*;

/// The arrays that tell distances: intervals, pairs and points.
pub(crate) type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>);

/// Distances as a struct of arrays. Where there is none, the interval is infinite, the triangles are −1 and the points NaN.
#[derive(Default)]
struct Columns {
    intervals: Vec<f64>,
    pairs: Vec<i64>,
    points: Vec<[[f64; 3]; 2]>,
}

impl Columns {
    fn extend(&mut self, gaps: &[Option<Gap>]) -> Result<(), Error> {
        reserve(&mut self.intervals, 2 * gaps.len())?;
        reserve(&mut self.pairs, 2 * gaps.len())?;
        reserve(&mut self.points, gaps.len())?;
        for gap in gaps {
            self.intervals.extend(gap.map_or([f64::INFINITY; 2], |gap| gap.interval));
            self.pairs.extend(gap.map_or([-1; 2], |gap| [gap.pair.a, gap.pair.b].map(i64::from)));
            self.points.push(gap.map_or([[f64::NAN; 3]; 2], |gap| gap.points));
        }
        Ok(())
    }

    fn into_arrays(self, py: Python<'_>) -> PyResult<Arrays> {
        let rows = self.points.len();
        let intervals = table(py, self.intervals, rows, 2)?;
        Ok((intervals, table(py, self.pairs, rows, 2)?, points(py, self.points)?))
    }
}

/// The arrays of some distances.
pub(crate) fn arrays(py: Python<'_>, gaps: &[Option<Gap>]) -> PyResult<Arrays> {
    let mut columns = Columns::default();
    columns.extend(gaps).map_err(|error| exception(py, error, None))?;
    columns.into_arrays(py)
}

/// The smallest distance of two models, if it is not greater than the limit, in each pose; and whether one pose was given.
#[pyfunction]
pub fn distance(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    limit: Option<Within>,
) -> PyResult<(Arrays, bool)> {
    let limit = limit.map(|limit| limit.0.get());
    match Question::new(py, a, Some(b), pose.as_ref(), progress, Distance::default())? {
        Question::One(subject) => {
            let gap = subject.ask(py, on, move |subject, executor| {
                let Subject::Pair { models: [a, b], a_from_b, .. } = subject else {
                    return Err(Error::NotAPair { question: 0 });
                };
                let mut query = PairQuery::new().on(executor);
                let gap = match limit {
                    Some(limit) => query.distance_below(a, b, *a_from_b, limit),
                    None => query.distance(a, b, *a_from_b),
                }?;
                Ok((gap, query.plan().cloned()))
            })?;
            Ok((arrays(py, &[gap])?, true))
        }
        Question::Many(many) => {
            let mut columns = Columns::default();
            let verb = |batch: &mut pfront::Batch, executor: &pfront::Executor| match limit {
                Some(limit) => batch.distance_below(executor, limit),
                None => batch.distance(executor),
            };
            many.ask(py, on, verb, |_, gaps| {
                columns.extend(&gaps).map_err(|error| exception(py, error, None))
            })?;
            Ok((columns.into_arrays(py)?, false))
        }
    }
}
