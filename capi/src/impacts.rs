//! Triangles of models that move and meet on the way.

use crate::memory::{Call, Done};
use crate::model::{pfront_impact_t, pfront_model_t};
use crate::pose::pfront_pose64_t;
use crate::status::Fault;
use crate::status::pfront_status_t::PFRONT_MOTION;
use crate::subject::{self, ModelQuery, fault, of_rule, pfront_model_query_t};
use pfront::{Error, Model, Motion, PairQuery, Pose64, SelfQuery};
use pfront_capi_entry::entry;
use std::sync::Arc;

/// A model that moves from time 0 to time 1, each vertex in a straight line: between two poses in the world, or between the positions of two
/// models.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_motion_t {
    /// The model at time 0.
    pub start: *const pfront_model_t,
    /// A model of the same triangles at time 1, for one that deforms, which then has no poses; else null.
    pub end: *const pfront_model_t,
    /// The pose at time 0; null if there is none.
    pub from: *const pfront_pose64_t,
    /// The pose at time 1; null if it is the first.
    pub to: *const pfront_pose64_t,
}

/// A motion whose models are held.
struct Held {
    start: Arc<Model>,
    end: Option<Arc<Model>>,
    poses: Option<[Pose64; 2]>,
}

impl Held {
    fn new(call: &mut Call<'_>, motion: pfront_motion_t) -> Result<Self, Fault> {
        let start = call.cloned(c"start", motion.start)?;
        let pose = |name, pose: *const pfront_pose64_t| match pose.is_null() {
            true => Ok(None),
            false => Ok::<_, Fault>(Some(Pose64::new(call.get(name, pose)?.rows))),
        };
        let (from, to) = (pose(c"from", motion.from)?, pose(c"to", motion.to)?);
        let poses = (from.is_some() || to.is_some()).then(|| {
            let first = from.unwrap_or(Pose64::IDENTITY);
            [first, to.unwrap_or(first)]
        });
        let end = match motion.end.is_null() {
            true => None,
            false if from.is_some() => return Err(Fault::of(PFRONT_MOTION, c"from")),
            false if to.is_some() => return Err(Fault::of(PFRONT_MOTION, c"to")),
            false => Some(call.cloned(c"end", motion.end)?),
        };
        Ok(Self { start, end, poses })
    }

    fn motion(&self) -> Result<Motion<'_>, Error> {
        match (&self.end, self.poses) {
            (Some(end), _) => Motion::between(&self.start, end),
            (None, Some([from, to])) => Motion::new(&self.start, from, to),
            (None, None) => Ok(Motion::at_rest(&self.start)),
        }
    }
}

/// A query, and its answer to a verb about two motions, or about that of one model and itself.
fn asked<'c, T>(
    call: &mut Call<'c>,
    query: *mut pfront_model_query_t,
    [a, b]: [*const pfront_motion_t; 2],
    rule: u32,
    of_two: fn(&mut PairQuery, &Motion<'_>, &Motion<'_>) -> Result<T, Error>,
    of_one: fn(&mut SelfQuery, &Motion<'_>) -> Result<T, Error>,
) -> Result<(&'c mut ModelQuery, T), Fault> {
    let query = call.owned(c"query", query)?;
    query.own.check(c"query")?;
    let a = call.get(c"a", a)?;
    let a = Held::new(call, a)?;
    let rule = subject::rule(rule)?;
    let answer = if b.is_null() {
        let own = of_rule(&mut query.within, rule);
        a.motion().and_then(|a| of_one(own, &a))
    } else {
        let b = call.get(c"b", b)?;
        let b = Held::new(call, b)?;
        let (a, b) = (a.motion().map_err(fault)?, b.motion().map_err(fault)?);
        of_two(&mut query.pair, &a, &b)
    };
    Ok((query, answer.map_err(fault)?))
}

/// Finds all pairs of triangles of two models that meet while both move: `count` of them in `impacts`, sorted by their pairs. With `b` null, those
/// of `a` with itself while it deforms, by `rule`: PFRONT_SHARED_INDEX or PFRONT_SKIP_NEIGHBOURS. No pair is missed. CPUs answer, whatever
/// the executor. After `pfront_model_query_within`, pairs are those that come within the distance on the way. `impacts` belongs to the query and is
/// good until this is called again, or the query is freed.
#[entry]
fn pfront_model_query_impacts(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    a: *const pfront_motion_t,
    b: *const pfront_motion_t,
    rule: u32,
    impacts: *mut *const pfront_impact_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"impacts", impacts, count)?;
    let (query, found) = asked(call, query, [a, b], rule, PairQuery::impacts, SelfQuery::impacts)?;
    out.set(&mut query.impacts, found.into_iter().map(pfront_impact_t::from))
}

/// Finds the pair of triangles that meets first: `found` is 1 and `impact` tells it, or `found` is 0 and `impact` is not written. All else is
/// as for `pfront_model_query_impacts`.
#[entry]
fn pfront_model_query_first_impact(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    a: *const pfront_motion_t,
    b: *const pfront_motion_t,
    rule: u32,
    impact: *mut pfront_impact_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"impact", impact)?, call.out(c"found", found)?);
    let (_, first) =
        asked(call, query, [a, b], rule, PairQuery::first_impact, SelfQuery::first_impact)?;
    out.set_some(is_found, first.map(pfront_impact_t::from));
    Ok(())
}

/// Finds some pair of triangles that meets, and stops at the first that certainly does: `found` is 1 and `impact` tells it, or `found` is 0
/// and `impact` is not written. `to` is INFINITY only if all that `pfront_model_query_impacts` finds are open. Executors may find different
/// pairs. All else is as for `pfront_model_query_impacts`.
#[entry]
fn pfront_model_query_any_impact(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    a: *const pfront_motion_t,
    b: *const pfront_motion_t,
    rule: u32,
    impact: *mut pfront_impact_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"impact", impact)?, call.out(c"found", found)?);
    let (_, any) = asked(call, query, [a, b], rule, PairQuery::any_impact, SelfQuery::any_impact)?;
    out.set_some(is_found, any.map(pfront_impact_t::from));
    Ok(())
}

/// Tells how many pairs of triangles meet: at least `low`, which certainly do, and at most `high`, which are all that
/// `pfront_model_query_impacts` finds. No list is kept. All else is as for `pfront_model_query_impacts`.
#[entry]
fn pfront_model_query_count_impacts(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    a: *const pfront_motion_t,
    b: *const pfront_motion_t,
    rule: u32,
    low: *mut u64,
    high: *mut u64,
) -> Done {
    let (least, greatest) = (call.out(c"low", low)?, call.out(c"high", high)?);
    let (_, [low, high]) =
        asked(call, query, [a, b], rule, PairQuery::count_impacts, SelfQuery::count_impacts)?;
    least.set(low);
    greatest.set(high);
    Ok(())
}
