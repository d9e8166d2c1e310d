//! Models: a mesh and its BVH in memory of the library's own, for the bodies of scenes.

use crate::buffers::{NAMES, pfront_buffers_t};
use crate::executor::{OwnExecutor, pfront_executor_t};
use crate::memory::{Call, Done, Handle};
use crate::status::Fault;
use crate::status::pfront_status_t::PFRONT_DAMAGED;
use crate::verbs::pfront_pair_t;
use bytemuck::Pod;
use core::ffi::{CStr, c_void};
use pfront::{ContactPatch, Impact, Model, Scalar, SegmentHit, Solid, TrianglePair};
use pfront_capi_entry::entry;
use std::sync::Arc;

/// A mesh and its BVH, for the bodies of scenes. Any number of threads and scenes may use one at once.
pub struct pfront_model_t(());

impl Handle for pfront_model_t {
    type Value = Arc<Model>;
    const SEAL: u32 = u32::from_be_bytes(*b"modl");
}

/// Makes a model of a vertex buffer and an index buffer, which are copied, and builds its BVH by the surface area
/// heuristic.
#[entry]
fn pfront_model_create(
    call: &mut Call<'_>,
    buffers: *const pfront_buffers_t,
    model: *mut *mut pfront_model_t,
) -> Done {
    let out = call.out(c"model", model)?;
    let (positions, triangles) = call.get(c"buffers", buffers)?.checked(&NAMES)?.copies(call)?;
    out.set(Call::boxed(Arc::new(Model::new(positions, triangles)?))?);
    Ok(())
}

/// `pfront_model_create` of positions in double in place of float: `stride` is at least 24, and 0 stands for 24. Coordinates
/// are at most 2^125. Questions about the model are decided in f64, exactly for the positions given, whatever the other body
/// and the poses. Takes 24 bytes a vertex more, unless floats hold every coordinate.
#[entry]
fn pfront_model_create_f64(
    call: &mut Call<'_>,
    buffers: *const pfront_buffers_t,
    model: *mut *mut pfront_model_t,
) -> Done {
    let out = call.out(c"model", model)?;
    let (positions, triangles) = call.get(c"buffers", buffers)?.checked(&NAMES)?.copies(call)?;
    out.set(Call::boxed(Arc::new(Model::from_f64(positions, triangles)?))?);
    Ok(())
}

/// Makes a model of a blob, whose mesh and BVH are checked and copied, so that nothing is built. The bytes may lie
/// anywhere, and are of no use afterwards.
#[entry]
fn pfront_model_from_blob(
    call: &mut Call<'_>,
    blob: *const c_void,
    blob_bytes: usize,
    model: *mut *mut pfront_model_t,
) -> Done {
    let out = call.out(c"model", model)?;
    let bytes = call.read(c"blob", blob.cast::<u8>(), blob_bytes)?;
    out.set(Call::boxed(Arc::new(Model::from_blob(bytes)?))?);
    Ok(())
}

/// Moves the vertices of a model, given in its own frame: as many as it has, `stride` bytes apart, where 0 stands for 12. The threads of `executor`
/// refit its BVH, or the calling one if that is null; for a GPU, the next question refits it there. Bodies that were made of the model stay
/// as they are, and so do queries that keep it: then the model is copied first, also for positions that are refused. PFRONT_BUSY if another thread is inside a call
/// with it. In O(vertices + triangles), but that a BVH which has worn is built anew.
#[entry]
fn pfront_model_set_positions(
    call: &mut Call<'_>,
    model: *mut pfront_model_t,
    executor: *const pfront_executor_t,
    positions: *const c_void,
    vertex_count: usize,
    stride: usize,
) -> Done {
    let buffers = pfront_buffers_t::of_vertices(positions, vertex_count, stride);
    set_positions::<f32>(call, model, executor, buffers)
}

/// `pfront_model_set_positions` of a model in f64, of positions in double: 0 stands for 24.
#[entry]
fn pfront_model_set_positions_f64(
    call: &mut Call<'_>,
    model: *mut pfront_model_t,
    executor: *const pfront_executor_t,
    positions: *const c_void,
    vertex_count: usize,
    stride: usize,
) -> Done {
    let buffers = pfront_buffers_t::of_vertices(positions, vertex_count, stride);
    set_positions::<f64>(call, model, executor, buffers)
}

