//! Questions about one model or two.

use crate::arrays::{list, pair_array, points, pose, poses};
use crate::errors::exception;
use crate::executor::{Backend, Device, Executor, PATIENCE};
use crate::model::Model;
use crate::part::starts;
use numpy::PyUntypedArray;
use pfront::pfront_core::bvtt::{Cursor, PairBvtt, Query, SelfBvtt};
use pfront::threads::rayon::prelude::*;
use pfront::{Adjacency, AnyPose, Batch, Contact, Error, Ticket, TrianglePair};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Tests that a question gets on the calling thread before other threads are called: about half a millisecond.
const ALONE: u64 = 1 << 14;
/// Tests between two looks at signals: about 5 ms.
const STEP: u64 = 1 << 17;
/// Poses that are asked about in one submission.
const CHUNK: usize = 1 << 14;
/// Contacts between two looks at signals.
const CONTACTS: usize = 1 << 13;

/// The subject of a question.
#[derive(Clone)]
enum Subject {
    Pair { models: [Arc<pfront::Model>; 2], a_from_b: AnyPose },
    Within { model: Arc<pfront::Model> },
}

/// The list of arrays that tell contacts: pairs, segments, normals and whether each is flat.
type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>);

impl Subject {
    fn new(a: &Model, b: Option<&Model>, array: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        Ok(match b {
            Some(b) => Self::Pair { models: [a.0.clone(), b.0.clone()], a_from_b: pose(array)? },
            None => Self::Within { model: a.0.clone() },
        })
    }

