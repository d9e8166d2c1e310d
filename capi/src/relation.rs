//! Relations of solids, and by how much they overlap.

use crate::memory::{Call, Done};
use crate::model::{MODEL_NAMES, pfront_patch_t};
use crate::status::Fault;
use crate::status::pfront_status_t::PFRONT_NULL;
use crate::subject::{ModelQuery, Subject, asked, fault, pfront_model_query_t, pfront_subject_t};
use crate::verbs::pfront_pair_t;
use pfront::{AnyPose, Between, Error, Model, NotSolid, Relation, TrianglePair};
use pfront_capi_entry::entry;
use std::sync::Arc;

/// The relation of a solid a to a solid b, by their interiors and their surfaces.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum pfront_relation_t {
    /// It hangs on triangles that meet their own mesh, or a body is no solid.
    PFRONT_RELATION_UNDETERMINED = 0,
    /// No point in common.
    PFRONT_RELATION_APART = 1,
    /// Apart, and at most the distance away that was asked for.
    PFRONT_RELATION_NEAR = 2,
    /// The surfaces meet, the interiors do not.
    PFRONT_RELATION_TOUCHING = 3,
    /// The interiors meet, and each solid is partly outside of the other.
    PFRONT_RELATION_CROSSING = 4,
    /// a is inside b, and not all of b is in a. Their surfaces may meet.
    PFRONT_RELATION_A_IN_B = 5,
    /// b is inside a, and not all of a is in b.
    PFRONT_RELATION_B_IN_A = 6,
    /// The same solid, whatever its triangles.
    PFRONT_RELATION_EQUAL = 7,
}

use pfront_relation_t::*;

/// All relations that are determined, with the names of C.
pub(crate) const RELATIONS: [(Relation, pfront_relation_t); 7] = [
    (Relation::Apart, PFRONT_RELATION_APART),
    (Relation::Near, PFRONT_RELATION_NEAR),
    (Relation::Touching, PFRONT_RELATION_TOUCHING),
    (Relation::Crossing, PFRONT_RELATION_CROSSING),
    (Relation::AInB, PFRONT_RELATION_A_IN_B),
    (Relation::BInA, PFRONT_RELATION_B_IN_A),
    (Relation::Equal, PFRONT_RELATION_EQUAL),
];

impl From<Option<Relation>> for pfront_relation_t {
    fn from(relation: Option<Relation>) -> Self {
        let found = RELATIONS.iter().find(|(own, _)| Some(*own) == relation);
        found.map_or(PFRONT_RELATION_UNDETERMINED, |(_, name)| *name)
    }
}

/// Two triangles, or UINT32_MAX twice where there are none.
pub(crate) fn pair_or_none(pair: Option<TrianglePair>) -> pfront_pair_t {
    pair.unwrap_or(TrianglePair { a: u32::MAX, b: u32::MAX }).into()
}

/// The answer about two solids.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_between_t {
    /// The relation of a to b.
    pub relation: pfront_relation_t,
    /// 1 if the surfaces meet, as those of nested solids may, else 0.
    pub meets: u32,
    /// Triangles that show it, or on which it hangs; UINT32_MAX twice if there are none. They may differ between executors.
    pub pair: pfront_pair_t,
}

impl From<Between> for pfront_between_t {
    fn from(Between { relation, meets, pair, .. }: Between) -> Self {
        Self { relation: relation.into(), meets: meets.into(), pair: pair_or_none(pair) }
    }
}

/// The two models of a subject, and the pose of the second.
fn pair(subject: &Subject) -> Result<([&Arc<Model>; 2], AnyPose), Fault> {
    match subject {
        Subject::Pair(a, b, pose) => Ok(([a, b], *pose)),
        Subject::Itself(..) => Err(Fault::of(PFRONT_NULL, MODEL_NAMES[1])),
    }
}

/// Finds what one solid is to another, exactly: models whose meshes are closed. Vertices at the same place are one, and several bodies in
/// one mesh are one solid. With `pfront_model_query_within`, solids that are apart are near if they are at most so far apart. A model and
/// itself are PFRONT_NULL, and what is no solid is PFRONT_OPEN_EDGE, PFRONT_MEETS_ITSELF or PFRONT_NO_VOLUME.
///
/// Rounding alone can make flush parts cross by a trifle: ask for the volume before calling that a clash. The query keeps
/// a model with what has to be known of it once, 36 bytes a triangle and 44 a vertex, until it is asked about another one as a solid.
#[entry]
fn pfront_model_query_relation(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    between: *mut pfront_between_t,
) -> Done {
    let out = call.out(c"between", between)?;
    let (ModelQuery { pair: query, solids, .. }, subject) = asked(call, query, subject)?;
    let (models, pose) = pair(&subject)?;
    let [a, b] = solids.of(models)?;
    out.set(query.relation(a, b, pose).map_err(fault)?.into());
    Ok(())
}

/// Finds the volume that two solids have in common, in the units of `a`: it is at least `low` and at most `high`. All else is as for
/// `pfront_model_query_relation`, but triangles of a model that meet beyond the corners that they share, inside the other
/// solid or on its surface, are PFRONT_MEETS_ITSELF here.
#[entry]
fn pfront_model_query_overlap_volume(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    low: *mut f64,
    high: *mut f64,
) -> Done {
    let (least, greatest) = (call.out(c"low", low)?, call.out(c"high", high)?);
    let (ModelQuery { pair: query, solids, .. }, subject) = asked(call, query, subject)?;
    let (models, pose) = pair(&subject)?;
    let both = solids.of(models)?;
    let volume = query.overlap_volume(both[0], both[1], pose);
    let [low, high] = volume.map_err(|error| match error {
        Error::Solid(why @ NotSolid::MeetsItself { pair }) => {
            let named = both.iter().zip(MODEL_NAMES).find(|(s, _)| s.marked_pair() == Some(pair));
            let fault = Fault::from(why);
            match named {
                Some((_, name)) => fault.named(name),
                None => fault,
            }
        }
        error => fault(error),
    })?;
    least.set(low);
    greatest.set(high);
    Ok(())
}

/// Finds all that two surfaces have in common, in connected patches: `count` of them in `patches`, in the order of their first pairs, in the
/// units of `a`. Exact signs tell what is connected; lengths and areas are intervals. Vertices at the same place are one. Where a mesh
/// meets itself, what it covers twice counts twice. A model and itself are PFRONT_NULL. `patches` belongs to the query and is good
/// until this is called again, or the query is freed.
#[entry]
fn pfront_model_query_patches(
    call: &mut Call<'_>,
    query: *mut pfront_model_query_t,
    subject: *const pfront_subject_t,
    patches: *mut *const pfront_patch_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"patches", patches, count)?;
    let (ModelQuery { pair: query, patches, .. }, subject) = asked(call, query, subject)?;
    let ([a, b], pose) = pair(&subject)?;
    let found = query.patches(a, b, pose).map_err(fault)?;
    out.set(patches, found.into_iter().map(pfront_patch_t::from))
}