fn set_positions<S: Scalar + Pod>(
    call: &mut Call<'_>,
    model: *mut pfront_model_t,
    executor: *const pfront_executor_t,
    buffers: pfront_buffers_t,
) -> Done {
    let own = OwnExecutor::of(call, executor)?;
    let model = call.owned(c"model", model)?;
    let (positions, _) = buffers.checked::<[S; 3]>(&NAMES)?.copies(call)?;
    if Arc::get_mut(model).is_none() {
        *model = Arc::new(model.try_clone()?);
    }
    // It has no other owner now.
    Ok(own.executor.refit(Arc::make_mut(model), &positions)?)
}

/// Frees a model; null is fine. Bodies that were made of it stay as they are. PFRONT_BUSY if another thread is inside a call
/// with it.
#[entry]
fn pfront_model_free(call: &mut Call<'_>, model: *mut pfront_model_t) -> Done {
    call.free(c"model", model)
}

/// A connected part of what two surfaces have in common: a point, curves, areas, or what is joined of these.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_patch_t {
    /// 0 for a point, 1 for curves, 2 if there are areas.
    pub dimension: u32,
    /// 1 if it surely has no end, else 0: a curve that comes back to where it began, or areas without an outline.
    pub is_closed: u32,
    /// The number of triangle pairs that meet there.
    pub pair_count: usize,
    /// The first of them.
    pub pair: pfront_pair_t,
    /// The least and the greatest that the length of its curves and of the outlines of its areas can be.
    pub length: [f64; 2],
    /// The least and the greatest that its area can be.
    pub area: [f64; 2],
}

impl From<ContactPatch> for pfront_patch_t {
    fn from(patch: ContactPatch) -> Self {
        Self {
            dimension: patch.dimension as u32,
            is_closed: patch.is_closed.into(),
            pair_count: patch.pairs.len(),
            pair: patch.pairs.first().copied().unwrap_or_default().into(),
            length: patch.length,
            area: patch.area,
        }
    }
}

/// When two triangles meet first, as far as it is proven.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_impact_t {
    /// The triangles.
    pub pair: pfront_pair_t,
    /// They do not meet before this time; 0 is the start of the motion and 1 its end.
    pub from: f64,
    /// They certainly meet between `from` and this time; INFINITY if that is open, as where they touch and do not pass.
    pub to: f64,
}

impl From<(TrianglePair, Impact)> for pfront_impact_t {
    fn from((pair, Impact { from, to }): (TrianglePair, Impact)) -> Self {
        Self { pair: pair.into(), from, to }
    }
}

/// A triangle that a segment meets.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_segment_hit_t {
    /// The triangle.
    pub triangle: u32,
    /// The parameter of their first common point, rounded: 0 where the segment starts, 1 where it ends.
    pub at: f64,
}

impl From<SegmentHit> for pfront_segment_hit_t {
    fn from(SegmentHit { triangle, at }: SegmentHit) -> Self {
        Self { triangle, at }
    }
}

/// The names of two models.
pub(crate) const MODEL_NAMES: [&CStr; 2] = [c"a", c"b"];

/// The models that a query was last asked about as solids, with what has to be known of them once.
#[derive(Default)]
pub(crate) struct Solids([Option<Solid>; 2]);

impl Solids {
    /// The solids of two models, made anew unless they are those of the last question.
    pub(crate) fn of(&mut self, models: [&Arc<Model>; 2]) -> Result<[&Solid; 2], Fault> {
        for ((kept, model), name) in self.0.iter_mut().zip(models).zip(MODEL_NAMES) {
            keep(kept, model, name)?;
        }
        match &self.0 {
            [Some(a), Some(b)] => Ok([a, b]),
            _ => Err(Fault::new(PFRONT_DAMAGED)),
        }
    }

    /// The solid of one model that C calls `name`.
    pub(crate) fn one(&mut self, model: &Arc<Model>, name: &'static CStr) -> Result<&Solid, Fault> {
        let [kept, _] = &mut self.0;
        keep(kept, model, name)
    }
}

/// The solid of a model that C calls `name`, made anew unless it is the one that is kept.
fn keep<'s>(
    kept: &'s mut Option<Solid>,
    model: &Arc<Model>,
    name: &'static CStr,
) -> Result<&'s Solid, Fault> {
    match kept.take().filter(|solid| Arc::ptr_eq(solid.model(), model)) {
        Some(solid) => Ok(kept.insert(solid)),
        None => {
            let solid = Solid::new(model.clone());
            Ok(kept.insert(solid.map_err(|error| Fault::from(error).named(name))?))
        }
    }
}