    fn is_f64(&self) -> bool {
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
    fn with<R>(&self, ask: impl Ask<R>) -> Result<R, Error> {
        match self {
            Self::Pair { models: [a, b], a_from_b } => ask.ask(&match a_from_b {
                AnyPose::F32(pose) => PairBvtt::new(a.bvh(), b.bvh(), *pose)?,
                AnyPose::F64(pose) => PairBvtt::in_f64(a.bvh(), b.bvh(), pose)?,
            }),
            Self::Within { model } => {
                let query = SelfBvtt::new(model.bvh()).with_certificates(model.certificates());
                if model.is_f64() {
                    ask.ask(&query)
                } else {
                    ask.ask(&query.with_patches(model.patches()))
                }
            }
        }
    }
}

/// A function of any BVTT.
trait Ask<R> {
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
fn wait<T: Send>(py: Python<'_>, mut ticket: Ticket<T>) -> PyResult<T> {
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
fn together(py: Python<'_>, on: &Executor) -> PyResult<pfront::Executor> {
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

fn listed(
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

/// Where pairs meet, in their order.
struct Where<'s, C, F> {
    pairs: &'s [TrianglePair],
    on: &'s Executor,
    out: &'s mut Vec<(TrianglePair, C)>,
    contact: F,
}

/// Contacts in either precision.
trait Verb<C> {
    fn contact(self, query: &(impl Query + Sync), pair: TrianglePair) -> Option<C>;
}

#[derive(Clone, Copy)]
struct InF32;
#[derive(Clone, Copy)]
struct InF64;

impl Verb<Contact> for InF32 {
    fn contact(self, query: &(impl Query + Sync), pair: TrianglePair) -> Option<Contact> {
        query.contact(pair)
    }
}

impl Verb<Contact<f64>> for InF64 {
    fn contact(self, query: &(impl Query + Sync), pair: TrianglePair) -> Option<Contact<f64>> {
        query.contact_f64(pair)
    }
}

impl<C: Send, F: Verb<C> + Copy + Sync> Ask<()> for Where<'_, C, F> {
    fn ask(self, query: &(impl Query + Sync)) -> Result<(), Error> {
        let verb = self.contact;
        let contact = |&pair: &TrianglePair| Some((pair, verb.contact(query, pair)?));
        match self.on.pool() {
            Some(pool) if self.pairs.len() >= CONTACTS => pool.install(|| {
                self.out.par_extend(self.pairs.par_iter().with_min_len(512).filter_map(contact));
            }),
            _ => self.out.extend(self.pairs.iter().filter_map(contact)),
        }
        Ok(())
    }
}

fn located<C: Send, F: Verb<C> + Copy + Send + Sync>(
    py: Python<'_>,
    subject: &Subject,
    pairs: &[TrianglePair],
    on: &Executor,
    contact: F,
) -> PyResult<Vec<(TrianglePair, C)>> {
    let mut out = Vec::with_capacity(pairs.len());
    for pairs in pairs.chunks(CONTACTS) {
        let ask = Where { pairs, on, out: &mut out, contact };
        py.detach(|| subject.with(ask)).map_err(|error| exception(py, error, None))?;
        py.check_signals()?;
    }
    Ok(out)
}

/// Where pairs meet, and how they face.
#[pyfunction]
pub fn contacts(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
) -> PyResult<Arrays> {
    let subject = Subject::new(a, b, pose.as_ref())?;
    let pairs = listed(py, &subject, on, None)?;
    if subject.is_f64() {
        contact_arrays(py, located(py, &subject, &pairs, on, InF64)?)
    } else {
        contact_arrays(py, located(py, &subject, &pairs, on, InF32)?)
    }
}

pub(crate) fn contact_arrays<C: numpy::Element + Copy>(
    py: Python<'_>,
    found: Vec<(TrianglePair, Contact<C>)>,
) -> PyResult<Arrays> {
    Ok((
        pair_array(py, found.iter().map(|&(pair, _)| pair).collect())?,
        points(py, found.iter().map(|(_, contact)| contact.segment).collect())?,
        points(py, found.iter().map(|(_, contact)| contact.normals).collect())?,
        list(py, found.iter().map(|(_, contact)| contact.is_flat).collect()),
    ))
}

/// Asks about many poses, in chunks of which progress is told.
fn many<T: Send>(
    py: Python<'_>,
    (a, b): (&Model, &Model),
    array: &Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    verb: fn(&mut Batch, &pfront::Executor) -> Result<Ticket<T>, Error>,
    mut read: impl FnMut(T),
) -> PyResult<()> {
    let poses = poses(array)?;
    let executor = together(py, on)?;
    let mut batch = Batch::new();
    let mut done = 0;
    for chunk in poses.chunks(CHUNK) {
        let start = || {
            batch.clear();
            for (i, pose) in chunk.iter().enumerate() {
                batch.pair(&a.0, &b.0, pose).map_err(|error| (error, Some(done + i)))?;
            }
            verb(&mut batch, &executor).map_err(|error| (error, None))
        };
        let ticket = py.detach(start).map_err(|(error, pose)| exception(py, error, pose))?;
        read(wait(py, ticket)?);
        done += chunk.len();
        if let Some(progress) = &progress {
            progress.call1((done, poses.len()))?;
        }
    }
    Ok(())
}

/// For each pose, whether some pair meets.
#[pyfunction]
pub fn batch_any(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    poses: Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let mut found = Vec::<bool>::new();
    many(py, (a, b), &poses, on, progress, Batch::any, |answers| {
        found.extend(answers.iter().map(Option::is_some));
    })?;
    Ok(list(py, found))
}

/// For each pose, the number of pairs that meet.
#[pyfunction]
pub fn batch_count(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    poses: Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Py<PyAny>> {
    let mut counts = Vec::<i64>::new();
    many(py, (a, b), &poses, on, progress, Batch::count, |answers| {
        counts.extend(answers.iter().map(|&count| count as i64));
    })?;
    Ok(list(py, counts))
}

/// The pairs that meet for all poses, and where those of each begin and end.
#[pyfunction]
pub fn batch_all(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    poses: Bound<'_, PyUntypedArray>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
    let (mut pairs, mut offsets) = (Vec::new(), vec![0_i64]);
    many(py, (a, b), &poses, on, progress, Batch::all, |lists| {
        let first = pairs.len();
        let ends = lists.iter().scan(first, |end, list| {
            *end += list.len();
            Some(*end as i64)
        });
        offsets.extend(ends);
        pairs.extend_from_slice(lists.pairs());
    })?;
    Ok((pair_array(py, pairs)?, list(py, offsets)))
}
