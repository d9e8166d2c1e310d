//! The triangles of the bodies of a scene that meet, and where.

use super::{Scene, pfront_scene_t, usable};
use crate::memory::{Call, Done};
use crate::verbs::{pfront_contact_t, pfront_pair_t};
use pfront::{BodyId, Contact, SceneHit};
use pfront_capi_entry::entry;

/// Two triangles of different bodies that meet.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_scene_hit_t {
    /// The bodies, the one that was added first before the other.
    pub bodies: [u64; 2],
    /// A triangle of the first body and one of the second.
    pub pair: pfront_pair_t,
}

impl From<SceneHit> for pfront_scene_hit_t {
    fn from(SceneHit { bodies, pair }: SceneHit) -> Self {
        Self { bodies: bodies.map(BodyId::to_bits), pair: pair.into() }
    }
}

/// Two triangles of different bodies that meet, and where they do, in the world.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_scene_contact_t {
    /// The triangles.
    pub hit: pfront_scene_hit_t,
    /// Where they meet.
    pub contact: pfront_contact_t,
}

/// `pfront_scene_contact_t` in f64.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_scene_contact64_t {
    /// The triangles.
    pub hit: pfront_scene_hit_t,
    /// Whether they lie in one plane, or one has no area: then the segment is the longest chord between corners of the
    /// region they share.
    pub is_flat: u64,
    /// The ends of the segment in which they meet.
    pub segment: [[f64; 3]; 2],
    /// Unit normals of both by the right-hand rule; 0 for a triangle without area.
    pub normals: [[f32; 3]; 2],
}

/// Finds all pairs of triangles of different bodies that meet: `count` of them in `hits`, sorted by bodies, then
/// triangles. They belong to the scene and are good until this is called again, or the scene is freed. Answers about
/// bodies that stand still are kept, so that a frame costs what the others do.
#[entry]
fn pfront_scene_update(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    hits: *mut *const pfront_scene_hit_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"hits", hits, count)?;
    let Scene { query, hits, .. } = usable(call, scene)?;
    out.set(hits, query.all()?.iter().map(|&hit| hit.into()))
}

/// `pfront_scene_update` that also tells where they meet. `contacts` belongs to the scene and is good until this is called
/// again, or the scene is freed.
#[entry]
fn pfront_scene_contacts(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    contacts: *mut *const pfront_scene_contact_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"contacts", contacts, count)?;
    let Scene { query, contacts, .. } = usable(call, scene)?;
    let found = query.contacts()?;
    let for_c = |&(hit, contact): &(SceneHit, Contact)| pfront_scene_contact_t {
        hit: hit.into(),
        contact: Some(contact).into(),
    };
    out.set(contacts, found.iter().map(for_c))
}

/// `pfront_scene_contacts` in f64: of bodies in f64 not rounded. Only the hits are kept from frame to frame. `contacts` is good
/// until this is called again, or the scene is freed.
#[entry]
fn pfront_scene_contacts_f64(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    contacts: *mut *const pfront_scene_contact64_t,
    count: *mut usize,
) -> Done {
    let out = call.out_array(c"contacts", contacts, count)?;
    let Scene { query, contacts_f64, .. } = usable(call, scene)?;
    let found = query.contacts_f64()?;
    let for_c = |&(hit, contact): &(SceneHit, Contact<f64>)| {
        let Contact { is_flat, segment, normals } = contact;
        pfront_scene_contact64_t { hit: hit.into(), is_flat: is_flat.into(), segment, normals }
    };
    out.set(contacts_f64, found.iter().map(for_c))
}

/// Finds some pair of triangles of different bodies that meet, and stops at the first: `found` is 1 if there is one,
/// else 0 and `hit` is not written.
#[entry]
fn pfront_scene_any(
    call: &mut Call<'_>,
    scene: *mut pfront_scene_t,
    hit: *mut pfront_scene_hit_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"hit", hit)?, call.out(c"found", found)?);
    let some = usable(call, scene)?.query.any()?;
    out.set_some(is_found, some.map(pfront_scene_hit_t::from));
    Ok(())
}

/// Tells how many pairs of triangles of different bodies meet.
#[entry]
fn pfront_scene_count(call: &mut Call<'_>, scene: *mut pfront_scene_t, count: *mut u64) -> Done {
    let out = call.out(c"count", count)?;
    out.set(usable(call, scene)?.query.count()?);
    Ok(())
}
