//! Scenes: many posed bodies, and which of their triangles meet.
//!
//! Over the package `pfront`, where all else is over `pfront_core`: a scene needs a broad phase, memory that grows with
//! it, and what it keeps of bodies that stand still. There is one such scene, in Rust, and this is a thin layer over it,
//! which is why it needs the standard library.

mod bodies;
mod check;
mod hits;
mod impacts;
mod segments;

use crate::buffers::{NAMES, pfront_buffers_t, resize};
use crate::executor::{OwnExecutor, pfront_executor_t};
use crate::memory::{Call, Done, Handle};
use crate::model::pfront_model_t;
use crate::pose::{pfront_pose_t, pfront_pose64_t};
use crate::status::Fault;
pub use bodies::*;
pub use check::*;
use core::ffi::c_void;
pub use hits::*;
pub use impacts::*;
use pfront::{Adjacency, BodyId, BodyOptions, Groups, Pose64, SceneQuery};
use pfront_capi_entry::entry;
pub use segments::*;

/// Many bodies, which are models in poses. Functions that take a pointer to one that is not const are for one thread at a time.
/// Another one is refused: PFRONT_BUSY.
pub struct pfront_scene_t(());

/// A scene, and what it has handed out.
pub(crate) struct Scene {
    query: SceneQuery,
    own: OwnExecutor,
    /// The answers that were handed out last.
    body_pairs: Vec<[u64; 2]>,
    bodies: Vec<u64>,
    pieces: Vec<pfront_piece_t>,
    checked: Vec<pfront_checked_pair_t>,
    refused: Vec<pfront_refused_body_t>,
    containing: Vec<pfront_containing_body_t>,
    hits: Vec<pfront_scene_hit_t>,
    impacts: Vec<pfront_scene_impact_t>,
    segment_hits: Vec<pfront_scene_segment_hit_t>,
    contacts: Vec<pfront_scene_contact_t>,
    contacts_f64: Vec<pfront_scene_contact64_t>,
    /// A copy of positions that are not packed.
    positions: Vec<[f32; 3]>,
}

impl Handle for pfront_scene_t {
    type Value = Scene;
    const SEAL: u32 = u32::from_be_bytes(*b"scen");

    fn is_foreign(scene: &Scene) -> bool {
        scene.own.is_foreign()
    }
}

/// A scene to ask or to change, in the process whose threads it has.
fn usable<'c>(call: &mut Call<'c>, scene: *mut pfront_scene_t) -> Result<&'c mut Scene, Fault> {
    let scene = call.owned(c"scene", scene)?;
    scene.own.check(c"scene")?;
    Ok(scene)
}

/// Makes a scene without bodies, which asks `executor`, or the calling thread if that is null.
///
/// A scene takes memory by malloc. PFRONT_OUT_OF_MEMORY if an answer or a mesh does not fit: then nothing has changed, and the
/// call can be made again. After PFRONT_DAMAGED a scene can only be freed. A child of fork may use a scene whose executor has
/// neither threads nor a GPU; any other one is PFRONT_FORKED there, and can only be freed.
#[entry]
fn pfront_scene_create(
    call: &mut Call<'_>,
    executor: *const pfront_executor_t,
    scene: *mut *mut pfront_scene_t,
) -> Done {
    let (out, own) = (call.out(c"scene", scene)?, OwnExecutor::of(call, executor)?);
    let query = SceneQuery::new().on(&own.executor);
    out.set(Call::boxed(Scene {
        query,
        own,
        containing: Vec::new(),
        hits: Vec::new(),
        impacts: Vec::new(),
        segment_hits: Vec::new(),
        contacts: Vec::new(),
        contacts_f64: Vec::new(),
        body_pairs: Vec::new(),
        bodies: Vec::new(),
        pieces: Vec::new(),
        checked: Vec::new(),
        refused: Vec::new(),
        positions: Vec::new(),
    })?);
    Ok(())
}

/// The scene is asked for pairs of triangles at most `distance` apart from now on, in place of those that intersect, which 0 asks
/// for again. CPUs answer, whatever the executor. Contacts are those of the pairs that intersect.
#[entry]
fn pfront_scene_within(call: &mut Call<'_>, scene: *mut pfront_scene_t, distance: f32) -> Done {
    let scene = call.owned(c"scene", scene)?;
    scene.own.check(c"scene")?;
    Ok(scene.query.within(distance)?)
}

/// Frees a scene and all that it has handed out; null is fine. Models stay. PFRONT_BUSY if another thread is inside a call with
/// it.
#[entry]
fn pfront_scene_free(call: &mut Call<'_>, scene: *mut pfront_scene_t) -> Done {
    call.free(c"scene", scene)
}

/// Adds a body: a model, which many bodies may share, in the pose `world_from_body`. `body` names it for good:
/// numbers are never used again, and they ascend in the order of adding.
#[entry]
fn pfront_scene_add(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    model: *const pfront_model_t,
    world_from_body: *const pfront_pose_t,
    body: *mut u64,
) -> Done {
    let (out, scene) = (call.out(c"body", body)?, usable(call, scene)?);
    let model = call.shared(c"model", model)?.clone();
    let pose = call.get(c"world_from_body", world_from_body)?.pose();
    out.set(scene.query.add(model, pose)?.to_bits());
    Ok(())
}

