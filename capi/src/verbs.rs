//! Questions answered.

use crate::cursor::{on_walk, pfront_cursor_t};
use crate::memory::{Call, Done};
use crate::query::pfront_query_t;
use crate::status::Fault;
use core::mem::offset_of;
use core::ops::ControlFlow::{Break, Continue};
use pfront_capi_entry::entry;
use pfront_core::bvtt::{Query, TrianglePair};
use pfront_core::triangle::Contact;

/// Two triangles that meet: one of the first mesh and one of the second, or two of one mesh with `a < b`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_pair_t {
    /// Triangle of the first mesh.
    pub a: u32,
    /// Triangle of the second mesh.
    pub b: u32,
}

impl From<TrianglePair> for pfront_pair_t {
    fn from(TrianglePair { a, b }: TrianglePair) -> Self {
        Self { a, b }
    }
}

const _: () = {
    assert!(size_of::<pfront_pair_t>() == size_of::<TrianglePair>());
    assert!(align_of::<pfront_pair_t>() == align_of::<TrianglePair>());
    assert!(offset_of!(pfront_pair_t, b) == offset_of!(TrianglePair, b));
};

/// Goes on from a cursor and writes up to `capacity` pairs that meet, of which there is at least room for one. Nothing is
/// ever dropped: when `cursor.done` is 1, all pages together are the whole answer. Only the last page may be empty.
///
/// The order is fixed for given BVHs, and otherwise arbitrary: sort the whole by a, then b, for a list that does not
/// depend on how BVHs were built. Takes up to 29 KiB of stack.
#[entry]
fn pfront_query_page(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    cursor: *mut pfront_cursor_t,
    page: *mut pfront_pair_t,
    capacity: usize,
    count: *mut usize,
) -> Done {
    step(call, query, cursor, u64::MAX, (page, capacity, count))
}

/// `pfront_query_page` that also stops after `budget` + 16 box and triangle tests at most, to spread a query over
/// frames. Pages may be empty then; with a budget of 0 nothing is done.
#[entry]
fn pfront_query_step(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    cursor: *mut pfront_cursor_t,
    budget: u64,
    page: *mut pfront_pair_t,
    capacity: usize,
    count: *mut usize,
) -> Done {
    step(call, query, cursor, budget, (page, capacity, count))
}

/// Fills a page, of which C gives the first element, the capacity, and where its count goes.
fn step(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    cursor: *mut pfront_cursor_t,
    budget: u64,
    (page, capacity, count): (*mut pfront_pair_t, usize, *mut usize),
) -> Done {
    let out = call.out(c"count", count)?;
    Fault::room(c"page", capacity, 1)?;
    let page = call.write(c"page", page.cast::<TrianglePair>(), capacity)?;
    let (query, asked, cursor) = on_walk(call, query, cursor)?;
    let mut free = page.iter_mut();
    // Whether it broke or ended, the cursor knows.
    let _ = cursor.go_on(&query, |cursor| {
        asked.step(cursor, budget, |pair| {
            if let Some(slot) = free.next() {
                *slot = pair;
            }
            if free.len() == 0 { Break(()) } else { Continue(()) }
        })
    })?;
    out.set(capacity - free.len());
    Ok(())
}

/// Tells how many pairs meet.
#[entry]
fn pfront_query_count(call: &mut Call<'_>, query: *const pfront_query_t, count: *mut u64) -> Done {
    let (out, query) = (call.out(c"count", count)?, call.get(c"query", query)?);
    out.set(query.asked(call)?.count());
    Ok(())
}

/// Finds some pair that meets, and stops at the first: `found` is 1 if there is one, else 0 and `pair` is not written.
#[entry]
fn pfront_query_any(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    pair: *mut pfront_pair_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"pair", pair)?, call.out(c"found", found)?);
    let some = call.get(c"query", query)?.asked(call)?.any();
    out.set_some(is_found, some.map(pfront_pair_t::from));
    Ok(())
}

/// How two triangles meet.
#[repr(u32)]
#[derive(Clone, Copy)]
pub enum pfront_contact_kind_t {
    /// They do not.
    PFRONT_APART = 0,
    /// Their planes differ: they meet in a segment, or in a point if its ends are equal.
    PFRONT_CROSSING = 1,
    /// They lie in one plane, or one has no area: the segment is the longest chord between corners of the region they
    /// share.
    PFRONT_FLAT = 2,
}

/// Where two triangles meet, and how they face, in the frame of the query.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_contact_t {
    /// A `pfront_contact_kind_t`; if it is PFRONT_APART all else is 0.
    pub kind: u32,
    /// The ends of the segment in which they meet.
    pub segment: [[f32; 3]; 2],
    /// Unit normals of both by the right-hand rule; 0 for a triangle without area.
    pub normals: [[f32; 3]; 2],
}

impl From<Option<Contact>> for pfront_contact_t {
    fn from(contact: Option<Contact>) -> Self {
        use pfront_contact_kind_t::*;
        let Some(Contact { is_flat, segment, normals }) = contact else {
            let nothing = [[0.0; 3]; 2];
            return Self { kind: PFRONT_APART as u32, segment: nothing, normals: nothing };
        };
        let kind = if is_flat { PFRONT_FLAT } else { PFRONT_CROSSING };
        Self { kind: kind as u32, segment, normals }
    }
}

/// Tells where the triangles of each of `count` pairs meet, into as many `contacts`. The pairs need not be of an answer.
#[entry]
fn pfront_query_contacts(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    pairs: *const pfront_pair_t,
    count: usize,
    contacts: *mut pfront_contact_t,
) -> Done {
    let contacts = call.write(c"contacts", contacts, count)?;
    let query = call.get(c"query", query)?;
    let pairs = call.read(c"pairs", pairs.cast::<TrianglePair>(), count)?;
    let asked = query.asked(call)?;
    for (index, pair) in pairs.iter().enumerate() {
        let below = |what, triangle: u32, mesh: &crate::pfront_mesh_t| {
            let checked = Fault::below(what, triangle as usize, mesh.triangle_count);
            checked.map_err(|fault| fault.at(index))
        };
        below(c"pairs.a", pair.a, &query.a.mesh)?;
        below(c"pairs.b", pair.b, &query.b.mesh)?;
    }
    for (&pair, contact) in pairs.iter().zip(contacts) {
        *contact = asked.contact(pair).into();
    }
    Ok(())
}
