//! Relations of solids, and by how much they overlap.

use crate::arrays::{list, table};
use crate::asking::answer;
use crate::ending::Inside;
use crate::errors::{exception, not_solid};
use crate::executor::Executor;
use crate::memory;
use crate::model::{MANY, Model};
use crate::poses::Poses;
use crate::question::Within;
use pfront::executor::Backend;
use pfront::threads::rayon::prelude::*;
use pfront::{AnyPose, Error, NotSolid, PairQuery, Relation, Solid};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Poses that are asked about between two reports of how far the question has come.
const CHUNK: usize = 1 << 10;

/// The words of all relations, in the order of their codes; the code after the last is that of what is undetermined.
#[pyfunction]
pub fn relations() -> Vec<&'static str> {
    Relation::ALL.map(Relation::as_str).into()
}

/// The relation of a word.
pub(crate) fn of_word(word: &str) -> PyResult<Relation> {
    Relation::from_word(word).ok_or_else(|| {
        let words = relations().join(", ");
        PyValueError::new_err(format!("{word:?} is no relation; there are {words}"))
    })
}

fn code(relation: Option<Relation>) -> u8 {
    let found = Relation::ALL.iter().position(|own| Some(*own) == relation);
    found.unwrap_or(Relation::ALL.len()) as u8
}

/// The code of the relation of two solids in each pose; and whether one pose was given.
#[pyfunction]
pub fn relation(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
    within: Within,
) -> PyResult<(Py<PyAny>, bool)> {
    let two = Two { solids: solids(py, [a, b])?, within };
    let ask = |query: &mut PairQuery, [a, b]: [&Solid; 2], pose| {
        Ok(code(query.relation(a, b, pose)?.relation))
    };
    let (codes, is_one) = two.ask(py, pose, on, progress, ask)?;
    Ok((list(py, codes), is_one))
}

/// An interval that holds the volume of what two solids have in common, for each pose; and whether one pose was given.
#[pyfunction]
pub fn overlap_volume(
    py: Python<'_>,
    a: &Model,
    b: &Model,
    pose: Option<Bound<'_, PyAny>>,
    on: &Executor,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Py<PyAny>, bool)> {
    let two = Two { solids: solids(py, [a, b])?, within: Within::default() };
    let ask = |query: &mut PairQuery, [a, b]: [&Solid; 2], pose| query.overlap_volume(a, b, pose);
    let (volumes, is_one) = two.ask(py, pose, on, progress, ask)?;
    let rows = volumes.len();
    Ok((table(py, volumes.into_flattened(), rows, 2)?, is_one))
}

/// The names of two meshes, as errors tell them.
const NAMES: [&str; 2] = ["a", "b"];

fn solids(py: Python<'_>, [a, b]: [&Model; 2]) -> PyResult<[Arc<Solid>; 2]> {
    Ok([a.solid(py, NAMES[0])?, b.solid(py, NAMES[1])?])
}

/// The exception for an error about two solids, which names the one that meets itself.
fn refused(py: Python<'_>, error: Error, pose: Option<usize>, solids: &[Arc<Solid>; 2]) -> PyErr {
    match error {
        Error::Solid(why @ NotSolid::MeetsItself { pair }) => {
            let meets_so = |(solid, _): &(&Arc<Solid>, &str)| solid.marked_pair() == Some(pair);
            let named = solids.iter().zip(NAMES).find(meets_so);
            not_solid(py, &why, named.map(|(_, name)| name))
        }
        error => exception(py, error, pose),
    }
}

/// Two solids, and how far apart they are near.
struct Two {
    solids: [Arc<Solid>; 2],
    within: Within,
}

impl Two {
    /// Asks in each pose, of which several threads take some each, if there are several; and tells whether one pose was given.
    fn ask<T: Send + 'static>(
        self,
        py: Python<'_>,
        pose: Option<Bound<'_, PyAny>>,
        on: &Executor,
        progress: Option<Bound<'_, PyAny>>,
        ask: impl Fn(&mut PairQuery, [&Solid; 2], AnyPose) -> Result<T, Error>
        + Copy
        + Send
        + Sync
        + 'static,
    ) -> PyResult<(Vec<T>, bool)> {
        let Self { solids, within: Within(within) } = self;
        let (poses, is_one) = match Poses::new(py, pose.as_ref())? {
            Poses::One(pose) => (vec![pose], true),
            Poses::Many(poses) => (poses, false),
        };
        let [a, b] = solids.each_ref().map(|solid| solid.model().mesh().triangles().len());
        let is_long = !is_one || a.saturating_add(b) >= MANY;
        let cancel = Arc::<AtomicBool>::default();
        let (mut all, mut plan) = (Vec::new(), None);
        memory::reserve(&mut all, poses.len()).map_err(|error| exception(py, error, None))?;
        for chunk in poses.chunks(CHUNK) {
            let (both, chunk) = (solids.clone(), chunk.to_vec());
            let alone = pfront::Executor::sequential().with_cancel(cancel.clone());
            let pool = on.made(py).pool.filter(|_| !is_one);
            let told;
            (told, plan) = answer(py, on, &cancel, is_long, move |executor| {
                let own = if is_one { executor } else { &alone };
                let start = || PairQuery::new().within(within.get()).map(|query| query.on(own));
                let ask = |query: &mut Result<PairQuery, Error>, pose: &AnyPose| match query {
                    Ok(query) => ask(query, [&both[0], &both[1]], *pose),
                    Err(error) => Err(error.clone()),
                };
                let (told, plan): (Vec<_>, _) = match &pool {
                    Some(pool) => {
                        let told = pool.install(|| chunk.par_iter().map_init(start, ask).collect());
                        (told, None)
                    }
                    None => {
                        let mut query = start();
                        let told = chunk.iter().map(|pose| ask(&mut query, pose)).collect();
                        (told, query?.plan().cloned())
                    }
                };
                let is_cancelled = |told: &Result<T, Error>| matches!(told, Err(Error::Cancelled));
                if told.iter().any(is_cancelled) { Err(Error::Cancelled) } else { Ok((told, plan)) }
            })?;
            for told in told {
                let pose = (!is_one).then_some(all.len());
                all.push(told.map_err(|error| refused(py, error, pose, &solids))?);
            }
            if let Some(progress) = progress.as_ref().filter(|_| !is_one) {
                let _inside = Inside::enter();
                progress.call1((all.len(), poses.len()))?;
            }
        }
        if poses.len() > 1 && on.made(py).pool.is_some() {
            on.note_backend(Backend::Threads);
        } else {
            on.note(plan.as_ref());
        }
        Ok((all, is_one))
    }
}
