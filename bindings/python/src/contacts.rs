//! Where pairs meet.

use crate::arrays::{list, pair_array, points};
use crate::errors::exception;
use crate::executor::Executor;
use crate::model::Model;
use crate::question::{Ask, Subject, listed};
use pfront::pfront_core::bvtt::Query;
use pfront::threads::rayon::prelude::*;
use pfront::{Contact, Error, TrianglePair};
use pyo3::prelude::*;

/// Contacts between two looks at signals.
const CONTACTS: usize = 1 << 13;

/// The list of arrays that tell contacts: pairs, segments, normals and whether each is flat.
type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>);

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
