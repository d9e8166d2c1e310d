//! Triangles of bodies that a segment meets, and bodies that contain a point.

use super::{Scene, pfront_scene_t, usable};
use crate::memory::{Call, Done};
use crate::model::pfront_segment_hit_t;
use crate::segment::{ENDS, ends, of_points, pfront_location_t};
use crate::status::Fault;
use crate::status::pfront_status_t::{self, PFRONT_OK};
use pfront::{BodyId, BodyLocation, Location, SegmentHit};
use pfront_capi_entry::entry;

/// A triangle of a body that a segment meets.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_scene_segment_hit_t {
    /// The body.
    pub body: u64,
    /// The triangle, and where.
    pub hit: pfront_segment_hit_t,
}

impl From<(BodyId, SegmentHit)> for pfront_scene_segment_hit_t {
    fn from((body, hit): (BodyId, SegmentHit)) -> Self {
        Self { body: body.to_bits(), hit: hit.into() }
    }
}

/// A body that contains a point, or whose box does and which is no solid.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_containing_body_t {
    /// The body.
    pub body: u64,
    /// Inside, or on the surface; outside if it is no solid.
    pub location: pfront_location_t,
    /// PFRONT_OK, or PFRONT_OPEN_EDGE if it is no solid.
    pub status: pfront_status_t,
    /// The triangle at fault, as `index` of an error; 0 if there is none.
    pub triangle: u32,
    /// Its open edge, as `given` of an error; 0 if there is none.
    pub given: u32,
}

impl From<BodyLocation> for pfront_containing_body_t {
    fn from(BodyLocation { body, location }: BodyLocation) -> Self {
        let fault = location.map_or_else(Fault::from, |_| Fault::new(PFRONT_OK));
        Self {
            body: body.to_bits(),
            location: location.unwrap_or(Location::Outside).into(),
            status: fault.status,
            triangle: fault.index as u32,
            given: fault.given as u32,
        }
    }
}

/// Finds all triangles that the closed segment between two points of the world meets, each of 3 doubles: `count` of them in `hits`, sorted
/// by bodies, then triangles. Exactly, for the bodies as they are posed, each in the precision of its model and its pose; touching counts. `hits`
/// belongs to the scene and is good until this is called again, or the scene is freed. The calling thread answers, whatever the executor.
#[entry]
fn pfront_scene_segment(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    from: *const f64,
    to: *const f64,
    hits: *mut *const pfront_scene_segment_hit_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"hits", hits, count)?;
    let [from, to] = ends(call, from, to)?;
    let Scene { query, segment_hits, .. } = usable(call, scene)?;
    let found = query.segment(from, to).map_err(of_points(ENDS))?;
    out.set(segment_hits, found.into_iter().map(pfront_scene_segment_hit_t::from))
}

/// Finds the first triangle along the segment from one point of the world to another, each of 3 doubles: `found` is 1 and `hit` tells it,
/// else 0 and `hit` is not written. Exactly: of triangles that it meets in one point, that of the body that was added first, and of its triangles
/// the one with the lowest index.
#[entry]
fn pfront_scene_segment_first(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    from: *const f64,
    to: *const f64,
    hit: *mut pfront_scene_segment_hit_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"hit", hit)?, call.out(c"found", found)?);
    let [from, to] = ends(call, from, to)?;
    let first = usable(call, scene)?.query.segment_first(from, to).map_err(of_points(ENDS))?;
    out.set_some(is_found, first.map(pfront_scene_segment_hit_t::from));
    Ok(())
}

/// Finds the bodies that contain a point of the world, of 3 doubles, in their interior or on their surface: `count` of them in `bodies`, in the order of
/// adding, and among them those whose box contains it and whose mesh is open. Exactly, for the bodies as they are posed. `bodies`
/// belongs to the scene and is good until this is called again, or the scene is freed. The calling thread answers, whatever the executor.
#[entry]
fn pfront_scene_inside(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    point: *const f64,
    bodies: *mut *const pfront_containing_body_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"bodies", bodies, count)?;
    let point: [f64; 3] = call.get(c"point", point.cast())?;
    let Scene { query, containing, .. } = usable(call, scene)?;
    let found = query.inside(point).map_err(of_points([c"point"; 2]))?;
    out.set(containing, found.into_iter().map(pfront_containing_body_t::from))
}
