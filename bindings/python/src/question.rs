//! Questions about one model or two.

use crate::arrays::{pair_array, pose};
use crate::errors::exception;
use crate::executor::{Backend, Device, Executor, PATIENCE};
use crate::model::Model;
use crate::part::starts;
use pfront::pfront_core::bvtt::{Cursor, Query, SelfBvtt};
use pfront::{Adjacency, AnyPose, Batch, Error, Ticket, TrianglePair};
use pyo3::prelude::*;
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
    pub(crate) fn new(
        a: &Model,
        b: Option<&Model>,
        array: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(match b {
            Some(b) => Self::Pair { models: [a.0.clone(), b.0.clone()], a_from_b: pose(array)? },
            None => Self::Within { model: a.0.clone() },
        })
    }

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
) -> PyResult<bool> {
    let subject = Subject::new(a, b, pose.as_ref())?;
    let mut found = false;
    if on.device != Device::Gpu {
        let visit = |_| {
            found = true;
            ControlFlow::Break(())
        };
        if alone(py, &subject, on, None, visit)? {
            return Ok(found);
        }
    }
    Ok(submit(py, &subject, on, Batch::any)?.iter().any(Option::is_some))
}

/// The number of pairs that meet.
#[pyfunction]
pub fn count(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    part: Option<(usize, usize)>,
) -> PyResult<u64> {
    let subject = Subject::new(a, b, pose.as_ref())?;
    if on.device != Device::Gpu || part.is_some() {
        let mut count = 0;
        let visit = |_| {
            count += 1;
            ControlFlow::Continue(())
        };
        if alone(py, &subject, on, part, visit)? {
            return Ok(count);
        }
    }
    Ok(submit(py, &subject, on, Batch::count)?.iter().sum())
}

/// The pairs that meet, sorted.
pub(crate) fn listed(
    py: Python<'_>,
    subject: &Subject,
    on: &Executor,
    part: Option<(usize, usize)>,
) -> PyResult<Vec<TrianglePair>> {
    if on.device != Device::Gpu || part.is_some() {
        let mut pairs = Vec::new();
        let visit = |pair| {
            pairs.push(pair);
            ControlFlow::Continue(())
        };
        if alone(py, subject, on, part, visit)? {
            py.detach(|| pairs.sort_unstable());
            return Ok(pairs);
        }
    }
    Ok(submit(py, subject, on, Batch::all)?.pairs().to_vec())
}

/// All pairs that meet, sorted.
#[pyfunction]
pub fn all(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    part: Option<(usize, usize)>,
) -> PyResult<Py<PyAny>> {
    let subject = Subject::new(a, b, pose.as_ref())?;
    pair_array(py, listed(py, &subject, on, part)?)
}
