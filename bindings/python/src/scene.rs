//! Scenes: many bodies in the world.

use crate::arrays::{list, numbers, pair_array, table};
use crate::asking::ask;
use crate::contacts::{Arrays, Columns, Found};
use crate::distance;
use crate::errors::{self, exception};
use crate::executor::Executor;
use crate::memory;
use crate::model::Model;
use crate::mutex::{ProcessGuard, ProcessMutex};
use crate::poses::{Poses, one_for_each};
use crate::question::Within;
use crate::relation;
use crate::segment;
use crate::threads::apart;
use crate::watchdog::BUDGET;
use numpy::PyReadonlyArrayDyn;
use pfront::{
    Aabb, Adjacency, Allowed, AnyPose, BodyId, BodyOptions, CheckedPair, Distance, Error, Gap,
    Groups, NotSolid, Relation, SceneHit, SceneQuery, TrianglePair,
};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use std::{mem, process};

/// Edits between two looks at signals.
const EDITS: usize = 1 << 12;

/// A query and whom it asks.
#[derive(Default)]
struct State {
    query: SceneQuery,
    /// The process and the id of the executor, as the query was told.
    on: Option<(u32, u64)>,
    /// Whether the last question was long.
    is_long: bool,
}

impl State {
    /// Whether the threads and the device that it has asked are those of a parent.
    fn is_of_parent(&self) -> bool {
        self.on.is_some_and(|(process, _)| process != process::id())
    }

    /// Sees to it that this executor answers.
    fn turn_to(&mut self, id: (u32, u64), executor: &pfront::Executor) {
        if self.is_of_parent() {
            // A clone has what is known of the bodies, and nothing on a device.
            let known = self.query.clone();
            mem::forget(mem::replace(&mut self.query, known));
        }
        if self.on != Some(id) {
            self.query = mem::take(&mut self.query).on(executor);
            self.on = Some(id);
        }
    }
}

/// A query that has asked the threads or the device of a parent is left as it is.
impl Drop for State {
    fn drop(&mut self) {
        if self.is_of_parent() {
            mem::forget(mem::take(&mut self.query));
        }
    }
}

/// A body as Python is told of it: its id, its model, and the rows of its pose.
type Told = (u64, Model, [[f64; 4]; 3]);

/// A body that is no solid, and the exception that says why.
type Refused = (u64, Py<PyAny>);

/// A body that contains a point, with the code of its location.
type Located = (u64, u8);

/// An interval, if there is one.
type Interval = Option<(f64, f64)>;

/// A contact in numbers: its dimension, how many patches there are, and intervals of length and area.
type Size = (usize, usize, (f64, f64), (f64, f64));

/// Two bodies as a report tells of them: their ids, and the relation, whether it is allowed, whether the surfaces meet, the volume
/// in common, the contact, the gap, a pair of triangles, and a place.
type Checked = (
    (u64, u64),
    (
        Option<&'static str>,
        bool,
        bool,
        Interval,
        Option<Size>,
        Interval,
        Option<(u32, u32)>,
        Option<(f64, f64, f64)>,
    ),
);

fn told_of(found: &CheckedPair) -> Checked {
    let [a, b] = found.bodies.map(BodyId::to_bits);
    let interval = |interval: Option<[f64; 2]>| interval.map(|[low, high]| (low, high));
    let rest = (
        found.relation.map(Relation::as_str),
        found.is_allowed,
        found.meets,
        interval(found.overlap_volume),
        found
            .contact
            .map(|size| (size.dimension, size.patches, size.length.into(), size.area.into())),
        interval(found.gap),
        found.pair.map(|pair| (pair.a, pair.b)),
        found.place.map(|[x, y, z]| (x, y, z)),
    );
    ((a, b), rest)
}

/// Bodies in poses. One thread at a time uses it; others wait.
#[pyclass(frozen, module = "pfront._pfront")]
pub struct Scene {
    state: Arc<ProcessMutex<State>>,
    /// Ends the question of the thread that has locked the state, which alone sets and clears it.
    cancel: Arc<AtomicBool>,
}

#[pymethods]
impl Scene {
    /// A scene in which pairs are asked for that are at most so far apart.
    #[new]
    fn new(py: Python<'_>, within: Within) -> PyResult<Self> {
        let mut state = State::default();
        state.query.within(within.0.get()).map_err(|error| exception(py, error, None))?;
        Ok(Self { state: Arc::new(state.into()), cancel: Arc::default() })
    }

