//! Where pairs meet.

use crate::arrays::{list, pair_array, points};
use crate::batch::PoseBatch;
use crate::errors::exception;
use crate::executor::Executor;
use crate::memory::{push, reserve};
use crate::model::Model;
use crate::question::{Question, Subject, listed};
use crate::threads::apart;
use bytemuck::Pod;
use pfront::pfront_core::bvtt::{AnyBvtt, Query};
use pfront::threads::rayon::ThreadPool;
use pfront::threads::rayon::prelude::*;
use pfront::{AnyPose, Batch, Contact, Error, PairLists, TrianglePair};
use pyo3::prelude::*;
use std::sync::Arc;

/// Contacts between two looks at signals.
const CONTACTS: usize = 1 << 13;

/// The list of arrays that tell contacts: pairs, segments, normals and whether each is flat.
pub(crate) type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>);

/// Contacts as a struct of arrays.
pub(crate) struct Columns<C> {
    pairs: Vec<TrianglePair>,
    segments: Vec<[[C; 3]; 2]>,
    normals: Vec<[[f32; 3]; 2]>,
    flat: Vec<bool>,
}

impl<C> Default for Columns<C> {
    fn default() -> Self {
        Self { pairs: Vec::new(), segments: Vec::new(), normals: Vec::new(), flat: Vec::new() }
    }
}

impl<C: Copy> Columns<C> {
    pub(crate) fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Makes room for more contacts.
    pub(crate) fn reserve(&mut self, more: usize) -> Result<(), Error> {
        reserve(&mut self.pairs, more)?;
        reserve(&mut self.segments, more)?;
        reserve(&mut self.normals, more)?;
        reserve(&mut self.flat, more)
    }

    pub(crate) fn push(&mut self, pair: TrianglePair, contact: &Contact<C>) -> Result<(), Error> {
        push(&mut self.pairs, pair)?;
        push(&mut self.segments, contact.segment)?;
        push(&mut self.normals, contact.normals)?;
        push(&mut self.flat, contact.is_flat)
    }

    fn extend(&mut self, found: &[Found<C>]) -> Result<(), Error> {
        self.reserve(found.len())?;
        found.iter().flatten().try_for_each(|(pair, contact)| self.push(*pair, contact))
    }
}

impl<C: numpy::Element + Pod> Columns<C> {
    pub(crate) fn into_arrays(self, py: Python<'_>) -> PyResult<Arrays> {
        Ok((
            pair_array(py, self.pairs)?,
            points(py, self.segments)?,
            points(py, self.normals)?,
            list(py, self.flat),
        ))
    }
}

/// A pair and where it meets, if it does.
type Found<C> = Option<(TrianglePair, Contact<C>)>;

