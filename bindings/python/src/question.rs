//! Questions about one model or two.

use crate::arrays::{list, pair_array};
use crate::batch::PoseBatch;
use crate::errors::exception;
use crate::executor::{Backend, Device, Executor, PATIENCE};
use crate::model::Model;
use crate::part::starts;
use crate::poses::Poses;
use pfront::pfront_core::bvtt::{Cursor, Query, SelfBvtt};
use pfront::{Adjacency, AnyPose, Batch, Error, Ticket, TrianglePair};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Tests that a question gets on the calling thread before other threads are called: about half a millisecond.
const ALONE: u64 = 1 << 14;
/// Tests between two looks at signals: about 5 ms.
const STEP: u64 = 1 << 17;

/// The subject of a question.
#[derive(Clone)]
pub(crate) enum Subject {
    Pair { models: [Arc<pfront::Model>; 2], a_from_b: AnyPose },
    Within { model: Arc<pfront::Model> },
}

impl Subject {
    pub(crate) fn is_f64(&self) -> bool {
        match self {
            Self::Pair { models, a_from_b } => {
                a_from_b.is_f64() || models.iter().any(|model| model.is_f64())
            }
            Self::Within { model } => model.is_f64(),
        }
    }

    fn add_to(&self, batch: &mut Batch) -> Result<(), Error> {
        match self {
            Self::Pair { models: [a, b], a_from_b } => batch.pair(a, b, a_from_b),
            Self::Within { model } => {
                batch.within(model, Adjacency::default());
                Ok(())
            }
        }
    }

    /// Calls a function with the BVTT.
    pub(crate) fn with<R>(&self, ask: impl Ask<R>) -> Result<R, Error> {
        match self {
            Self::Pair { models, a_from_b } => {
                ask.ask(&a_from_b.pair(models.each_ref().map(|model| model.bvh()))?)
            }
            Self::Within { model } => {
                ask.ask(&SelfBvtt::new(model.bvh()).with_certificates(model.certificates()))
            }
        }
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
    ) -> PyResult<Self> {
        let Some(b) = b else {
            return match pose {
                None => Ok(Self::One(Subject::Within { model: a.0.clone() })),
                Some(_) => Err(PyTypeError::new_err("a mesh with itself takes no pose")),
            };
        };
        let models = [a.0.clone(), b.0.clone()];
        Ok(match Poses::new(py, pose)? {
            Poses::One(a_from_b) => Self::One(Subject::Pair { models, a_from_b }),
            Poses::Many(poses) => Self::Many(PoseBatch { models, poses, progress }),
        })
    }
}

/// A function of any BVTT.
pub(crate) trait Ask<R> {
    fn ask(self, query: &(impl Query + Sync)) -> Result<R, Error>;
}

/// One step of a traversal on the calling thread.
struct Step<'s, V> {
    progress: &'s mut Option<Vec<Cursor>>,
    part: Option<(usize, usize)>,
    budget: u64,
    visit: &'s mut V,
}

impl<V: FnMut(TrianglePair) -> ControlFlow<()>> Ask<bool> for Step<'_, V> {
    /// Returns whether nothing is left.
    fn ask(self, query: &(impl Query + Sync)) -> Result<bool, Error> {
        let Self { progress, part, budget, visit } = self;
        let cursors = progress.get_or_insert_with(|| match part {
            None => vec![query.start()],
            Some((i, n)) => starts(query, i, n).into_iter().map(Cursor::at).collect(),
        });
        let mut left = budget;
        while let Some(cursor) = cursors.last_mut() {
            let before = cursor.work.box_tests + cursor.work.triangle_tests;
            if query.step(cursor, left, &mut *visit).is_break() {
                return Ok(true);
            }
            if !cursor.is_done() {
                return Ok(false);
            }
            let after = cursor.work.box_tests + cursor.work.triangle_tests;
            left = left.saturating_sub(after - before).max(1);
            cursors.pop();
        }
        Ok(true)
    }
}

/// Traverses on the calling thread, in steps between which signals are heard. Returns whether the traversal ended; with
/// several threads it does not where they are worth calling.
fn alone(
    py: Python<'_>,
    subject: &Subject,
    on: &Executor,
    part: Option<(usize, usize)>,
    mut visit: impl FnMut(TrianglePair) -> ControlFlow<()> + Send,
) -> PyResult<bool> {
    let (mut progress, is_alone) = (None, on.threads == 1 || part.is_some());
    loop {
        let budget = if is_alone { STEP } else { ALONE };
        let step =
            || subject.with(Step { progress: &mut progress, part, budget, visit: &mut visit });
        if py.detach(step).map_err(|error| exception(py, error, None))? {
            on.note(Backend::OneThread);
            return Ok(true);
        }
        py.check_signals()?;
        if !is_alone {
            return Ok(false);
        }
    }
}

