//! The triangles of the bodies of a scene that meet, and where.

#![expect(
    unsafe_code,
    reason = "C finds functions by name, and keeps to the contract of the header"
)]
#![expect(
    clippy::missing_safety_doc,
    reason = "the header has the contract, once for all functions"
)]

use super::{Scene, pfront_scene_t, usable};
use crate::memory::Caller;
use crate::status::pfront_status_t::{self, PFRONT_OUT_OF_MEMORY};
use crate::status::{Fault, pfront_error_t};
use crate::verbs::{pfront_contact_t, pfront_pair_t};
use pfront::{BodyId, Contact, SceneHit, TrianglePair};

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
    fn from(SceneHit { bodies, pair: TrianglePair { a, b } }: SceneHit) -> Self {
        Self { bodies: bodies.map(BodyId::to_bits), pair: pfront_pair_t { a, b } }
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

/// Replaces what was handed out by so many others.
pub(crate) fn replace<T>(
    list: &mut Vec<T>,
    count: usize,
    with: impl Iterator<Item = T>,
) -> Result<(), Fault> {
    list.clear();
    let bytes = count.saturating_mul(size_of::<T>());
    let fault = Fault::of(PFRONT_OUT_OF_MEMORY, c"malloc").numbers(bytes, 0);
    list.try_reserve(count).map_err(|_| fault)?;
    list.extend(with);
    Ok(())
}

/// Finds all pairs of triangles of different bodies that meet: `count` of them in `hits`, sorted by bodies, then
/// triangles. They belong to the scene and are good until this is called again, or the scene is freed. Answers about
/// bodies that stand still are kept, so that a frame costs what the others do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_scene_update(
    scene: *mut pfront_scene_t,
    hits: *mut *const pfront_scene_hit_t,
    count: *mut usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, out_count) = (call.out(c"hits", hits)?, call.out(c"count", count)?);
        let Scene { query, hits, .. } = usable(call, scene)?;
        let found = query.all()?;
        replace(hits, found.len(), found.iter().map(|&hit| hit.into()))?;
        out.set(hits.as_ptr());
        out_count.set(hits.len());
        Ok(())
    })
}

/// `pfront_scene_update` that also tells where they meet. `contacts` belongs to the scene and is good until this is called
/// again, or the scene is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_scene_contacts(
    scene: *mut pfront_scene_t,
    contacts: *mut *const pfront_scene_contact_t,
    count: *mut usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, out_count) = (call.out(c"contacts", contacts)?, call.out(c"count", count)?);
        let Scene { query, contacts, .. } = usable(call, scene)?;
        let found = query.contacts()?;
        let for_c = |&(hit, contact): &(SceneHit, Contact)| pfront_scene_contact_t {
            hit: hit.into(),
            contact: Some(contact).into(),
        };
        replace(contacts, found.len(), found.iter().map(for_c))?;
        out.set(contacts.as_ptr());
        out_count.set(contacts.len());
        Ok(())
    })
}

/// `pfront_scene_contacts` in f64: of bodies in f64 not rounded. Only the hits are kept from frame to frame. `contacts` is good
/// until this is called again, or the scene is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_scene_contacts_f64(
    scene: *mut pfront_scene_t,
    contacts: *mut *const pfront_scene_contact64_t,
    count: *mut usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, out_count) = (call.out(c"contacts", contacts)?, call.out(c"count", count)?);
        let Scene { query, contacts_f64, .. } = usable(call, scene)?;
        let found = query.contacts_f64()?;
        let for_c = |&(hit, contact): &(SceneHit, Contact<f64>)| {
            let Contact { is_flat, segment, normals } = contact;
            pfront_scene_contact64_t { hit: hit.into(), is_flat: is_flat.into(), segment, normals }
        };
        replace(contacts_f64, found.len(), found.iter().map(for_c))?;
        out.set(contacts_f64.as_ptr());
        out_count.set(contacts_f64.len());
        Ok(())
    })
}

/// Finds some pair of triangles of different bodies that meet, and stops at the first: `found` is 1 if there is one,
/// else 0 and `hit` is not written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_scene_any(
    scene: *mut pfront_scene_t,
    hit: *mut pfront_scene_hit_t,
    found: *mut u32,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, is_found) = (call.out(c"hit", hit)?, call.out(c"found", found)?);
        let some = usable(call, scene)?.query.any()?;
        is_found.set(some.is_some().into());
        if let Some(hit) = some {
            out.set(hit.into());
        }
        Ok(())
    })
}

/// Tells how many pairs of triangles of different bodies meet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_scene_count(
    scene: *mut pfront_scene_t,
    count: *mut u64,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let out = call.out(c"count", count)?;
        out.set(usable(call, scene)?.query.count()?);
        Ok(())
    })
}
