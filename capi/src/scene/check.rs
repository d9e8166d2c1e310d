//! The relations of all bodies of a scene.

use super::{Scene, pfront_scene_t, usable};
use crate::memory::{Call, Done};
use crate::relation::{RELATIONS, pair_or_none, pfront_relation_t};
use crate::status::Fault;
use crate::status::pfront_status_t::{self, PFRONT_OUT_OF_RANGE};
use crate::verbs::pfront_pair_t;
use pfront::{Allowed, BodyId, CheckedPair, NotSolid};
use pfront_capi_entry::entry;

/// The relations of two bodies that are allowed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_allowed_t {
    /// The sum of `1 << relation`, a `pfront_relation_t` each. PFRONT_RELATION_UNDETERMINED never is.
    pub relations: u32,
    /// The largest volume by which bodies that cross may overlap; 0 for none.
    pub overlap_volume: f64,
    /// 1 to measure contacts too, else 0.
    pub with_contacts: u32,
}

/// Two bodies whose boxes overlap. Numbers that were not asked for are NaN.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_checked_pair_t {
    /// The bodies, that which was added first before the other.
    pub bodies: [u64; 2],
    /// The relation of the first to the second.
    pub relation: pfront_relation_t,
    /// 1 if that is allowed, else 0.
    pub is_allowed: u32,
    /// 1 if the surfaces meet, else 0.
    pub meets: u32,
    /// Triangles that show it, or on which it hangs; UINT32_MAX twice if there are none.
    pub pair: pfront_pair_t,
    /// The least and the greatest that the common volume of bodies that cross can be, if neither meets itself.
    pub overlap_volume: [f64; 2],
    /// The connected patches of what the surfaces have in common, if contacts were asked for; else 0.
    pub patches: usize,
    /// The dimension of these: 0 for points alone, 1 for curves, 2 if there are areas.
    pub dimension: u32,
    /// The least and the greatest that the length of their curves and of the outlines of their areas can be.
    pub length: [f64; 2],
    /// The least and the greatest that their area can be.
    pub area: [f64; 2],
    /// The least and the greatest that the smallest distance of bodies that are near can be.
    pub gap: [f64; 2],
    /// A point in the world where the triangles meet.
    pub place: [f64; 3],
}

impl From<&CheckedPair> for pfront_checked_pair_t {
    fn from(found: &CheckedPair) -> Self {
        Self {
            bodies: found.bodies.map(BodyId::to_bits),
            relation: found.relation.into(),
            is_allowed: found.is_allowed.into(),
            meets: found.meets.into(),
            pair: pair_or_none(found.pair),
            overlap_volume: found.overlap_volume.unwrap_or([f64::NAN; 2]),
            patches: found.contact.map_or(0, |size| size.patches),
            dimension: found.contact.map_or(0, |size| size.dimension as u32),
            length: found.contact.map_or([f64::NAN; 2], |size| size.length),
            area: found.contact.map_or([f64::NAN; 2], |size| size.area),
            gap: found.gap.unwrap_or([f64::NAN; 2]),
            place: found.place.unwrap_or([f64::NAN; 3]),
        }
    }
}

/// A body that is no solid, so that what it is to others is undetermined.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_refused_body_t {
    /// The body.
    pub body: u64,
    /// PFRONT_OPEN_EDGE, PFRONT_MEETS_ITSELF or PFRONT_NO_VOLUME.
    pub status: pfront_status_t,
    /// The triangle at fault, as `index` of an error; 0 if there is no volume.
    pub triangle: u32,
    /// Its open edge or the other triangle, as `given` of an error; 0 if there is no volume.
    pub given: u32,
}

impl From<&(BodyId, NotSolid)> for pfront_refused_body_t {
    fn from((body, error): &(BodyId, NotSolid)) -> Self {
        let Fault { status, index, given, .. } = Fault::from(*error);
        Self { body: body.to_bits(), status, triangle: index as u32, given: given as u32 }
    }
}

/// Finds the relation of every two bodies whose boxes overlap, and whether it is allowed: `count` rows in `pairs`, sorted by bodies, and the
/// bodies among them that are no solids, `refused_count` in `refused`. If `allowed` is null, bodies may be apart or touch, and overlap by
/// nothing. With `pfront_scene_within`, bodies that are apart are near if they are at most so far apart. Bodies that ignore each other are left out. CPUs
/// answer, whatever the executor. Both lists belong to the scene and are good until this is called again, or the scene is freed.
///
/// Each pair is asked in the frame of its first body, so that parts that are flush and turned alike stay flush.
#[entry]
fn pfront_scene_check(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    allowed: *const pfront_allowed_t,
    pairs: *mut *const pfront_checked_pair_t,
    count: *mut usize,
    refused: *mut *const pfront_refused_body_t,
    refused_count: *mut usize,
) -> Done {
    let out = call.out_array(c"pairs", pairs, count)?;
    let out_refused = call.out_list(c"refused", refused, c"refused_count", refused_count)?;
    let Scene { query, checked, refused, .. } = usable(call, scene)?;
    let mut may = Allowed::default();
    if !allowed.is_null() {
        let pfront_allowed_t { relations, overlap_volume, with_contacts } =
            call.get(c"allowed", allowed)?;
        let known = RELATIONS.iter().fold(0, |known, (_, name)| known | 1 << *name as u32);
        if relations & !known != 0 {
            return Err(Fault::of(PFRONT_OUT_OF_RANGE, c"relations"));
        }
        if overlap_volume.is_nan() || overlap_volume < 0.0 {
            return Err(Fault::of(PFRONT_OUT_OF_RANGE, c"overlap_volume"));
        }
        let is_allowed = |name: pfront_relation_t| relations & 1 << name as u32 != 0;
        let all = RELATIONS.iter().filter(|(_, name)| is_allowed(*name));
        may.relations = all.map(|(relation, _)| *relation).collect();
        may.overlap_volume = overlap_volume;
        may.with_contacts = with_contacts != 0;
    }
    let report = query.check(&may)?;
    out.set(checked, report.pairs.iter().map(pfront_checked_pair_t::from))?;
    out_refused.set(refused, report.refused.iter().map(pfront_refused_body_t::from))
}
