//! Questions about models, frame by frame or many at once.

use crate::executor::{OwnExecutor, pfront_executor_t};
use crate::memory::{Call, Done, Handle};
use crate::model::{Solids, pfront_impact_t, pfront_model_t, pfront_patch_t, pfront_segment_hit_t};
use crate::pose::{pfront_pose_t, pfront_pose64_t};
use crate::query::pfront_rule_t;
use crate::status::Fault;
use crate::status::pfront_status_t::PFRONT_NULL;
use crate::verbs::{pfront_contact_t, pfront_pair_t};
use pfront::{
    Adjacency, AnyPose, Batch, Error, Gap, Model, PairQuery, Pose64, SelfQuery, TrianglePair,
};
use pfront_capi_entry::entry;
use std::mem::take;
use std::sync::Arc;

/// Two models, the second posed, or one model and itself.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_subject_t {
    /// The first.
    pub a: *const pfront_model_t,
    /// The second; null for `a` and itself, which has no pose.
    pub b: *const pfront_model_t,
    /// The pose of `b`; null if there is none.
    pub a_from_b: *const pfront_pose_t,
    /// A pose in f64 in place of `a_from_b`, unless it is null; then the answer is that of f64.
    pub a_from_b_f64: *const pfront_pose64_t,
    /// A `pfront_rule_t` for one model and itself: PFRONT_SHARED_INDEX or PFRONT_SKIP_NEIGHBOURS.
    pub rule: u32,
}

/// A subject whose models are held.
pub(crate) enum Subject {
    Pair(Arc<Model>, Arc<Model>, AnyPose),
    Itself(Arc<Model>, Adjacency),
}

impl Subject {
    fn new(call: &mut Call<'_>, subject: pfront_subject_t) -> Result<Self, Fault> {
        let a = call.cloned(c"a", subject.a)?;
        if subject.b.is_null() {
            // Perhaps the model could not be made.
            if !subject.a_from_b.is_null() || !subject.a_from_b_f64.is_null() {
                return Err(Fault::of(PFRONT_NULL, c"b"));
            }
            let rule = rule(subject.rule)?;
            return Ok(Self::Itself(a, rule));
        }
        let b = call.cloned(c"b", subject.b)?;
        let pose = match subject.a_from_b_f64.is_null() {
            true => call.get(c"a_from_b", subject.a_from_b)?.pose().into(),
            false => Pose64::new(call.get(c"a_from_b_f64", subject.a_from_b_f64)?.rows).into(),
        };
        Ok(Self::Pair(a, b, pose))
    }
}

/// The names of the poses of a subject in errors.
pub(crate) fn fault(error: Error) -> Fault {
    match error {
        Error::Pose(error) => Fault::pose(c"a_from_b")(error),
        other => other.into(),
    }
}

/// A query about models, which remembers from frame to frame. For one thread at a time; another one is refused:
/// PFRONT_BUSY.
pub struct pfront_model_query_t(());

/// The queries of an executor, one for each kind of subject, so that each remembers its own.
pub(crate) struct ModelQuery {
    pub(crate) own: OwnExecutor,
    pub(crate) pair: PairQuery,
    pub(crate) within: [SelfQuery; 2],
    pub(crate) solids: Solids,
    /// The answers that were handed out last.
    pairs: Vec<pfront_pair_t>,
    pub(crate) segment_hits: Vec<pfront_segment_hit_t>,
    pub(crate) patches: Vec<pfront_patch_t>,
    contacts: Vec<pfront_model_contact_t>,
    pub(crate) impacts: Vec<pfront_impact_t>,
}

impl Handle for pfront_model_query_t {
    type Value = ModelQuery;
    const SEAL: u32 = u32::from_be_bytes(*b"mqry");

    fn is_foreign(query: &ModelQuery) -> bool {
        query.own.is_foreign()
    }
}

/// Two triangles that meet, and where they do, in the frame of the first model.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_model_contact_t {
    /// The triangles.
    pub pair: pfront_pair_t,
    /// Where they meet.
    pub contact: pfront_contact_t,
}

/// The smallest distance of two meshes, and where it is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_gap_t {
    /// The least that it can be; 0 if triangles intersect.
    pub low: f64,
    /// The greatest that it can be; 0 if triangles intersect.
    pub high: f64,
    /// The nearest triangles, or two that intersect.
    pub pair: pfront_pair_t,
    /// The nearest points of both, rounded.
    pub points: [[f64; 3]; 2],
}

impl From<Gap> for pfront_gap_t {
    fn from(gap: Gap) -> Self {
        let [low, high] = gap.interval;
        Self { low, high, pair: gap.pair.into(), points: gap.points }
    }
}

/// Makes a query that asks `executor`, or the calling thread if that is null. It keeps its last answer, and what its frames
/// took: use one for each series of frames that resemble each other.
#[entry]
fn pfront_model_query_create(
    call: &mut Call<'_>,
    executor: *const pfront_executor_t,
    query: *mut *mut pfront_model_query_t,
) -> Done {
    let (out, own) = (call.out(c"query", query)?, OwnExecutor::of(call, executor)?);
    let within = [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours]
        .map(|rule| SelfQuery::new().with_adjacency(rule).on(&own.executor));
    let pair = PairQuery::new().on(&own.executor);
    out.set(Call::boxed(ModelQuery {
        own,
        pair,
        within,
        solids: Solids::default(),
        pairs: Vec::new(),
        segment_hits: Vec::new(),
        patches: Vec::new(),
        contacts: Vec::new(),
        impacts: Vec::new(),
    })?);
    Ok(())
}

