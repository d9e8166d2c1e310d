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

/// All relations, in the order of their codes; the code after the last is that of what is undetermined.
const RELATIONS: [Relation; 7] = [
    Relation::Apart,
    Relation::Near,
    Relation::Touching,
    Relation::Crossing,
    Relation::AInB,
    Relation::BInA,
    Relation::Equal,
];

/// The words of all relations, in the order of their codes.
#[pyfunction]
pub fn relations() -> Vec<&'static str> {
    RELATIONS.map(Relation::as_str).into()
}

/// The relation of a word.
pub(crate) fn of_word(word: &str) -> PyResult<Relation> {
    RELATIONS.into_iter().find(|relation| relation.as_str() == word).ok_or_else(|| {
        let words = RELATIONS.map(Relation::as_str).join(", ");
        PyValueError::new_err(format!("{word:?} is no relation; there are {words}"))
    })
}

fn code(relation: Option<Relation>) -> u8 {
    let found = RELATIONS.iter().position(|own| Some(*own) == relation);
    found.unwrap_or(RELATIONS.len()) as u8
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
    let question = Question { solids: solids(py, [a, b])?, within };
    let ask = |query: &mut PairQuery, [a, b]: [&Solid; 2], pose| {
        Ok(code(query.relation(a, b, pose)?.relation))
    };
    let (codes, is_one) = question.ask(py, pose, on, progress, ask)?;
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
    let question = Question { solids: solids(py, [a, b])?, within: Within::default() };
    for (solid, name) in question.solids.iter().zip(NAMES) {
        if let Some(pair) = solid.marked_pair() {
            return Err(not_solid(py, &NotSolid::MeetsItself { pair }, Some(name)));
        }
    }
    let ask = |query: &mut PairQuery, [a, b]: [&Solid; 2], pose| query.overlap_volume(a, b, pose);
    let (volumes, is_one) = question.ask(py, pose, on, progress, ask)?;
    let rows = volumes.len();
    Ok((table(py, volumes.into_flattened(), rows, 2)?, is_one))
}

/// The names of two meshes, as errors tell them.
const NAMES: [&str; 2] = ["a", "b"];

fn solids(py: Python<'_>, [a, b]: [&Model; 2]) -> PyResult<[Arc<Solid>; 2]> {
    Ok([a.solid(py, NAMES[0])?, b.solid(py, NAMES[1])?])
}

/// Two solids, and how far apart they are near.
struct Question {
    solids: [Arc<Solid>; 2],
    within: Within,
}

impl Question {
    /// Asks in each pose, of which several threads take some each, if there are several.
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
        let triangles = solids.each_ref().map(|solid| solid.model().mesh().triangles().len());
        let cancel = Arc::<AtomicBool>::default();
        let poses = match Poses::new(py, pose.as_ref())? {
            Poses::Many(poses) => poses,
            Poses::One(pose) => {
                let is_long = triangles[0].saturating_add(triangles[1]) >= MANY;
                let (told, plan) = answer(py, on, &cancel, is_long, move |executor| {
                    let mut query = PairQuery::new().within(within.get())?.on(executor);
                    let told = ask(&mut query, [&solids[0], &solids[1]], pose)?;
                    Ok((told, query.plan().cloned()))
                })?;
                on.note(plan.as_ref());
                return Ok((vec![told], true));
            }
        };
        let mut all = Vec::new();
        memory::reserve(&mut all, poses.len()).map_err(|error| exception(py, error, None))?;
        for (chunk, first) in poses.chunks(CHUNK).zip((0..).step_by(CHUNK)) {
            let (solids, chunk, flag) = (solids.clone(), chunk.to_vec(), cancel.clone());
            let pool = on.made(py).pool;
            let (told, _) = answer(py, on, &cancel, true, move |_| {
                let own = pfront::Executor::sequential().with_cancel(flag.clone());
                let start = || PairQuery::new().within(within.get()).map(|query| query.on(&own));
                let ask = |query: &mut Result<PairQuery, Error>, pose: &AnyPose| match query {
                    Ok(query) => ask(query, [&solids[0], &solids[1]], *pose),
                    Err(error) => Err(error.clone()),
                };
                let told: Vec<_> = match &pool {
                    Some(pool) => pool.install(|| chunk.par_iter().map_init(start, ask).collect()),
                    None => {
                        let mut query = start();
                        chunk.iter().map(|pose| ask(&mut query, pose)).collect()
                    }
                };
                let is_cancelled = |told: &Result<T, Error>| matches!(told, Err(Error::Cancelled));
                if told.iter().any(is_cancelled) { Err(Error::Cancelled) } else { Ok((told, None)) }
            })?;
            for (told, i) in told.into_iter().zip(first..) {
                all.push(told.map_err(|error| exception(py, error, Some(i)))?);
            }
            if let Some(progress) = &progress {
                let _inside = Inside::enter();
                progress.call1((all.len(), poses.len()))?;
            }
        }
        let are_several = poses.len() > 1 && on.made(py).pool.is_some();
        on.note_backend(if are_several { Backend::Threads } else { Backend::Sequential });
        Ok((all, false))
    }
}