/// Takes a body out.
#[entry]
fn pfront_scene_remove(call: &mut Call<'_>, scene: *mut pfront_scene_t, body: u64) -> Done {
    usable(call, scene)?.query.remove(BodyId::from_bits(body))?;
    Ok(())
}

/// Moves a body to the pose `world_from_body`. If that is the pose it has, the body counts as one that stands still,
/// which costs nothing in the next frame.
#[entry]
fn pfront_scene_set_pose(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    world_from_body: *const pfront_pose_t,
) -> Done {
    let scene = usable(call, scene)?;
    let pose = call.get(c"world_from_body", world_from_body)?.pose();
    Ok(scene.query.set_pose(BodyId::from_bits(body), pose)?)
}

/// `pfront_scene_set_pose` with a pose in f64, in which the body is then asked about, whatever the other one. A body that
/// is to have one from the start is added with PFRONT_POSE_IDENTITY first.
#[entry]
fn pfront_scene_set_pose_f64(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    world_from_body: *const pfront_pose64_t,
) -> Done {
    let scene = usable(call, scene)?;
    let pose = Pose64::new(call.get(c"world_from_body", world_from_body)?.rows);
    Ok(scene.query.set_pose(BodyId::from_bits(body), pose)?)
}

/// Moves the vertices of a body, given in its own frame: as many as its model has, `stride` bytes apart, where 0 stands
/// for 12. From then on the body has a model of its own. In O(vertices + triangles).
#[entry]
fn pfront_scene_set_positions(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    positions: *const c_void,
    vertex_count: usize,
    stride: usize,
) -> Done {
    let scene = usable(call, scene)?;
    let buffers = pfront_buffers_t::of_vertices(positions, vertex_count, stride).checked(&NAMES)?;
    resize(&mut scene.positions, buffers.words()?[0] / 3)?;
    let positions = buffers.positions(call, &mut scene.positions)?;
    Ok(scene.query.set_positions(BodyId::from_bits(body), positions)?)
}

/// `pfront_scene_set_positions` of a body whose model is in f64, of positions in double: 0 stands for 24.
#[entry]
fn pfront_scene_set_positions_f64(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    positions: *const c_void,
    vertex_count: usize,
    stride: usize,
) -> Done {
    let scene = usable(call, scene)?;
    let buffers = pfront_buffers_t::of_vertices(positions, vertex_count, stride).checked(&NAMES)?;
    let (positions, _) = buffers.copies(call)?;
    Ok(scene.query.set_positions::<f64>(BodyId::from_bits(body), &positions)?)
}

/// Says which groups a body is in and which it may meet: two bodies are asked about if each is a member of a group
/// that the other's filter lets through. All bits are set at first.
#[entry]
fn pfront_scene_set_groups(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    memberships: u32,
    filter: u32,
) -> Done {
    let groups = Groups { memberships, filter };
    set_options(&mut usable(call, scene)?.query, body, |options| options.groups = groups)
}

fn set_options(query: &mut SceneQuery, body: u64, set: impl FnOnce(&mut BodyOptions)) -> Done {
    let body = BodyId::from_bits(body);
    let mut options = query.body(body)?.options();
    set(&mut options);
    Ok(query.set_options(body, options)?)
}

/// Asks with all else whether a body meets itself, as cloth does, by the rule of `pfront_query_self`; or no longer, if `asked` is
/// 0. A hit of it has the same body twice.
#[entry]
fn pfront_scene_ask_itself(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    asked: u32,
) -> Done {
    let itself = (asked != 0).then(Adjacency::default);
    set_options(&mut usable(call, scene)?.query, body, |options| options.itself = itself)
}

/// Ignores two bodies, as the links of a joint that overlap by design; or no longer, if `ignored` is 0.
#[entry]
fn pfront_scene_ignore(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    a: u64,
    b: u64,
    ignored: u32,
) -> Done {
    let query = &mut usable(call, scene)?.query;
    Ok(query.ignore(BodyId::from_bits(a), BodyId::from_bits(b), ignored != 0)?)
}

/// Keeps a number of the caller's with a body, such as the index of an entity; it is 0 at first.
#[entry]
fn pfront_scene_set_user_data(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    user_data: u64,
) -> Done {
    set_options(&mut usable(call, scene)?.query, body, |options| options.user_data = user_data)
}

/// Tells the number that is kept with a body.
#[entry]
fn pfront_scene_user_data(
    call: &mut Call<'_>,
    scene: *const pfront_scene_t,
    body: u64,
    user_data: *mut u64,
) -> Done {
    let out = call.out(c"user_data", user_data)?;
    let query = &call.shared(c"scene", scene)?.query;
    out.set(query.body(BodyId::from_bits(body))?.options().user_data);
    Ok(())
}
