//! Where pairs meet.

use crate::arrays::{list, pair_array, points};
use crate::asking::answer;
use crate::batch::PoseBatch;
use crate::errors::exception;
use crate::executor::Executor;
use crate::memory::{copy, push, reserve};
use crate::model::Model;
use crate::question::{Question, Subject, answered};
use bytemuck::Pod;
use pfront::pfront_core::bvtt::{AnyBvtt, Query};
use pfront::threads::rayon::ThreadPool;
use pfront::threads::rayon::prelude::*;
use pfront::{
    AnyPose, Batch, Contact, Distance, Error, PairLists, PairQuery, SelfQuery, TrianglePair,
};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Contacts from which on all threads look for them.
const MANY: usize = 1 << 13;
/// Contacts that one thread finds at a time, between two looks at the flag.
const BLOCK: usize = 1 << 9;

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
    /// Makes room for more contacts.
    fn reserve(&mut self, more: usize) -> Result<(), Error> {
        reserve(&mut self.pairs, more)?;
        reserve(&mut self.segments, more)?;
        reserve(&mut self.normals, more)?;
        reserve(&mut self.flat, more)
    }

    fn push(&mut self, pair: TrianglePair, contact: &Contact<C>) -> Result<(), Error> {
        push(&mut self.pairs, pair)?;
        push(&mut self.segments, contact.segment)?;
        push(&mut self.normals, contact.normals)?;
        push(&mut self.flat, contact.is_flat)
    }

    fn append(&mut self, mut more: Self) -> Result<(), Error> {
        if self.pairs.is_empty() {
            *self = more;
            return Ok(());
        }
        self.reserve(more.pairs.len())?;
        self.pairs.append(&mut more.pairs);
        self.segments.append(&mut more.segments);
        self.normals.append(&mut more.normals);
        self.flat.append(&mut more.flat);
        Ok(())
    }

    /// Adds the contacts of a list, whose items name pairs.
    fn extend<H>(
        &mut self,
        contacts: &[(H, Contact<C>)],
        pair: impl Fn(&H) -> TrianglePair,
    ) -> Result<(), Error> {
        self.reserve(contacts.len())?;
        contacts.iter().try_for_each(|(hit, contact)| self.push(pair(hit), contact))
    }

    /// The contacts of a list, whose items name pairs.
    pub(crate) fn of<H>(
        contacts: &[(H, Contact<C>)],
        pair: impl Fn(&H) -> TrianglePair,
    ) -> Result<Self, Error> {
        let mut columns = Self::default();
        columns.extend(contacts, pair)?;
        Ok(columns)
    }
}

/// Contacts in the precision of their question.
pub(crate) enum Found {
    F32(Columns<f32>),
    F64(Columns<f64>),
}

impl Found {
    pub(crate) fn into_arrays(self, py: Python<'_>) -> PyResult<Arrays> {
        match self {
            Self::F32(found) => found.into_arrays(py),
            Self::F64(found) => found.into_arrays(py),
        }
    }
}

impl<C: numpy::Element + Pod> Columns<C> {
    fn into_arrays(self, py: Python<'_>) -> PyResult<Arrays> {
        Ok((
            pair_array(py, self.pairs)?,
            points(py, self.segments)?,
            points(py, self.normals)?,
            list(py, self.flat),
        ))
    }
}

/// Where two triangles meet, in either precision.
type ContactOf<C> = fn(&AnyBvtt<'_>, TrianglePair) -> Option<Contact<C>>;

/// Two models in some poses, and which pairs meet in each.
struct Met {
    models: [Arc<pfront::Model>; 2],
    poses: Vec<AnyPose>,
    lists: PairLists,
}

impl Met {
    /// The contacts of one pose after the other, and how many each has.
    fn contacts<C: Copy + Send>(
        &self,
        pool: Option<&ThreadPool>,
        cancel: &AtomicBool,
        contact: ContactOf<C>,
    ) -> Result<(Columns<C>, Vec<usize>), Error> {
        let mut blocks = Vec::new();
        for (pose, list) in self.lists.iter().enumerate() {
            list.chunks(BLOCK).try_for_each(|pairs| push(&mut blocks, (pose, pairs)))?;
        }
        let locate = |&(pose, pairs): &(usize, &[TrianglePair])| {
            if cancel.load(Relaxed) {
                return Err(Error::Cancelled);
            }
            let (models, a_from_b) = (self.models.clone(), self.poses[pose]);
            let subject = Subject::Pair { models, a_from_b, within: Distance::default() };
            let (tree, mut found) = (subject.tree()?, Vec::new());
            reserve(&mut found, pairs.len())?;
            found.extend(pairs.iter().filter_map(|&pair| Some((pair, contact(&tree, pair)?))));
            Ok(found)
        };
        let mut found = Vec::new();
        reserve(&mut found, blocks.len())?;
        match pool {
            Some(pool) if self.lists.pairs().len() >= MANY => {
                pool.install(|| blocks.par_iter().map(locate).collect_into_vec(&mut found));
            }
            _ => found.extend(blocks.iter().map(locate)),
        }
        let (mut columns, mut counts) = (Columns::default(), Vec::new());
        reserve(&mut counts, self.poses.len())?;
        counts.resize(self.poses.len(), 0);
        for ((pose, _), found) in blocks.iter().zip(found) {
            let found = found?;
            columns.extend(&found, |&pair| pair)?;
            counts[*pose] += found.len();
        }
        Ok((columns, counts))
    }
}

/// The contacts of many poses, and where those of each begin and end.
fn swept<C: Copy + Send + 'static>(
    py: Python<'_>,
    many: &PoseBatch<'_>,
    on: &Executor,
    contact: ContactOf<C>,
) -> PyResult<(Columns<C>, Vec<i64>)> {
    let (mut columns, mut offsets) = (Columns::default(), vec![0]);
    let pool = on.made(py).pool;
    many.ask(py, on, Batch::all, |poses, lists| {
        let poses = copy(poses).map_err(|error| exception(py, error, None))?;
        let met = Met { models: many.models.clone(), poses, lists };
        let (pool, cancel) = (pool.clone(), Arc::<AtomicBool>::default());
        let (flag, is_long) = (cancel.clone(), met.lists.pairs().len() >= MANY);
        let question = move |_: &_| Ok((met.contacts(pool.as_deref(), &flag, contact)?, None));
        // The batch has told who answered.
        let ((found, counts), _) = answer(py, on, &cancel, is_long, question)?;
        let joined = columns.append(found).and_then(|()| {
            let mut end = offsets.last().copied().unwrap_or(0);
            counts.iter().try_for_each(|&count| {
                end += count as i64;
                push(&mut offsets, end)
            })
        });
        joined.map_err(|error| exception(py, error, None))
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
    // Pairs that are only near meet nowhere.
    let within = Distance::default();
    match Question::new(py, a, b, pose.as_ref(), progress, within)? {
        Question::One(subject) => {
            let found = subject.ask(py, on, |subject, executor| match subject.is_f64() {
                true => answered!(subject, executor, contacts_f64, |contacts: Vec<_>| {
                    Ok(Found::F64(Columns::of(&contacts, |&pair| pair)?))
                }),
                false => answered!(subject, executor, contacts, |contacts| {
                    Ok(Found::F32(Columns::of(contacts, |&pair| pair)?))
                }),
            })?;
            Ok((found.into_arrays(py)?, None))
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