/// Frees a query and all that it has handed out; null is fine. PFRONT_BUSY if another thread is inside a call with it.
#[entry]
fn pfront_model_query_free(call: &mut Call<'_>, query: *mut pfront_model_query_t) -> Done {
    call.free(c"query", query)
}

/// The query is asked for pairs of triangles at most `distance` apart from now on, in place of those that intersect, which 0 asks
/// for again. A GPU answers it about two models; about one and itself CPUs answer. Contacts are those of the pairs that intersect, and
/// triangles of one mesh that share a vertex are asked about as `rule` says.
#[entry]
fn pfront_model_query_within(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    distance: f32,
) -> Done {
    let query = call.owned(c"query", query)?;
    query.own.check(c"query")?;
    // A distance that is refused leaves the queries as they are.
    PairQuery::new().within(distance)?;
    query.pair = take(&mut query.pair).within(distance)?;
    for own in &mut query.within {
        *own = take(own).within(distance)?;
    }
    Ok(())
}

/// A query in the process that it belongs to, and what it is asked about.
pub(crate) fn asked<'c>(
    call: &mut Call<'c>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
) -> Result<(&'c mut ModelQuery, Subject), Fault> {
    let query = call.owned(c"query", query)?;
    query.own.check(c"query")?;
    let subject = call.get(c"subject", subject)?;
    Ok((query, Subject::new(call, subject)?))
}

/// The rule of this number.
pub(crate) fn rule(number: u32) -> Result<Adjacency, Fault> {
    Fault::below(c"rule", number as usize, 2)?;
    let skips = number == pfront_rule_t::PFRONT_SKIP_NEIGHBOURS as u32;
    Ok(if skips { Adjacency::SkipNeighbours } else { Adjacency::SharedIndexRule })
}

/// The query for a rule.
pub(crate) fn of_rule(within: &mut [SelfQuery; 2], rule: Adjacency) -> &mut SelfQuery {
    let [shared, skips] = within;
    if rule == Adjacency::SkipNeighbours { skips } else { shared }
}

/// Finds all pairs of triangles of a subject that meet: `count` of them in `pairs`, sorted. They belong to the query and are good
/// until this is called again, or the query is freed.
#[entry]
fn pfront_model_query_all(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    pairs: *mut *const pfront_pair_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"pairs", pairs, count)?;
    let (ModelQuery { pair, within, pairs, .. }, subject) = asked(call, query, subject)?;
    let found = match &subject {
        Subject::Pair(a, b, pose) => pair.all(a, b, pose).map_err(fault)?,
        Subject::Itself(a, rule) => of_rule(within, *rule).all(a).map_err(fault)?,
    };
    let for_c = |&TrianglePair { a, b }: &_| pfront_pair_t { a, b };
    out.set(pairs, found.iter().map(for_c))
}

/// Finds the smallest distance of two models, in the frame of `a`: `found` is 1 and `gap` tells it, if it is at most `limit`,
/// which is INFINITY for any; else, or if a model has no triangles, `found` is 0 and `gap` is not written. A model and itself are
/// PFRONT_NULL. CPUs answer, whatever the executor, and the distance of `pfront_model_query_within` does not matter.
#[entry]
fn pfront_model_query_distance(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    limit: f32,
    gap: *mut pfront_gap_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"gap", gap)?, call.out(c"found", found)?);
    let (ModelQuery { pair, .. }, subject) = asked(call, query, subject)?;
    let Subject::Pair(a, b, pose) = &subject else { return Err(Fault::of(PFRONT_NULL, c"b")) };
    let some = match limit {
        f32::INFINITY => pair.distance(a, b, *pose),
        _ => pair.distance_below(a, b, *pose, limit),
    };
    out.set_some(is_found, some.map_err(fault)?.map(pfront_gap_t::from));
    Ok(())
}

/// Finds some pair that meets, and stops at the first: `found` is 1 if there is one, else 0 and `pair` is not written.
#[entry]
fn pfront_model_query_any(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    pair: *mut pfront_pair_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"pair", pair)?, call.out(c"found", found)?);
    let (query, subject) = asked(call, query, subject)?;
    let some = match &subject {
        Subject::Pair(a, b, pose) => query.pair.any(a, b, pose).map_err(fault)?,
        Subject::Itself(a, rule) => of_rule(&mut query.within, *rule).any(a).map_err(fault)?,
    };
    out.set_some(is_found, some.map(pfront_pair_t::from));
    Ok(())
}

