//! How far an answer has come.

#![expect(unsafe_code, reason = "C holds a cursor as so many bytes")]

use crate::memory::{Call, Done};
use crate::query::pfront_query_t;
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use core::mem::MaybeUninit;
use pfront_capi_entry::entry;
use pfront_core::bvtt::{AnyBvtt, Cursor, NodePair, Query, Work};

/// A node of a bounding volume test tree: one node of either BVH, or two of one.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_node_pair_t {
    /// Node of the first BVH.
    pub a: u32,
    /// Node of the second.
    pub b: u32,
}

/// Words of 8 bytes for all that a walk remembers.
pub const PFRONT_CURSOR_WORDS: usize = 487;
const _: () = assert!(size_of::<Cursor>() <= PFRONT_CURSOR_WORDS * size_of::<u64>());
const _: () = assert!(align_of::<Cursor>() <= align_of::<u64>());

/// Where a walk stands: what `pfront_query_page` and `pfront_query_step` go on from. A copy is a bookmark. Each thread
/// needs its own.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_cursor_t {
    /// For pfront to know that it has made it.
    pub seal: u32,
    /// 1 when nothing is left, else 0. To be read.
    pub done: u32,
    /// Box tests so far. To be read.
    pub box_tests: u64,
    /// Triangle tests so far. To be read.
    pub triangle_tests: u64,
    /// Private.
    pub node_counts: [u64; 2],
    /// Private.
    pub state: [MaybeUninit<u64>; PFRONT_CURSOR_WORDS],
}

/// The slot of no node.
const UNUSED: u32 = 1;

const SEAL: u32 = u32::from_be_bytes(*b"walk");

impl pfront_cursor_t {
    fn begin(&mut self, query: &pfront_query_t, cursor: Cursor) {
        (self.seal, self.node_counts) = (SEAL, query.node_counts());
        // SAFETY: the state is large enough and aligned, which is asserted above.
        unsafe { self.state.as_mut_ptr().cast::<Cursor>().write(cursor) };
        // This cannot fail: the cursor was sealed just now.
        let _ = self.go_on(query, |_| ());
    }

    /// Goes on with a walk of this query.
    pub(crate) fn go_on<T>(
        &mut self,
        query: &pfront_query_t,
        go: impl FnOnce(&mut Cursor) -> T,
    ) -> Result<T, Fault> {
        if self.seal != SEAL {
            return Err(Fault::of(PFRONT_NOT_MADE, c"cursor"));
        }
        if self.node_counts != query.node_counts() {
            return Err(Fault::of(PFRONT_FOREIGN_CURSOR, c"cursor"));
        }
        // SAFETY: by the seal `begin` has put a cursor there, or C a copy of one; it is large enough and aligned.
        // Should C have made it up: a cursor is nothing but integers.
        let cursor = unsafe { &mut *self.state.as_mut_ptr().cast::<Cursor>() };
        let gone = go(cursor);
        let Work { box_tests, triangle_tests } = cursor.work;
        self.done = cursor.is_done().into();
        (self.box_tests, self.triangle_tests) = (box_tests, triangle_tests);
        Ok(gone)
    }
}

/// The query and the cursor of a call.
pub(crate) fn on_walk<'c>(
    call: &mut Call<'c>,
    query: *const pfront_query_t,
    cursor: *mut pfront_cursor_t,
) -> Result<(pfront_query_t, AnyBvtt<'c>, &'c mut pfront_cursor_t), Fault> {
    let cursor = call.one(c"cursor", cursor)?;
    let query = call.get(c"query", query)?;
    Ok((query, query.asked(call)?, cursor))
}

/// Sets a cursor before the first triangle pair of a query.
#[entry]
fn pfront_cursor_start(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    cursor: *mut pfront_cursor_t,
) -> Done {
    let (query, asked, cursor) = on_walk(call, query, cursor)?;
    cursor.begin(&query, asked.start());
    Ok(())
}

/// Sets a cursor before the first triangle pair below one node of a front: see `pfront_front_divide`.
#[entry]
fn pfront_cursor_at(
    call: &mut Call<'_>,
    query: *const pfront_query_t,
    node: pfront_node_pair_t,
    cursor: *mut pfront_cursor_t,
) -> Done {
    let (query, _, cursor) = on_walk(call, query, cursor)?;
    let pfront_node_pair_t { a, b } = node;
    for (what, index, bvh) in [(c"node.a", a, &query.a), (c"node.b", b, &query.b)] {
        // The unused slot looks like a parent of the root, so that pairs would come more than once.
        let limit = if index == UNUSED { 1 } else { bvh.node_count };
        Fault::below(what, index as usize, limit)?;
    }
    cursor.begin(&query, Cursor::at(NodePair { a, b }));
    Ok(())
}
