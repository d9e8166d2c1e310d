//! Bodies as such: which meet, which lie in a box, and what becomes of one.

use super::{Scene, pfront_scene_hit_t, pfront_scene_t, usable};
use crate::memory::{Call, Done, reserve};
use crate::model::pfront_model_t;
use crate::status::Fault;
use crate::status::pfront_status_t::PFRONT_NULL;
use crate::subject::pfront_gap_t;
use core::ffi::c_void;
use core::ops::ControlFlow::{Break, Continue};
use pfront::{Aabb, BodyId};
use pfront_capi_entry::entry;

/// A body that was part of another one.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_piece_t {
    /// The body.
    pub body: u64,
    /// The number of its part.
    pub part: u32,
    /// How many triangles it has.
    pub triangle_count: u32,
}

/// Finds which bodies meet, each two until their first hit: `count` pairs in `pairs`, sorted, of which each is two numbers, the
/// body that was added first before the other; a body that is asked about itself twice. They belong to the scene and are
/// good until this is called again, or the scene is freed.
#[entry]
fn pfront_scene_intersecting_bodies(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    pairs: *mut *const [u64; 2],
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"pairs", pairs, count)?;
    let Scene { query, body_pairs, .. } = usable(call, scene)?;
    out.set(body_pairs, query.intersecting_bodies()?.iter().map(|two| two.map(BodyId::to_bits)))
}

/// Finds the bodies whose box in the world overlaps the box from `min` to `max`, each of 3 floats: `count` of them in `bodies`,
/// sorted. They belong to the scene and are good until this is called again, or the scene is freed.
#[entry]
fn pfront_scene_bodies_in(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    min: *const f32,
    max: *const f32,
    bodies: *mut *const u64,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"bodies", bodies, count)?;
    let (min, max) = (call.get(c"min", min.cast())?, call.get(c"max", max.cast())?);
    let Scene { query, bodies, .. } = usable(call, scene)?;
    out.set(bodies, query.bodies_in(Aabb { min, max })?.into_iter().map(BodyId::to_bits))
}

/// Finds the body that is nearest to `body`, and their smallest distance in the world: `found` is 1, `nearest` names it and `gap`
/// tells the distance, if it is at most `limit`, which is INFINITY for any; else `found` is 0 and neither is written. Triangle `a` of the pair
/// is of `body`. Bodies that it may not meet are left out.
#[entry]
fn pfront_scene_distance(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    limit: f32,
    nearest: *mut u64,
    gap: *mut pfront_gap_t,
    found: *mut u32,
) -> Done {
    let (id, out) = (call.out(c"nearest", nearest)?, call.out(c"gap", gap)?);
    let is_found = call.out(c"found", found)?;
    let (query, body) = (&mut usable(call, scene)?.query, BodyId::from_bits(body));
    let some = match limit {
        f32::INFINITY => query.distance(body)?,
        _ => query.distance_below(body, limit)?,
    };
    if let Some((other, _)) = some {
        id.set(other.to_bits());
    }
    out.set_some(is_found, some.map(|(_, gap)| gap.into()));
    Ok(())
}

/// Calls `visit` with `context` and each hit, on the calling thread, bodies in order and their triangles in none, until it returns
/// another number than 0: then `stopped` is 1, else 0. `visit` runs in the default floating-point environment; a call with this scene
/// is PFRONT_BUSY there, and it must not leave by an exception or by longjmp. Nothing is kept.
#[entry]
fn pfront_scene_visit(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    visit: Option<
        unsafe extern "C" fn(context: *mut c_void, hit: *const pfront_scene_hit_t) -> i32,
    >,
    context: *mut c_void,
    stopped: *mut u32,
) -> Done {
    let out = call.out(c"stopped", stopped)?;
    let visit = visit.ok_or(Fault::of(PFRONT_NULL, c"visit"))?;
    #[expect(unsafe_code, reason = "C gives a function to call")]
    let end = usable(call, scene)?.query.visit(|hit| {
        // SAFETY: the contract of the header: it is a function of these arguments.
        match unsafe { visit(context, &hit.into()) } {
            0 => Continue(()),
            _ => Break(()),
        }
    })?;
    out.set(end.is_break().into());
    Ok(())
}

/// Gives a body another model.
#[entry]
fn pfront_scene_set_model(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    model: *const pfront_model_t,
) -> Done {
    let query = &mut usable(call, scene)?.query;
    let model = call.cloned(c"model", model)?;
    Ok(query.set_model(BodyId::from_bits(body), model)?)
}

/// Splits a body: triangle i goes to part `parts[i]`, of which there are as many as triangles. Each part becomes a body in the same
/// pose, with a mesh of its own whose triangles are in the old order, the groups and the number of the old one, which is gone, and asked about itself if that was; nobody ignores it. `pieces` tells
/// `count` of them, by parts; it belongs to the scene and is good until this is called again, or the scene is freed.
#[entry]
fn pfront_scene_split(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    body: u64,
    parts: *const u32,
    triangle_count: usize,
    pieces: *mut *const pfront_piece_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"pieces", pieces, count)?;
    let parts = call.read(c"parts", parts, triangle_count)?;
    let Scene { query, pieces, .. } = usable(call, scene)?;
    let body = BodyId::from_bits(body);
    let needed = query.body(body)?.model().mesh().triangles().len();
    Fault::room(c"parts", triangle_count, needed)?;
    Fault::below(c"triangle_count", triangle_count, needed.saturating_add(1))?;
    // Room for as many as there can be, so that nothing fails once the body is split.
    pieces.clear();
    reserve(pieces, needed)?;
    let part = |triangle: u32| parts.get(triangle as usize).copied().unwrap_or_default();
    let found = query.split(body, part)?;
    let for_c = |piece: &pfront::Piece| pfront_piece_t {
        body: piece.body.to_bits(),
        part: piece.part,
        triangle_count: piece.triangles.len() as u32,
    };
    out.set(pieces, found.iter().map(for_c))
}