/// Tells how many pairs meet.
#[entry]
fn pfront_model_query_count(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    count: *mut u64,
) -> Done {
    let out = call.out(c"count", count)?;
    let (query, subject) = asked(call, query, subject)?;
    out.set(match &subject {
        Subject::Pair(a, b, pose) => query.pair.count(a, b, pose).map_err(fault)?,
        Subject::Itself(a, rule) => of_rule(&mut query.within, *rule).count(a).map_err(fault)?,
    });
    Ok(())
}

/// `pfront_model_query_all` that also tells where they meet. `contacts` belongs to the query and is good until this is called again,
/// or the query is freed.
#[entry]
fn pfront_model_query_contacts(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    contacts: *mut *const pfront_model_contact_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"contacts", contacts, count)?;
    let (ModelQuery { pair, within, contacts, .. }, subject) = asked(call, query, subject)?;
    let found = match &subject {
        Subject::Pair(a, b, pose) => pair.contacts(a, b, pose).map_err(fault)?,
        Subject::Itself(a, rule) => of_rule(within, *rule).contacts(a).map_err(fault)?,
    };
    let for_c = |&(TrianglePair { a, b }, contact): &(_, _)| pfront_model_contact_t {
        pair: pfront_pair_t { a, b },
        contact: Some(contact).into(),
    };
    out.set(contacts, found.iter().map(for_c))
}

/// The executor and the questions of a batch.
fn batch(
    call: &mut Call<'_>,
    executor: *const pfront_executor_t,
    subjects: *const pfront_subject_t,
    subject_count: usize,
) -> Result<(OwnExecutor, Batch), Fault> {
    let own = OwnExecutor::of(call, executor)?;
    let mut batch = Batch::new();
    for (index, subject) in call.read(c"subjects", subjects, subject_count)?.iter().enumerate() {
        let added = match Subject::new(call, *subject).map_err(|fault| fault.at(index))? {
            Subject::Pair(a, b, pose) => batch.pair(&a, &b, pose).map_err(fault),
            Subject::Itself(a, rule) => {
                batch.itself(&a, rule);
                Ok(())
            }
        };
        added.map_err(|fault| fault.at(index))?;
    }
    Ok((own, batch))
}

/// Finds for each of `subject_count` subjects some pair that meets: `found[i]` is 1 if there is one, else 0 and `pairs[i]` is not
/// written. Where that pays, all threads of `executor` work on them, or its GPU; null stands for the calling thread. A subject at
/// fault is `index` of the error.
#[entry]
fn pfront_batch_any(
    call: &mut Call<'_>,
    executor: *const pfront_executor_t,
    subjects: *const pfront_subject_t,
    subject_count: usize,
    pairs: *mut pfront_pair_t,
    found: *mut u32,
) -> Done {
    let pairs = call.write(c"pairs", pairs.cast::<TrianglePair>(), subject_count)?;
    let found = call.write(c"found", found, subject_count)?;
    let (own, mut batch) = batch(call, executor, subjects, subject_count)?;
    let answers = batch.any(&own.executor).and_then(|ticket| ticket.read())?;
    for ((answer, pair), found) in answers.iter().zip(pairs).zip(found) {
        *found = answer.is_some().into();
        answer.iter().for_each(|&some| *pair = some);
    }
    Ok(())
}

/// Tells for each of `subject_count` subjects how many pairs meet. All else is as for `pfront_batch_any`.
#[entry]
fn pfront_batch_count(
    call: &mut Call<'_>,
    executor: *const pfront_executor_t,
    subjects: *const pfront_subject_t,
    subject_count: usize,
    counts: *mut u64,
) -> Done {
    let counts = call.write(c"counts", counts, subject_count)?;
    let (own, mut batch) = batch(call, executor, subjects, subject_count)?;
    let answers = batch.count(&own.executor).and_then(|ticket| ticket.read())?;
    counts.iter_mut().zip(answers).for_each(|(count, answer)| *count = answer);
    Ok(())
}

/// Finds the smallest distance of the models of each of `subject_count` subjects, as `pfront_model_query_distance` does: what a planner
/// asks of many poses. `found[i]` is 1 and `gaps[i]` tells it, if it is at most `limit`, which is INFINITY for any; else `found[i]` is 0
/// and `gaps[i]` is not written. A model and itself are PFRONT_NULL. CPUs answer, on all threads of `executor`; null stands for the
/// calling thread. A subject at fault is `index` of the error.
#[entry]
fn pfront_batch_distance(
    call: &mut Call<'_>,
    executor: *const pfront_executor_t,
    subjects: *const pfront_subject_t,
    subject_count: usize,
    limit: f32,
    gaps: *mut pfront_gap_t,
    found: *mut u32,
) -> Done {
    let gaps = call.write(c"gaps", gaps, subject_count)?;
    let found = call.write(c"found", found, subject_count)?;
    let (own, mut batch) = batch(call, executor, subjects, subject_count)?;
    let ticket = match limit {
        f32::INFINITY => batch.distance(&own.executor),
        _ => batch.distance_below(&own.executor, limit),
    };
    let answers = ticket.and_then(|ticket| ticket.read())?;
    for ((answer, gap), found) in answers.into_iter().zip(gaps).zip(found) {
        *found = answer.is_some().into();
        answer.into_iter().for_each(|some| *gap = some.into());
    }
    Ok(())
}
