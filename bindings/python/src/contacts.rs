//! Where pairs meet.

use crate::arrays::{list, pair_array, points};
use crate::batch::PoseBatch;
use crate::errors::exception;
use crate::executor::Executor;
use crate::model::Model;
use crate::question::{Ask, Question, Subject, listed};
use pfront::pfront_core::bvtt::Query;
use pfront::threads::rayon::prelude::*;
use pfront::{AnyPose, Batch, Contact, Error, PairLists, TrianglePair};
use pyo3::prelude::*;

/// Contacts between two looks at signals.
const CONTACTS: usize = 1 << 13;

/// The list of arrays that tell contacts: pairs, segments, normals and whether each is flat.
type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>);

/// Pairs with their contacts.
type Found<C> = Vec<(TrianglePair, C)>;

/// Where pairs meet, in their order.
struct Where<'s, C, F> {
    pairs: &'s [TrianglePair],
    /// The threads, if the pairs are many.
    on: Option<&'s Executor>,
    out: &'s mut Found<C>,
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
        match self.on.and_then(Executor::pool) {
            Some(pool) => pool.install(|| {
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
) -> PyResult<Found<C>> {
    let mut out = Vec::with_capacity(pairs.len());
    for pairs in pairs.chunks(CONTACTS) {
        let on = (pairs.len() >= CONTACTS).then_some(on);
        let ask = Where { pairs, on, out: &mut out, contact };
        py.detach(|| subject.with(ask)).map_err(|error| exception(py, error, None))?;
        py.check_signals()?;
    }
    Ok(out)
}

/// The contacts of many poses, and where those of each begin and end.
fn swept<C: Send, F: Verb<C> + Copy + Send + Sync>(
    py: Python<'_>,
    many: &PoseBatch<'_>,
    on: &Executor,
    contact: F,
) -> PyResult<(Found<C>, Vec<i64>)> {
    let (mut out, mut offsets) = (Vec::new(), vec![0]);
    let models = &many.models;
    many.ask(py, on, Batch::all, |poses, lists: PairLists| {
        let of_pose = |(&a_from_b, pairs): (&AnyPose, &[TrianglePair])| {
            let subject = Subject::Pair { models: models.clone(), a_from_b };
            let mut out = Vec::with_capacity(pairs.len());
            subject.with(Where { pairs, on: None, out: &mut out, contact })?;
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
            let found: Result<Vec<_>, Error> = py.detach(|| match on.pool() {
                Some(pool) if pairs >= CONTACTS && group.len() > 1 => {
                    pool.install(|| group.par_iter().copied().map(of_pose).collect())
                }
                _ => group.iter().copied().map(of_pose).collect(),
            });
            for contacts in found.map_err(|error| exception(py, error, None))? {
                out.extend(contacts);
                offsets.push(out.len() as i64);
            }
            py.check_signals()?;
        }
        Ok(())
    })?;
    Ok((out, offsets))
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
                contact_arrays(py, located(py, &subject, &pairs, on, InF64)?)?
            } else {
                contact_arrays(py, located(py, &subject, &pairs, on, InF32)?)?
            };
            Ok((arrays, None))
        }
        Question::Many(many) => {
            let (arrays, offsets) = if many.is_f64() {
                let (found, offsets) = swept(py, &many, on, InF64)?;
                (contact_arrays(py, found)?, offsets)
            } else {
                let (found, offsets) = swept(py, &many, on, InF32)?;
                (contact_arrays(py, found)?, offsets)
            };
            Ok((arrays, Some(list(py, offsets))))
        }
    }
}

pub(crate) fn contact_arrays<C: numpy::Element + Copy>(
    py: Python<'_>,
    found: Found<Contact<C>>,
) -> PyResult<Arrays> {
    Ok((
        pair_array(py, found.iter().map(|&(pair, _)| pair).collect())?,
        points(py, found.iter().map(|(_, contact)| contact.segment).collect())?,
        points(py, found.iter().map(|(_, contact)| contact.normals).collect())?,
        list(py, found.iter().map(|(_, contact)| contact.is_flat).collect()),
    ))
}