    /// Adds a body for each pose and returns their ids. There are as many user ids, or one for all. Each is asked about itself too,
    /// if that is wanted.
    fn add(
        &self,
        py: Python<'_>,
        model: &Model,
        pose: Option<Bound<'_, PyAny>>,
        user_ids: Option<PyReadonlyArrayDyn<'_, i64>>,
        itself: bool,
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
        let mut ids = Vec::new();
        memory::reserve(&mut ids, poses.len()).map_err(|error| exception(py, error, None))?;
        let state = self.state.lock(py)?;
        let added = edit_each(py, &state, poses.len(), is_one, |query, i| {
            let id = query.add(model.clone(), poses[i])?;
            ids.push(id.to_bits() as i64);
            let user_id = user_ids.as_ref().and_then(|given| given.get(i).or(given.first()));
            let user_data = user_id.map_or(id.to_bits(), |&user_id| user_id as u64);
            let itself = itself.then(Adjacency::default);
            query.set_options(id, BodyOptions { user_data, itself, ..BodyOptions::default() })
        });
        if let Err(error) = added {
            // All or none.
            let remove = |&id: &i64| state.get().query.remove(BodyId::from_bits(id as u64));
            let removed = apart(py, || ids.iter().try_for_each(|id| remove(id).map(drop)));
            removed.map_err(|error| exception(py, error, None))?;
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
        let mut found = Vec::new();
        memory::reserve(&mut found, ids.len()).map_err(|error| exception(py, error, None))?;
        let state = self.state.lock(py)?;
        edit_each(py, &state, ids.len(), true, |query, i| {
            found.push(query.body(BodyId::from_bits(ids[i]))?.options().user_data as i64);
            Ok(())
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
        let (ids, poses, is_one) = one_for_each(py, &ids, &poses)?;
        let state = self.state.lock(py)?;
        edit_each(py, &state, ids.len(), is_one, |query, i| {
            query.set_pose(BodyId::from_bits(ids[i]), poses[i])
        })
    }

    /// Ignores two bodies, or no longer.
    fn ignore(&self, py: Python<'_>, a: u64, b: u64, ignored: bool) -> PyResult<()> {
        let [a, b] = [a, b].map(BodyId::from_bits);
        self.edit(py, |query| query.ignore(a, b, ignored))
    }

    /// The number of bodies.
    fn len(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.state.lock(py)?.get().query.len())
    }

    /// Each body that has triangles: its id, its model, and the rows of its pose.
    fn bodies(&self, py: Python<'_>) -> PyResult<Vec<Told>> {
        let told =
            |body: Placed| (body.id.to_bits(), Model::from(body.model), body.pose.to_f64().rows);
        Ok(self.placed(py, None)?.into_iter().map(told).collect())
    }

    /// A scene of the bodies of both, in which only those of different scenes are asked about: bodies of this one first, with their
    /// ids as user ids; and how many these are: those that may touch one of the other scene, or all.
    fn across(&self, py: Python<'_>, other: &Self, may_touch: bool) -> PyResult<(Self, usize)> {
        // One after the other, so that two threads that ask across the same scenes never wait for each other.
        let theirs = other.placed(py, None)?;
        let bounds =
            theirs.iter().map(|body| body.aabb).reduce(|x, y| x.union(&y)).filter(|_| may_touch);
        let own = self.placed(py, bounds)?;
        let both = Self::new(py, Within(Distance::default()))?;
        let state = both.state.lock(py)?;
        let add = |bodies: &[Placed], memberships, filter| {
            edit_each(py, &state, bodies.len(), true, |query, i| {
                let Placed { id, model, pose, .. } = &bodies[i];
                let groups = Groups { memberships, filter };
                let options = BodyOptions { groups, user_data: id.to_bits(), itself: None };
                query.add_with(model.clone(), *pose, options).map(drop)
            })
        };
        add(&own, 0b01, 0b10)?;
        add(&theirs, 0b10, 0b01)?;
        drop(state);
        Ok((both, own.len()))
    }

    /// The body that is nearest to one, and their smallest distance, if it is not greater than the limit.
    fn distance(
        &self,
        py: Python<'_>,
        id: u64,
        limit: Option<Within>,
        on: &Bound<'_, Executor>,
    ) -> PyResult<Option<(u64, distance::Arrays)>> {
        let (id, limit) = (BodyId::from_bits(id), limit.map(|limit| limit.0.get()));
        let nearest = self.ask(py, on, move |query| match limit {
            Some(limit) => query.distance_below(id, limit),
            None => query.distance(id),
        })?;
        let told = |(other, gap): (BodyId, Gap)| {
            Ok((other.to_bits(), distance::arrays(py, &[Some(gap)])?))
        };
        nearest.map(told).transpose()
    }

    /// The relations of all bodies whose boxes overlap, where these words are allowed, and volumes in common up to this one; and the
    /// bodies that are no solids, and why.
    fn check(
        &self,
        py: Python<'_>,
        allow: Vec<String>,
        allow_overlap: f64,
        with_contacts: bool,
        on: &Bound<'_, Executor>,
    ) -> PyResult<(Vec<Checked>, Vec<Refused>)> {
        let mut allowed =
            Allowed { overlap_volume: allow_overlap, with_contacts, ..Allowed::default() };
        for word in &allow {
            allowed.relations.push(relation::of_word(word)?);
        }
        let report = self.ask_as(py, on, true, move |query| query.check(&allowed))?;
        let why = |(id, error): &(BodyId, NotSolid)| {
            (id.to_bits(), errors::not_solid(py, error, None).into_value(py).into_any())
        };
        Ok((report.pairs.iter().map(told_of).collect(), report.refused.iter().map(why).collect()))
    }

    /// The bodies whose triangles a segment meets, these, and the parameters.
    fn segment(
        &self,
        py: Python<'_>,
        ends: [[f64; 3]; 2],
        on: &Bound<'_, Executor>,
    ) -> PyResult<(Py<PyAny>, segment::Arrays)> {
        let [from, to] = ends;
        let hits = self.ask(py, on, move |query| query.segment(from, to))?;
        let faces = hits.iter().map(|(_, hit)| hit.triangle).collect();
        let at = hits.iter().map(|(_, hit)| hit.at).collect();
        let bodies = hits.iter().map(|(id, _)| id.to_bits() as i64).collect();
        Ok((list::<i64>(py, bodies), (list::<u32>(py, faces), list::<f64>(py, at))))
    }

    /// The body of the first triangle along a segment, this, and the parameter.
    fn segment_first(
        &self,
        py: Python<'_>,
        ends: [[f64; 3]; 2],
        on: &Bound<'_, Executor>,
    ) -> PyResult<Option<(u64, u32, f64)>> {
        let [from, to] = ends;
        let first = self.ask(py, on, move |query| query.segment_first(from, to))?;
        Ok(first.map(|(id, hit)| (id.to_bits(), hit.triangle, hit.at)))
    }

    /// The bodies that contain a point, with the code of its location; and those that are no solids, and why.
    fn inside(
        &self,
        py: Python<'_>,
        point: [f64; 3],
        on: &Bound<'_, Executor>,
    ) -> PyResult<(Vec<Located>, Vec<Refused>)> {
        let (mut containing, mut refused) = (Vec::new(), Vec::new());
        for body in self.ask(py, on, move |query| query.inside(point))? {
            let id = body.body.to_bits();
            match body.location {
                Ok(location) => containing.push((id, segment::code(location))),
                Err(error) => {
                    let why = errors::not_solid(py, &error, None).into_value(py).into_any();
                    refused.push((id, why));
                }
            }
        }
        Ok((containing, refused))
    }

    /// Bodies of each pair of triangles that meets, and these.
    fn pairs(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
        let (bodies, pairs) = self.ask(py, on, |query| {
            let hits = query.all()?;
            let pairs: Vec<TrianglePair> = memory::collect(hits.iter().map(|hit| hit.pair))?;
            Ok((bodies_of(hits.iter())?, pairs))
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
    fn intersecting_bodies(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<Py<PyAny>> {
        let flat = self.ask(py, on, |query| {
            let pairs = query.intersecting_bodies()?;
            memory::collect(pairs.as_flattened().iter().map(|id| id.to_bits() as i64))
        })?;
        let rows = flat.len() / 2;
        table(py, flat, rows, 2)
    }

    /// Bodies of each pair that meets, and where: see `contacts`.
    fn contacts(&self, py: Python<'_>, on: &Bound<'_, Executor>) -> PyResult<(Py<PyAny>, Arrays)> {
        let (bodies, found) = self.ask(py, on, |query| {
            let is_f64 = query.bodies().any(|body| body.model().is_f64() || body.pose().is_f64());
            Ok(if is_f64 {
                let contacts = query.contacts_f64()?;
                let found = Columns::of(&contacts, |hit| hit.pair)?;
                (bodies_of(contacts.iter().map(|(hit, _)| hit))?, Found::F64(found))
            } else {
                let contacts = query.contacts()?;
                let found = Columns::of(contacts, |hit| hit.pair)?;
                (bodies_of(contacts.iter().map(|(hit, _)| hit))?, Found::F32(found))
            })
        })?;
        let rows = bodies.len() / 2;
        Ok((table(py, bodies, rows, 2)?, found.into_arrays(py)?))
    }
}

/// The bodies of all hits in turn.
pub(crate) fn bodies_of<'h>(
    hits: impl ExactSizeIterator<Item = &'h SceneHit>,
) -> Result<Vec<i64>, Error> {
    let mut bodies = Vec::new();
    memory::reserve(&mut bodies, 2 * hits.len())?;
    hits.for_each(|hit| bodies.extend(of_hit(hit)));
    Ok(bodies)
}

/// A body with triangles.
struct Placed {
    id: BodyId,
    model: Arc<pfront::Model>,
    pose: AnyPose,
    aabb: Aabb,
}

/// Ids as NumPy's own integers; none is ever as large as the sign.
pub(crate) fn of_hit(hit: &SceneHit) -> [i64; 2] {
    hit.bodies.map(|id| id.to_bits() as i64)
}

impl Scene {
    fn edit<T: Send>(
        &self,
        py: Python<'_>,
        edit: impl FnOnce(&mut SceneQuery) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        let state = self.state.lock(py)?;
        let edited = apart(py, || edit(&mut state.get().query));
        edited.map_err(|error| exception(py, error, None))
    }

    /// The bodies whose boxes overlap one, or all.
    fn placed(&self, py: Python<'_>, bounds: Option<Aabb>) -> PyResult<Vec<Placed>> {
        self.edit(py, |query| {
            let mut placed = Vec::new();
            for body in query.bodies() {
                let Some(aabb) = body.aabb() else { continue };
                if bounds.is_none_or(|bounds| bounds.overlaps(&aabb)) {
                    let (id, model, pose) = (body.id(), body.model().clone(), body.pose());
                    memory::push(&mut placed, Placed { id, model, pose, aabb })?;
                }
            }
            Ok(placed)
        })
    }

    /// Asks with the scene locked, by whoever is to answer.
    pub(crate) fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        on: &Bound<'_, Executor>,
        verb: impl Fn(&mut SceneQuery) -> Result<T, Error> + Send + Sync + 'static,
    ) -> PyResult<T> {
        self.ask_as(py, on, false, verb)
    }

    /// The same of a question that is known to take long, or may.
    fn ask_as<T: Send + 'static>(
        &self,
        py: Python<'_>,
        on: &Bound<'_, Executor>,
        is_long: bool,
        verb: impl Fn(&mut SceneQuery) -> Result<T, Error> + Send + Sync + 'static,
    ) -> PyResult<T> {
        let on = on.get();
        let state = self.state.lock(py)?;
        let (id, is_long) = ((process::id(), on.id), is_long || state.get().is_long);
        ask(py, on, &self.cancel, is_long, move |executor| {
            let began = Instant::now();
            let mut state = state.get();
            state.turn_to(id, executor);
            let answer = verb(&mut state.query);
            state.is_long = began.elapsed() > BUDGET;
            Ok((answer?, state.query.plan().cloned()))
        })
    }
}

/// Edits so many times, while signals are heard; an error tells at which index, unless there is one only.
fn edit_each(
    py: Python<'_>,
    state: &ProcessGuard<State>,
    count: usize,
    is_one: bool,
    mut edit: impl FnMut(&mut SceneQuery, usize) -> Result<(), Error> + Send,
) -> PyResult<()> {
    for first in (0..count).step_by(EDITS) {
        let edited = apart(py, || {
            let query = &mut state.get().query;
            (first..count.min(first + EDITS))
                .try_for_each(|i| edit(query, i).map_err(|error| (error, i)))
        });
        edited.map_err(|(error, i)| exception(py, error, (!is_one).then_some(i)))?;
        if count > EDITS {
            py.check_signals()?;
        }
    }
    Ok(())
}
