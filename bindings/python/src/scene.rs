//! Scenes: many bodies in the world.

use crate::arrays::{list, numbers, pair_array, table};
use crate::contacts::contact_arrays;
use crate::errors::{self, exception};
use crate::executor::{Device, Executor, PATIENCE, lock};
use crate::model::Model;
use crate::poses::Poses;
use crate::watchdog::{BUDGET, WatchdogGuard};
use numpy::PyReadonlyArrayDyn;
use pfront::{BodyId, Contact, Error, SceneHit, SceneQuery, TrianglePair};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Instant;
use std::{process, thread};

/// A query and whom it asks.
#[derive(Default)]
struct State {
    query: SceneQuery,
    /// The process and the id of the executor, as the query was told.
    on: Option<(u32, u64)>,
}

/// Bodies in poses. One thread at a time uses it; others wait.
#[pyclass(frozen, module = "pfront._pfront")]
pub struct Scene {
    state: Arc<Mutex<State>>,
    cancel: Arc<AtomicBool>,
    /// Whether the last question was long.
    is_long: Arc<AtomicBool>,
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self { state: Arc::default(), cancel: Arc::default(), is_long: Arc::default() }
    }

    /// Adds a body for each pose and returns their ids. There are as many user ids, or one for all.
    fn add(
        &self,
        py: Python<'_>,
        model: &Model,
        pose: Option<Bound<'_, PyAny>>,
        user_ids: Option<PyReadonlyArrayDyn<'_, i64>>,
    ) -> PyResult<Py<PyAny>> {
        let (model, poses) = (model.0.clone(), Poses::new(py, pose.as_ref())?);
        let is_one = matches!(poses, Poses::One(_));
        let poses = poses.into_list();
        let user_ids = user_ids.as_ref().map(numbers).transpose()?;
        if let Some(given) = user_ids.as_ref().map(Vec::len)
            && given != 1
            && given != poses.len()
        {
            let text = format!("{given} user ids were given for {} poses", poses.len());
            return Err(errors::poses(text));
        }
        let mut ids = Vec::with_capacity(poses.len());
        let added = self.edit_each(py, is_one, |query, i| {
            let Some(&pose) = poses.get(i) else { return Ok(false) };
            let id = query.add(model.clone(), pose)?;
            ids.push(id.to_bits() as i64);
            let user_id = user_ids.as_ref().and_then(|given| given.get(i).or(given.first()));
            query.set_user_data(id, user_id.map_or(id.to_bits(), |&user_id| user_id as u64))?;
            Ok(true)
        });
        if let Err(error) = added {
            // All or none.
            self.edit(py, |query| {
                ids.iter().try_for_each(|&id| query.remove(BodyId::from_bits(id as u64)).map(drop))
            })?;
            return Err(error);
        }
        match ids.first() {
            Some(id) if is_one => Ok(id.into_pyobject(py)?.into_any().unbind()),
            _ => Ok(list(py, ids)),
        }
    }

    /// The user ids of bodies.
    fn user_ids(&self, py: Python<'_>, ids: PyReadonlyArrayDyn<'_, u64>) -> PyResult<Py<PyAny>> {
        let ids = numbers(&ids)?;
        let found = self.edit(py, |query| {
            let user_id = |&id: &u64| Ok(query.body(BodyId::from_bits(id))?.user_data() as i64);
            ids.iter().map(user_id).collect()
        })?;
        Ok(list(py, found))
    }

    /// Gives a body another model.
    fn set_model(&self, py: Python<'_>, id: u64, model: &Model) -> PyResult<()> {
        let model = model.0.clone();
        self.edit(py, |query| query.set_model(BodyId::from_bits(id), model))
    }

    /// Takes a body out.
    fn remove(&self, py: Python<'_>, id: u64) -> PyResult<()> {
        self.edit(py, |query| query.remove(BodyId::from_bits(id)).map(drop))
    }

    /// Moves bodies, one pose each.
    fn set_poses(
        &self,
        py: Python<'_>,
        ids: PyReadonlyArrayDyn<'_, u64>,
        poses: Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (ids, poses) = (numbers(&ids)?, Poses::new(py, Some(&poses))?);
        let is_one = matches!(poses, Poses::One(_));
        let poses = poses.into_list();
        if ids.len() != poses.len() {
            let text = format!("{} poses were given for {} bodies", poses.len(), ids.len());
            return Err(errors::poses(text));
        }
        let ids: Vec<_> = ids.into_iter().map(BodyId::from_bits).collect();
        self.edit_each(py, is_one, |query, i| match (ids.get(i), poses.get(i)) {
            (Some(&id), Some(&pose)) => query.set_pose(id, pose).map(|()| true),
            _ => Ok(false),
        })
    }

    /// Ignores two bodies, or no longer.
    fn ignore(&self, py: Python<'_>, a: u64, b: u64, ignored: bool) -> PyResult<()> {
        let [a, b] = [a, b].map(BodyId::from_bits);
        self.edit(py, |query| query.ignore(a, b, ignored))
    }

    /// The number of bodies.
    fn len(&self, py: Python<'_>) -> usize {
        py.detach(|| lock(&self.state).query.len())
    }

    /// Bodies of each pair of triangles that meets, and these.
    fn pairs(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
        let (bodies, pairs) = self.ask(py, on, |query| {
            let hits = query.all()?;
            let bodies: Vec<i64> = hits.iter().flat_map(of_hit).collect();
            Ok((bodies, hits.iter().map(|hit| hit.pair).collect::<Vec<TrianglePair>>()))
        })?;
        Ok((table(py, bodies, pairs.len(), 2)?, pair_array(py, pairs)?))
    }

    /// The number of pairs of triangles that meet.
    fn count(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<u64> {
        self.ask(py, on, SceneQuery::count)
    }

    /// Whether some pair meets.
    fn any(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<bool> {
        Ok(self.ask(py, on, SceneQuery::any)?.is_some())
    }

    /// Bodies that meet.
    fn body_pairs(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<Py<PyAny>> {
        let pairs = self.ask(py, on, SceneQuery::body_pairs)?;
        let flat = pairs.iter().flatten().map(|id| id.to_bits() as i64).collect();
        table(py, flat, pairs.len(), 2)
    }

    /// Bodies of each pair that meets, and where: see `contacts`.
    #[expect(clippy::type_complexity, reason = "a tuple of five arrays")]
    fn contacts(
        &self,
        py: Python<'_>,
        on: &Bound<'_, Executor>,
    ) -> PyResult<(Py<PyAny>, (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>))> {
        let (bodies, found) = self.ask(py, on, |query| {
            let is_f64 = query.bodies().any(|body| body.model().is_f64() || body.pose().is_f64());
            Ok(if is_f64 {
                let contacts = query.contacts_f64()?;
                (bodies_of(&contacts), Found::F64(pairs_of(&contacts)))
            } else {
                let contacts = query.contacts()?;
                (bodies_of(contacts), Found::F32(pairs_of(contacts)))
            })
        })?;
        let bodies = table(py, bodies.0, bodies.1, 2)?;
        let found = match found {
            Found::F32(found) => contact_arrays(py, found)?,
            Found::F64(found) => contact_arrays(py, found)?,
        };
        Ok((bodies, found))
    }
}

/// Contacts in the precision of the scene.
enum Found {
    F32(Vec<(TrianglePair, Contact)>),
    F64(Vec<(TrianglePair, Contact<f64>)>),
}

/// The bodies of all hits in turn, and how many hits there are.
fn bodies_of<C>(contacts: &[(SceneHit, C)]) -> (Vec<i64>, usize) {
    (contacts.iter().flat_map(|(hit, _)| of_hit(hit)).collect(), contacts.len())
}

fn pairs_of<C: Copy>(contacts: &[(SceneHit, C)]) -> Vec<(TrianglePair, C)> {
    contacts.iter().map(|&(hit, contact)| (hit.pair, contact)).collect()
}

/// Ids as NumPy's own integers; none is ever as large as the sign.
fn of_hit(hit: &SceneHit) -> [i64; 2] {
    hit.bodies.map(|id| id.to_bits() as i64)
}

impl Scene {
    fn edit<T: Send>(
        &self,
        py: Python<'_>,
        edit: impl FnOnce(&mut SceneQuery) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        let edited = py.detach(|| edit(&mut lock(&self.state).query));
        edited.map_err(|error| exception(py, error, None))
    }

    /// Edits until there is nothing left to do; an error tells at which index, unless there is one only.
    fn edit_each(
        &self,
        py: Python<'_>,
        is_one: bool,
        mut edit: impl FnMut(&mut SceneQuery, usize) -> Result<bool, Error> + Send,
    ) -> PyResult<()> {
        let edited = py.detach(|| {
            let query = &mut lock(&self.state).query;
            for i in 0.. {
                if !edit(query, i).map_err(|error| (error, i))? {
                    break;
                }
            }
            Ok(())
        });
        edited.map_err(|(error, i)| exception(py, error, (!is_one).then_some(i)))
    }

    /// Asks on this thread; if that takes long, on a thread of its own while this one hears signals.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        on: &Bound<'_, Executor>,
        ask: impl Fn(&mut SceneQuery) -> Result<T, Error> + Copy + Send + Sync + 'static,
    ) -> PyResult<T> {
        let own = on.get();
        let executor = py.detach(|| own.on_device())?;
        let attempt = Attempt {
            id: (process::id(), own.id),
            executor: executor.with_cancel(self.cancel.clone()),
            cancel: self.cancel.clone(),
        };
        if own.device == Device::Cpu
            && !self.is_long.load(Relaxed)
            && let Some(watched) = WatchdogGuard::new(&self.cancel)
        {
            let answered = py.detach(|| {
                let state = &mut *self.state.try_lock().ok()?;
                let answered = attempt.ask(state, ask);
                // The next question about the scene, which has the same flag, waits for the lock until then.
                drop(watched);
                (!matches!(answered.0, Err(Error::Cancelled))).then_some(answered)
            });
            match answered {
                Some(answered) => return into_result(py, own, answered),
                None => py.check_signals()?,
            }
        }
        self.ask_on_thread(py, own, attempt, ask)
    }

    /// Asks on a thread of its own, while this one hears signals; one that raises ends the question.
    fn ask_on_thread<T: Send + 'static>(
        &self,
        py: Python<'_>,
        own: &Executor,
        attempt: Attempt,
        ask: impl Fn(&mut SceneQuery) -> Result<T, Error> + Copy + Send + 'static,
    ) -> PyResult<T> {
        loop {
            match self.try_on_thread(py, attempt.clone(), ask)? {
                // By the watchdog, for another thread, which had the same flag: nobody wants this one to end.
                (Err(Error::Cancelled), _) => py.check_signals()?,
                answered => return into_result(py, own, answered),
            }
        }
    }

    /// Asks on a thread of its own once.
    fn try_on_thread<T: Send + 'static>(
        &self,
        py: Python<'_>,
        attempt: Attempt,
        ask: impl Fn(&mut SceneQuery) -> Result<T, Error> + Send + 'static,
    ) -> PyResult<Answered<T>> {
        let (state, is_long) = (self.state.clone(), self.is_long.clone());
        let (tell, heard) = channel();
        // Nobody else waits for it: the lock is for the compiler, which knows receivers of one thread only.
        let heard = Mutex::new(heard);
        let worker = move || {
            let state = &mut *lock(&state);
            let began = Instant::now();
            let answered = attempt.ask(state, ask);
            is_long.store(began.elapsed() > BUDGET, Relaxed);
            // Nobody listens any more after a signal.
            let _ = tell.send(answered);
        };
        let started = thread::Builder::new().name("pfront scene".into()).spawn(worker);
        let worker = started.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        loop {
            match py.detach(|| lock(&heard).recv_timeout(PATIENCE)) {
                Ok(answered) => return Ok(answered),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = py.check_signals() {
                        self.cancel.store(true, Relaxed);
                        let _ = py.detach(|| worker.join());
                        return Err(signal);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err("a thread panicked while it answered"));
                }
            }
        }
    }
}

/// An answer, and who gave it.
type Answered<T> = (Result<T, Error>, Option<String>);

/// One attempt at a question: who answers it, and what ends it.
#[derive(Clone)]
struct Attempt {
    id: (u32, u64),
    executor: pfront::Executor,
    cancel: Arc<AtomicBool>,
}

impl Attempt {
    fn ask<T>(
        &self,
        state: &mut State,
        ask: impl Fn(&mut SceneQuery) -> Result<T, Error>,
    ) -> Answered<T> {
        let State { query, on } = state;
        self.cancel.store(false, Relaxed);
        if *on != Some(self.id) {
            *query = std::mem::take(query).on(&self.executor);
            *on = Some(self.id);
        }
        let answer = ask(query);
        (answer, query.plan().map(ToString::to_string))
    }
}

fn into_result<T>(py: Python<'_>, own: &Executor, (answer, plan): Answered<T>) -> PyResult<T> {
    own.note_plan(plan.unwrap_or_default());
    answer.map_err(|error| exception(py, error, None))
}
