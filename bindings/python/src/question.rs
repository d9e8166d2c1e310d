//! Questions about one model or two.

use crate::arrays::{list, pair_array};
use crate::batch::PoseBatch;
use crate::errors::exception;
use crate::executor::{Device, Executor};
use crate::memory;
use crate::model::Model;
use crate::part::starts;
use crate::poses::Poses;
use crate::submission::Submission;
use crate::threads::{apart, heard};
use pfront::pfront_core::bvtt::{AnyBvtt, Cursor, Query, SelfBvtt};
use pfront::{Adjacency, AnyPose, Batch, Error, Ticket, TrianglePair};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Tests that a question gets on the calling thread before other threads are called: about half a millisecond.
const ALONE: u64 = 1 << 14;
/// Tests between the first two looks at signals, and the fewest: less than a millisecond, of coplanar triangles some more.
const STEP: u64 = 1 << 12;
/// The time between two looks at signals, to which the number of tests follows.
const PAUSE: Duration = Duration::from_millis(4);
/// Pairs that are sorted on a thread of their own, since that takes longer than signals may wait.
const SORTED: usize = 1 << 18;
/// Parts whose node pairs are found on a thread of their own.
const PARTS: usize = 1 << 10;
/// Triangles whose one-rings are looked at on a thread of their own.
const RINGS: usize = 1 << 19;

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

    /// Whether a GPU is not asked: about a model in float64 and itself.
    fn is_for_cpu(&self) -> bool {
        matches!(self, Self::Within { model } if model.is_f64())
    }

    /// Makes what is made once for a model and takes long, while signals are heard.
    fn prepare(&self, py: Python<'_>) -> PyResult<()> {
        match self {
            Self::Within { model } if model.mesh().triangles().len() > RINGS => {
                let model = model.clone();
                heard(py, &Arc::default(), move || {
                    let _ = model.certificates();
                })
            }
            _ => Ok(()),
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

    /// The BVTT.
    pub(crate) fn tree(&self) -> Result<AnyBvtt<'_>, Error> {
        Ok(match self {
            Self::Pair { models, a_from_b } => {
                AnyBvtt::Pair(a_from_b.pair(models.each_ref().map(|model| model.bvh()))?)
            }
            Self::Within { model } => {
                let tree = SelfBvtt::new(model.bvh());
                AnyBvtt::Within(tree.with_certificates(model.certificates()))
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

/// The node pairs of a part, or the root.
fn cursors(subject: &Subject, part: Option<(usize, usize)>) -> Result<Vec<Cursor>, Error> {
    let tree = subject.tree()?;
    match part {
        None => memory::collect([tree.start()].into_iter()),
        Some((i, n)) => memory::collect(starts(&tree, i, n)?.into_iter().map(Cursor::at)),
    }
}

/// One step of a traversal on the calling thread. Returns whether nothing is left.
fn step(
    tree: &AnyBvtt<'_>,
    cursors: &mut Vec<Cursor>,
    budget: u64,
    visit: &mut impl FnMut(TrianglePair) -> ControlFlow<()>,
) -> bool {
    let mut left = budget;
    while let Some(cursor) = cursors.last_mut() {
        let before = cursor.work.tests();
        if tree.step(cursor, left, &mut *visit).is_break() {
            return true;
        }
        if !cursor.is_done() {
            return false;
        }
        let after = cursor.work.tests();
        left = left.saturating_sub(after - before).max(1);
        cursors.pop();
    }
    true
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
    if let Some((i, n)) = part
        && i >= n
    {
        return Err(PyValueError::new_err(format!("part {i} of {n} is none")));
    }
    subject.prepare(py)?;
    let cursors = if part.is_some_and(|(_, n)| n > PARTS) {
        let subject = subject.clone();
        heard(py, &Arc::default(), move || cursors(&subject, part))?
    } else {
        apart(py, || cursors(subject, part))
    };
    let mut cursors = cursors.map_err(|error| exception(py, error, None))?;
    let is_alone = on.threads == 1 || part.is_some();
    let mut budget = if is_alone { STEP } else { ALONE };
    loop {
        let began = Instant::now();
        let step = || Ok(step(&subject.tree()?, &mut cursors, budget, &mut visit));
        if apart(py, step).map_err(|error| exception(py, error, None))? {
            on.note(BEGAN.into());
            return Ok(true);
        }
        py.check_signals()?;
        if !is_alone {
            return Ok(false);
        }
        budget = if began.elapsed() < PAUSE { 2 * budget } else { (budget / 2).max(STEP) };
    }
}

/// The answer to who has answered where the calling thread has.
const BEGAN: &str = "one thread: the question ended before others were worth calling";

/// Submits one question to threads or a GPU.
fn submit<T: Send>(
    py: Python<'_>,
    subject: &Subject,
    on: &Executor,
    verb: fn(&mut Batch, &pfront::Executor) -> Result<Ticket<T>, Error>,
) -> PyResult<T> {
    let to = Submission::new(py, on, subject.is_for_cpu())?;
    let mut batch = Batch::new();
    let mut start = || {
        subject.add_to(&mut batch)?;
        verb(&mut batch, &to.executor)
    };
    let ticket = apart(py, &mut start).map_err(|error| exception(py, error, None))?;
    to.wait(py, on, ticket)
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
                memory::extend(&mut found, answers.iter().map(Option::is_some))
                    .map_err(|error| exception(py, error, None))
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
                memory::extend(&mut counts, answers.iter().map(|&count| count as i64))
                    .map_err(|error| exception(py, error, None))
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
    let raised = |error| exception(py, error, None);
    let (mut pairs, mut failed) = (Vec::new(), None);
    let visit = |pair| match memory::push(&mut pairs, pair) {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            failed = Some(error);
            ControlFlow::Break(())
        }
    };
    let is_for_gpu = on.device == Device::Gpu && part.is_none();
    if is_for_gpu || !alone(py, subject, on, part, visit)? {
        let lists = submit(py, subject, on, Batch::all)?;
        return apart(py, || memory::copy(lists.pairs())).map_err(raised);
    }
    if let Some(error) = failed {
        return Err(raised(error));
    }
    if pairs.len() > SORTED {
        return heard(py, &Arc::default(), move || {
            pairs.sort_unstable();
            pairs
        });
    }
    apart(py, || pairs.sort_unstable());
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
            Ok((pair_array(py, pairs)?, Some(list(py, offsets))))
        }
    }
}

fn one_pose() -> PyErr {
    PyTypeError::new_err("a part is of a question in one pose: sweeps divide poses")
}
