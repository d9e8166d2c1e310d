//! Questions about one model or two.

use crate::arrays::{list, pair_array};
use crate::asking::{Answered, ask};
use crate::batch::PoseBatch;
use crate::errors::{self, exception};
use crate::executor::Executor;
use crate::memory;
use crate::model::Model;
use crate::part::{Part, PartQuery};
use crate::poses::Poses;
use crate::threads::apart;
use pfront::pfront_core::bvtt::{AnyBvtt, SelfBvtt};
use pfront::pfront_core::environment::with_default;
use pfront::{AnyPose, Batch, Distance, Error, PairQuery, SelfQuery, TrianglePair};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Triangles whose one-rings take longer to look at than signals may wait.
const RINGS: usize = 1 << 19;

/// How far apart triangles may be, 0 for those that intersect: the f32 that is not less than the number of Python, so that no
/// pair is missed.
#[derive(Clone, Copy, Default)]
pub(crate) struct Within(pub(crate) Distance);

impl FromPyObject<'_, '_> for Within {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let number = given.extract()?;
        let distance = with_default(|| Distance::at_least(number));
        distance.map(Self).map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

/// The distance that is asked for, as a number.
#[pyfunction]
pub fn at_least(distance: Within) -> f32 {
    distance.0.get()
}

/// The subject of a question.
#[derive(Clone)]
pub(crate) enum Subject {
    Pair { models: [Arc<pfront::Model>; 2], a_from_b: AnyPose, within: Distance },
    Itself { model: Arc<pfront::Model>, within: Distance },
}

/// Asks a verb about a subject, and makes of its answer what is told.
macro_rules! answered {
    ($subject:expr, $executor:expr, $verb:ident, $told:expr) => {
        match $subject {
            Subject::Pair { models: [a, b], a_from_b, within } => {
                let mut query = PairQuery::new().within(within.get())?.on($executor);
                let told = query.$verb(a, b, *a_from_b).and_then($told)?;
                Ok((told, query.plan().cloned()))
            }
            Subject::Itself { model, within } => {
                let mut query = SelfQuery::new().within(within.get())?.on($executor);
                let told = query.$verb(model).and_then($told)?;
                Ok((told, query.plan().cloned()))
            }
        }
    };
}
pub(crate) use answered;

impl Subject {
    pub(crate) fn is_f64(&self) -> bool {
        match self {
            Self::Pair { models, a_from_b, .. } => {
                a_from_b.is_f64() || models.iter().any(|model| model.is_f64())
            }
            Self::Itself { model, .. } => model.is_f64(),
        }
    }

    /// Asks about it.
    pub(crate) fn ask<T: Send + 'static>(
        self,
        py: Python<'_>,
        on: &Executor,
        question: impl Fn(&Self, &pfront::Executor) -> Answered<T> + Send + Sync + 'static,
    ) -> PyResult<T> {
        let triangles = |model: &pfront::Model| model.mesh().triangles().len();
        let is_long = matches!(&self, Self::Itself { model, .. } if triangles(model) > RINGS);
        ask(py, on, &Arc::default(), is_long, move |executor| question(&self, executor))
    }

    /// Asks about a part of it, which one thread answers.
    fn ask_part<T: Send + 'static>(
        self,
        py: Python<'_>,
        on: &Executor,
        part: Part,
        question: impl Fn(&PartQuery<'_>) -> Result<T, Error> + Send + Sync + 'static,
    ) -> PyResult<T> {
        let cancel = Arc::<AtomicBool>::default();
        let flag = cancel.clone();
        ask(py, on, &cancel, part.is_long(), move |_| {
            let answer = question(&PartQuery { tree: &self.tree()?, part, cancel: &flag })?;
            Ok((answer, None))
        })
    }

    /// The BVTT.
    pub(crate) fn tree(&self) -> Result<AnyBvtt<'_>, Error> {
        Ok(match self {
            Self::Pair { models: [a, b], a_from_b, within } => {
                AnyBvtt::Pair(a_from_b.pair([a.bvh(), b.bvh()])?.within(*within))
            }
            Self::Itself { model, within } => {
                let tree = SelfBvtt::new(model.bvh()).within(*within);
                AnyBvtt::Itself(tree.with_certificates(model.certificates()))
            }
        })
    }
}

/// A question about one BVTT, or about two models in many poses.
pub(crate) enum Question<'py> {
    One(Subject),
    Many(PoseBatch<'py>),
}

