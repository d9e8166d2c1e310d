//! Triangles that a segment meets, and the location of points.

use crate::memory::{Call, Done};
use crate::model::{pfront_model_t, pfront_segment_hit_t};
use crate::status::Fault;
use crate::status::pfront_status_t::{PFRONT_NOT_FINITE, PFRONT_POSITION_RANGE};
use crate::subject::{ModelQuery, pfront_model_query_t};
use core::ffi::CStr;
use pfront::{Error, Location, MeshError};
use pfront_capi_entry::entry;

/// Where a point is, as a solid sees it.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum pfront_location_t {
    /// Neither inside nor on the surface.
    PFRONT_LOCATION_OUTSIDE = 0,
    /// In the interior.
    PFRONT_LOCATION_INSIDE = 1,
    /// On a triangle, also on one that bounds nothing.
    PFRONT_LOCATION_SURFACE = 2,
}

impl From<Location> for pfront_location_t {
    fn from(location: Location) -> Self {
        match location {
            Location::Outside => Self::PFRONT_LOCATION_OUTSIDE,
            Location::Inside => Self::PFRONT_LOCATION_INSIDE,
            Location::Surface => Self::PFRONT_LOCATION_SURFACE,
        }
    }
}

/// The names of the ends of a segment.
pub(crate) const ENDS: [&CStr; 2] = [c"from", c"to"];

/// A fault of points with these names.
pub(crate) fn of_points(names: [&'static CStr; 2]) -> impl Fn(Error) -> Fault {
    move |error| match error {
        Error::Mesh(MeshError::NonFinite { vertex }) => {
            Fault::of(PFRONT_NOT_FINITE, names[vertex.min(1)])
        }
        Error::Mesh(MeshError::Range { vertex }) => {
            Fault::of(PFRONT_POSITION_RANGE, names[vertex.min(1)])
        }
        other => other.into(),
    }
}

/// Both ends of a segment.
pub(crate) fn ends(
    call: &Call<'_>,
    from: *const f64,
    to: *const f64,
) -> Result<[[f64; 3]; 2], Fault> {
    let [own, other] = ENDS;
    Ok([call.get(own, from.cast())?, call.get(other, to.cast())?])
}

/// A query in the process that it belongs to.
fn owned<'c>(
    call: &mut Call<'c>,
    query: *mut pfront_model_query_t,
) -> Result<&'c mut ModelQuery, Fault> {
    let query = call.owned(c"query", query)?;
    query.own.check(c"query")?;
    Ok(query)
}

/// Finds all triangles of a model that the closed segment between two points meets, each of 3 doubles: `count` of them in `hits`, sorted by
/// triangles. Exactly: touching counts, and a segment from a point to itself is that point. Coordinates are at most 2^125. `hits` belongs
/// to the query and is good until this is called again, or the query is freed. The calling thread answers, whatever the executor.
#[entry]
fn pfront_model_query_segment(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    model: *const pfront_model_t,
    from: *const f64,
    to: *const f64,
    hits: *mut *const pfront_segment_hit_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"hits", hits, count)?;
    let [from, to] = ends(call, from, to)?;
    let (ModelQuery { segment_hits, .. }, model) =
        (owned(call, query)?, call.cloned(c"model", model)?);
    let found = model.segment(from, to).map_err(of_points(ENDS))?;
    out.set(segment_hits, found.into_iter().map(pfront_segment_hit_t::from))
}

/// Finds the first triangle of a model along the segment from one point to another, each of 3 doubles: `found` is 1 and `hit` tells it,
/// else 0 and `hit` is not written. Exactly: of triangles that it meets in one point, the one with the lowest index. Any number of threads may ask
/// about a model at once.
#[entry]
fn pfront_model_segment_first(
    call: &mut Call<'_>,
    model: *const pfront_model_t,
    from: *const f64,
    to: *const f64,
    hit: *mut pfront_segment_hit_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"hit", hit)?, call.out(c"found", found)?);
    let [from, to] = ends(call, from, to)?;
    let first = call.cloned(c"model", model)?.segment_first(from, to).map_err(of_points(ENDS))?;
    out.set_some(is_found, first.map(pfront_segment_hit_t::from));
    Ok(())
}

/// Tells for each of `point_count` points, of 3 doubles, where it is, as a model sees it whose mesh is closed: a `pfront_location_t` in each
/// of `locations`. Exactly, by winding numbers, also where triangles meet their own mesh. A model that is no solid is PFRONT_OPEN_EDGE,
/// PFRONT_MEETS_ITSELF or PFRONT_NO_VOLUME; a point at fault is `index` of the error. The query keeps a model as
/// for `pfront_model_query_relation`.
#[entry]
fn pfront_model_query_inside(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    model: *const pfront_model_t,
    points: *const f64,
    point_count: usize,
    locations: *mut u32,
) -> Done {
    let points = call.read(c"points", points.cast::<[f64; 3]>(), point_count)?;
    let locations = call.write(c"locations", locations, point_count)?;
    let (ModelQuery { solids, .. }, model) = (owned(call, query)?, call.cloned(c"model", model)?);
    let solid = solids.one(&model, c"model")?;
    for (index, (point, location)) in points.iter().zip(locations).enumerate() {
        let found = solid.inside(*point);
        let found = found.map_err(|error| of_points([c"points"; 2])(error).at(index))?;
        *location = pfront_location_t::from(found) as u32;
    }
    Ok(())
}