/// Waits for a ticket, while signals are heard; a ticket that is dropped is cancelled.
pub(crate) fn wait<T: Send>(py: Python<'_>, mut ticket: Ticket<T>) -> PyResult<T> {
    loop {
        let answer = py.detach(|| ticket.wait(PATIENCE));
        if let Some(answer) = answer.map_err(|error| exception(py, error, None))? {
            return Ok(answer);
        }
        py.check_signals()?;
    }
}

/// Submits one question to threads or a GPU.
fn submit<T: Send>(
    py: Python<'_>,
    subject: &Subject,
    on: &Executor,
    verb: fn(&mut Batch, &pfront::Executor) -> Result<Ticket<T>, Error>,
) -> PyResult<T> {
    let executor = together(py, on)?;
    let mut batch = Batch::new();
    let mut start = || {
        subject.add_to(&mut batch)?;
        verb(&mut batch, &executor)
    };
    let ticket = py.detach(&mut start).map_err(|error| exception(py, error, None))?;
    wait(py, ticket)
}

/// The executor of questions that are submitted. Without earlier frames, "auto" is the CPU.
pub(crate) fn together(py: Python<'_>, on: &Executor) -> PyResult<pfront::Executor> {
    if on.device == Device::Gpu {
        on.note(Backend::Gpu);
        return py.detach(|| on.on_device());
    }
    on.note(if on.threads > 1 { Backend::Threads } else { Backend::OneThread });
    Ok(py.detach(|| on.on_cpu()))
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
) -> PyResult<Py<PyAny>> {
    let subject = match Question::new(py, a, b, pose.as_ref(), progress)? {
        Question::One(subject) => subject,
        Question::Many(many) => {
            let mut found = Vec::<bool>::new();
            many.ask(py, on, Batch::any, |_, answers| {
                found.extend(answers.iter().map(Option::is_some));
                Ok(())
            })?;
            return Ok(list(py, found));
        }
    };
    let mut found = false;
    let visit = |_| {
        found = true;
        ControlFlow::Break(())
    };
    if on.device == Device::Gpu || !alone(py, &subject, on, None, visit)? {
        found = submit(py, &subject, on, Batch::any)?.iter().any(Option::is_some);
    }
    Ok(PyBool::new(py, found).to_owned().into_any().unbind())
}

/// The number of pairs that meet; of a part, if one is given.
#[pyfunction]
pub fn count(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    part: Option<(usize, usize)>,
) -> PyResult<Py<PyAny>> {
    let subject = match (Question::new(py, a, b, pose.as_ref(), progress)?, part) {
        (Question::One(subject), _) => subject,
        (Question::Many(_), Some(_)) => return Err(one_pose()),
        (Question::Many(many), None) => {
            let mut counts = Vec::<i64>::new();
            many.ask(py, on, Batch::count, |_, answers| {
                counts.extend(answers.iter().map(|&count| count as i64));
                Ok(())
            })?;
            return Ok(list(py, counts));
        }
    };
    let mut count = 0_u64;
    let visit = |_| {
        count += 1;
        ControlFlow::Continue(())
    };
    let is_for_gpu = on.device == Device::Gpu && part.is_none();
    if is_for_gpu || !alone(py, &subject, on, part, visit)? {
        count = submit(py, &subject, on, Batch::count)?.iter().sum();
    }
    Ok(count.into_pyobject(py)?.into_any().unbind())
}

/// The pairs that meet, sorted; of a part, if one is given.
pub(crate) fn listed(
    py: Python<'_>,
    subject: &Subject,
    on: &Executor,
    part: Option<(usize, usize)>,
) -> PyResult<Vec<TrianglePair>> {
    let mut pairs = Vec::new();
    let visit = |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    };
    let is_for_gpu = on.device == Device::Gpu && part.is_none();
    if is_for_gpu || !alone(py, subject, on, part, visit)? {
        return Ok(submit(py, subject, on, Batch::all)?.pairs().to_vec());
    }
    py.detach(|| pairs.sort_unstable());
    Ok(pairs)
}

/// All pairs that meet, sorted; of a part, if one is given. For many poses also where those of each begin and end.
#[pyfunction]
pub fn all(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    part: Option<(usize, usize)>,
) -> PyResult<(Py<PyAny>, Option<Py<PyAny>>)> {
    match (Question::new(py, a, b, pose.as_ref(), progress)?, part) {
        (Question::One(subject), _) => Ok((pair_array(py, listed(py, &subject, on, part)?)?, None)),
        (Question::Many(_), Some(_)) => Err(one_pose()),
        (Question::Many(many), None) => {
            let (mut pairs, mut offsets) = (Vec::new(), vec![0_i64]);
            many.ask(py, on, Batch::all, |_, lists| {
                let first = pairs.len();
                let ends = lists.iter().scan(first, |end, list| {
                    *end += list.len();
                    Some(*end as i64)
                });
                offsets.extend(ends);
                pairs.extend_from_slice(lists.pairs());
                Ok(())
            })?;
            Ok((pair_array(py, pairs)?, Some(list(py, offsets))))
        }
    }
}

fn one_pose() -> PyErr {
    PyTypeError::new_err("a part is of a question in one pose: sweeps divide poses")
}