impl<'py> Question<'py> {
    pub(crate) fn new(
        py: Python<'py>,
        a: &Model,
        b: Option<&Model>,
        pose: Option<&Bound<'py, PyAny>>,
        progress: Option<Bound<'py, PyAny>>,
        within: Distance,
    ) -> PyResult<Self> {
        let Some(b) = b else {
            return match pose {
                None => Ok(Self::One(Subject::Itself { model: a.0.clone(), within })),
                Some(_) => Err(PyTypeError::new_err("a mesh with itself takes no pose")),
            };
        };
        let models = [a.0.clone(), b.0.clone()];
        Ok(match Poses::new(py, pose)? {
            Poses::One(a_from_b) => Self::One(Subject::Pair { models, a_from_b, within }),
            Poses::Many(poses) => Self::Many(PoseBatch { models, poses, progress, within }),
        })
    }
}

/// Whether some pair meets.
#[pyfunction]
pub fn any(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    within: Within,
) -> PyResult<Py<PyAny>> {
    match Question::new(py, a, b, pose.as_ref(), progress, within.0)? {
        Question::One(subject) => {
            let found = subject.ask(py, on, |subject, executor| {
                answered!(subject, executor, any, |hit: Option<_>| Ok(hit.is_some()))
            })?;
            Ok(PyBool::new(py, found).to_owned().into_any().unbind())
        }
        Question::Many(many) => {
            let mut found = Vec::<bool>::new();
            many.ask(py, on, Batch::any, |_, answers| {
                memory::extend(&mut found, answers.iter().map(Option::is_some))
                    .map_err(|error| exception(py, error, None))
            })?;
            Ok(list(py, found))
        }
    }
}

/// The first pair that is found, for one pose.
#[pyfunction]
pub fn first(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    within: Within,
) -> PyResult<Option<(u32, u32)>> {
    let Question::One(subject) = Question::new(py, a, b, pose.as_ref(), None, within.0)? else {
        return Err(errors::poses("one pair is found for one pose: ask in a loop".to_owned()));
    };
    subject.ask(py, on, |subject, executor| {
        answered!(subject, executor, any, |hit: Option<TrianglePair>| {
            Ok(hit.map(|pair| (pair.a, pair.b)))
        })
    })
}

/// The number of pairs that meet; of a part, if one is given.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "those of Python")]
pub fn count(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    part: Option<Part>,
    within: Within,
) -> PyResult<Py<PyAny>> {
    let count: u64 = match (Question::new(py, a, b, pose.as_ref(), progress, within.0)?, part) {
        (Question::One(subject), None) => {
            subject.ask(py, on, |subject, executor| answered!(subject, executor, count, Ok))?
        }
        (Question::One(subject), Some(part)) => subject.ask_part(py, on, part, |query| {
            let mut count = 0;
            query.visit(|_| {
                count += 1;
                Ok(())
            })?;
            Ok(count)
        })?,
        (Question::Many(_), Some(_)) => return Err(one_pose()),
        (Question::Many(many), None) => {
            let mut counts = Vec::<i64>::new();
            many.ask(py, on, Batch::count, |_, answers| {
                memory::extend(&mut counts, answers.iter().map(|&count| count as i64))
                    .map_err(|error| exception(py, error, None))
            })?;
            return Ok(list(py, counts));
        }
    };
    Ok(count.into_pyobject(py)?.into_any().unbind())
}

/// All pairs that meet, sorted; of a part, if one is given. For many poses also where those of each begin and end.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "those of Python")]
pub fn all(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    part: Option<Part>,
    within: Within,
) -> PyResult<(Py<PyAny>, Option<Py<PyAny>>)> {
    let pairs = match (Question::new(py, a, b, pose.as_ref(), progress, within.0)?, part) {
        (Question::One(subject), None) => subject
            .ask(py, on, |subject, executor| answered!(subject, executor, all, memory::copy))?,
        (Question::One(subject), Some(part)) => subject.ask_part(py, on, part, |query| {
            let mut pairs = Vec::new();
            query.visit(|pair| memory::push(&mut pairs, pair))?;
            pairs.sort_unstable();
            Ok(pairs)
        })?,
        (Question::Many(_), Some(_)) => return Err(one_pose()),
        (Question::Many(many), None) => {
            let (mut pairs, mut offsets) = (Vec::new(), vec![0_i64]);
            many.ask(py, on, Batch::all, |poses, lists| {
                let join = || {
                    memory::reserve(&mut offsets, poses.len())?;
                    let mut end = pairs.len();
                    offsets.extend(lists.iter().map(|list| {
                        end += list.len();
                        end as i64
                    }));
                    memory::extend(&mut pairs, lists.pairs().iter().copied())
                };
                apart(py, join).map_err(|error| exception(py, error, None))
            })?;
            return Ok((pair_array(py, pairs)?, Some(list(py, offsets))));
        }
    };
    Ok((pair_array(py, pairs)?, None))
}

fn one_pose() -> PyErr {
    PyTypeError::new_err("a part is of a question in one pose: sweeps divide poses")
}