/// Where two triangles meet, in either precision.
type ContactOf<C> = fn(&AnyBvtt<'_>, TrianglePair) -> Option<Contact<C>>;

/// Finds where pairs meet, in their order, on threads if there are some.
fn find<C: Send>(
    subject: &Subject,
    pairs: &[TrianglePair],
    pool: Option<&ThreadPool>,
    contact: ContactOf<C>,
    out: &mut Vec<Found<C>>,
) -> Result<(), Error> {
    out.clear();
    reserve(out, pairs.len())?;
    let tree = subject.tree()?;
    let contact = |&pair: &TrianglePair| Some((pair, contact(&tree, pair)?));
    match pool {
        Some(pool) => pool.install(|| {
            pairs.par_iter().with_min_len(512).map(contact).collect_into_vec(out);
        }),
        None => out.extend(pairs.iter().map(contact)),
    }
    Ok(())
}

/// Adds the contacts of one subject, while signals are heard.
fn locate<C: Copy + Send>(
    py: Python<'_>,
    columns: &mut Columns<C>,
    subject: &Subject,
    pairs: &[TrianglePair],
    pool: Option<&ThreadPool>,
    contact: ContactOf<C>,
) -> PyResult<()> {
    let mut out = Vec::new();
    apart(py, || columns.reserve(pairs.len())).map_err(|error| exception(py, error, None))?;
    for pairs in pairs.chunks(CONTACTS) {
        let pool = pool.filter(|_| pairs.len() >= CONTACTS);
        let locate = || {
            find(subject, pairs, pool, contact, &mut out)?;
            columns.extend(&out)
        };
        apart(py, locate).map_err(|error| exception(py, error, None))?;
        py.check_signals()?;
    }
    Ok(())
}

/// The threads, unless they are at something long.
fn pool(py: Python<'_>, on: &Executor) -> Option<Arc<ThreadPool>> {
    let made = on.made(py);
    if made.is_busy() { None } else { made.pool }
}

/// The contacts of one subject.
fn located<C: Copy + Send>(
    py: Python<'_>,
    subject: &Subject,
    pairs: &[TrianglePair],
    on: &Executor,
    contact: ContactOf<C>,
) -> PyResult<Columns<C>> {
    let mut columns = Columns::default();
    locate(py, &mut columns, subject, pairs, pool(py, on).as_deref(), contact)?;
    Ok(columns)
}

/// The contacts of many poses, and where those of each begin and end.
fn swept<C: Copy + Send>(
    py: Python<'_>,
    many: &PoseBatch<'_>,
    on: &Executor,
    contact: ContactOf<C>,
) -> PyResult<(Columns<C>, Vec<i64>)> {
    let (mut columns, mut offsets) = (Columns::default(), vec![0]);
    let (models, pool) = (&many.models, pool(py, on));
    many.ask(py, on, Batch::all, |poses, lists: PairLists| {
        let of_pose = |(&a_from_b, pairs): (&AnyPose, &[TrianglePair])| {
            let subject = Subject::Pair { models: models.clone(), a_from_b };
            let mut out = Vec::new();
            find(&subject, pairs, None, contact, &mut out)?;
            Ok(out)
        };
        let questions: Vec<_> = poses.iter().zip(lists.iter()).collect();
        // A group has as many pairs as are located between two looks at signals, or one pose.
        let mut rest = &questions[..];
        while !rest.is_empty() {
            let mut pairs = 0;
            let count = rest.iter().take_while(|(_, list)| {
                let is_in = pairs < CONTACTS;
                pairs += list.len();
                is_in
            });
            let (group, later) = rest.split_at(count.count());
            rest = later;
            if let &[(&a_from_b, pairs)] = group {
                let subject = Subject::Pair { models: models.clone(), a_from_b };
                locate(py, &mut columns, &subject, pairs, pool.as_deref(), contact)?;
                let ended = push(&mut offsets, columns.len() as i64);
                ended.map_err(|error| exception(py, error, None))?;
                continue;
            }
            let group = || {
                let found: Result<Vec<_>, Error> = match &pool {
                    Some(pool) if pairs >= CONTACTS => {
                        pool.install(|| group.par_iter().copied().map(of_pose).collect())
                    }
                    _ => group.iter().copied().map(of_pose).collect(),
                };
                for contacts in found? {
                    columns.extend(&contacts)?;
                    push(&mut offsets, columns.len() as i64)?;
                }
                Ok(())
            };
            apart(py, group).map_err(|error| exception(py, error, None))?;
            py.check_signals()?;
        }
        Ok(())
    })?;
    Ok((columns, offsets))
}

/// Where pairs meet, and how they face. For many poses also where the contacts of each begin and end.
#[pyfunction]
pub fn contacts(
    py: Python<'_>,
    a: &Model,
    b: Option<&Model>,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Arrays, Option<Py<PyAny>>)> {
    match Question::new(py, a, b, pose.as_ref(), progress)? {
        Question::One(subject) => {
            let pairs = listed(py, &subject, on, None)?;
            let arrays = if subject.is_f64() {
                located(py, &subject, &pairs, on, |tree, pair| tree.contact_f64(pair))?
                    .into_arrays(py)?
            } else {
                located(py, &subject, &pairs, on, |tree, pair| tree.contact(pair))?
                    .into_arrays(py)?
            };
            Ok((arrays, None))
        }
        Question::Many(many) => {
            let (arrays, offsets) = if many.is_f64() {
                let (found, offsets) = swept(py, &many, on, |tree, pair| tree.contact_f64(pair))?;
                (found.into_arrays(py)?, offsets)
            } else {
                let (found, offsets) = swept(py, &many, on, |tree, pair| tree.contact(pair))?;
                (found.into_arrays(py)?, offsets)
            };
            Ok((arrays, Some(list(py, offsets))))
        }
    }
}
