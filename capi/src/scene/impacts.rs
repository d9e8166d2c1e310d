//! Triangles of bodies that meet on the way while some bodies of a scene move.

use super::{Scene, pfront_scene_hit_t, pfront_scene_t, usable};
use crate::memory::{Call, Done, reserve};
use crate::pose::pfront_pose64_t;
use crate::status::Fault;
use pfront::{AnyPose, BodyId, Error, Impact, Pose64, SceneHit, SceneQuery};
use pfront_capi_entry::entry;

/// Where a body goes, each vertex in a straight line.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_body_end_t {
    /// The body.
    pub body: u64,
    /// Its pose at time 1; at time 0 it has that of the scene.
    pub world_from_body: pfront_pose64_t,
}

/// When two triangles of bodies meet first, as far as it is proven.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_scene_impact_t {
    /// The triangles.
    pub hit: pfront_scene_hit_t,
    /// They do not meet before this time.
    pub from: f64,
    /// They certainly meet between `from` and this time; INFINITY if that is open, as where they touch and do not pass.
    pub to: f64,
}

impl From<(SceneHit, Impact)> for pfront_scene_impact_t {
    fn from((hit, Impact { from, to }): (SceneHit, Impact)) -> Self {
        Self { hit: hit.into(), from, to }
    }
}

/// Bodies that move, in memory of the caller's.
type Ends = (*const pfront_body_end_t, usize);

/// A verb about bodies that move.
type Verb<T> = fn(&mut SceneQuery, &[(BodyId, AnyPose)]) -> Result<T, Error>;

/// A scene, and its answer to a verb.
fn asked<'c, T>(
    call: &mut Call<'c>,
    scene: *mut pfront_scene_t,
    (ends, end_count): Ends,
    verb: Verb<T>,
) -> Result<(&'c mut Scene, T), Fault> {
    let scene = usable(call, scene)?;
    let (ends, mut moving) = (call.read(c"ends", ends, end_count)?, Vec::new());
    reserve(&mut moving, ends.len())?;
    for end in ends {
        let pose = AnyPose::F64(Pose64::new(end.world_from_body.rows));
        moving.push((BodyId::from_bits(end.body), pose));
    }
    let answer = verb(&mut scene.query, &moving).map_err(|error| match error {
        Error::Pose(error) => Fault::pose(c"ends")(error),
        error => error.into(),
    });
    Ok((scene, answer?))
}

/// Finds all pairs of triangles of different bodies that meet while the `end_count` bodies of `ends` move, each given once; all others stay
/// where they are, and the scene is the same afterwards. `count` of them are in `impacts`, sorted by bodies, then triangles. No pair is missed. After
/// `pfront_scene_within`, pairs are those that come within the distance on the way. CPUs answer, whatever the executor. `impacts` belongs to the
/// scene and is good until this is called again, or the scene is freed.
#[entry]
fn pfront_scene_impacts(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    ends: *const pfront_body_end_t,
    end_count: usize,
    impacts: *mut *const pfront_scene_impact_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"impacts", impacts, count)?;
    let (scene, found) = asked(call, scene, (ends, end_count), |query, ends| query.impacts(ends))?;
    out.set(&mut scene.impacts, found.into_iter().map(pfront_scene_impact_t::from))
}

/// Finds the pair of triangles that meets first, by time, then by bodies and triangles: `found` is 1 and `impact` tells it, or `found` is 0 and
/// `impact` is not written. All else is as for `pfront_scene_impacts`.
#[entry]
fn pfront_scene_first_impact(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    ends: *const pfront_body_end_t,
    end_count: usize,
    impact: *mut pfront_scene_impact_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"impact", impact)?, call.out(c"found", found)?);
    let (_, first) = asked(call, scene, (ends, end_count), |query, ends| query.first_impact(ends))?;
    out.set_some(is_found, first.map(pfront_scene_impact_t::from));
    Ok(())
}

/// Finds some pair of triangles that meets, and stops at the first that certainly does: `found` is 1 and `impact` tells it, or `found` is 0
/// and `impact` is not written. `to` is INFINITY only if all that `pfront_scene_impacts` finds are open. Executors may find different
/// pairs. All else is as for `pfront_scene_impacts`.
#[entry]
fn pfront_scene_any_impact(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    ends: *const pfront_body_end_t,
    end_count: usize,
    impact: *mut pfront_scene_impact_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"impact", impact)?, call.out(c"found", found)?);
    let (_, any) = asked(call, scene, (ends, end_count), |query, ends| query.any_impact(ends))?;
    out.set_some(is_found, any.map(pfront_scene_impact_t::from));
    Ok(())
}

/// Tells how many pairs of triangles meet: at least `low`, which certainly do, and at most `high`, which are all that
/// `pfront_scene_impacts` finds. No list is kept. All else is as for `pfront_scene_impacts`.
#[entry]
fn pfront_scene_count_impacts(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    ends: *const pfront_body_end_t,
    end_count: usize,
    low: *mut u64,
    high: *mut u64,
) -> Done {
    let (least, greatest) = (call.out(c"low", low)?, call.out(c"high", high)?);
    let (_, [low, high]) =
        asked(call, scene, (ends, end_count), |query, ends| query.count_impacts(ends))?;
    least.set(low);
    greatest.set(high);
    Ok(())
}
