//! Two meshes in one call, for who asks once: their BVHs are built on the way, in memory of an allocator.

use crate::allocator::{Block, pfront_allocator_t};
use crate::buffers::{Buffers, Names, pfront_buffers_t};
use crate::memory::{Call, Done};
use crate::pose::pfront_pose_t;
use crate::query::by_rule;
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use crate::verbs::pfront_pair_t;
use bytemuck::{must_cast_slice_mut, pod_align_to_mut};
use core::ops::ControlFlow::{Break, Continue};
use core::ptr::null_mut;
use pfront_capi_entry::entry;
use pfront_core::MAX_TRIANGLES;
use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
use pfront_core::bvtt::{PairBvtt, Query, TrianglePair};
use pfront_core::{Bvh, Node};

/// A list of pairs in memory of an allocator, to be freed by `pfront_pair_list_free`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_pair_list_t {
    /// For pfront to know that it has made it.
    pub seal: u32,
    /// The pairs, sorted by a, then b.
    pub pairs: *mut pfront_pair_t,
    /// How many pairs there are.
    pub count: usize,
    /// Private.
    pub capacity: usize,
    /// Private.
    pub allocator: pfront_allocator_t,
}

const SEAL: u32 = u32::from_be_bytes(*b"list");

/// The names that C has for the members of the buffers of either mesh.
const NAMES: [Names; 2] = [
    Names {
        positions: c"a.positions",
        stride: c"a.stride",
        triangles: c"a.triangles",
        index_type: c"a.index_type",
    },
    Names {
        positions: c"b.positions",
        stride: c"b.stride",
        triangles: c"b.triangles",
        index_type: c"b.index_type",
    },
];

/// How many pairs the first block of a list holds: 4 KiB of them.
const FIRST: usize = 512;

/// Two meshes, as C gives them.
struct Meshes {
    a: *const pfront_buffers_t,
    b: *const pfront_buffers_t,
    a_from_b: *const pfront_pose_t,
    allocator: *const pfront_allocator_t,
}

impl Meshes {
    /// Builds their BVHs and asks about them.
    fn ask<T>(
        &self,
        call: &Call<'_>,
        ask: impl FnOnce(PairBvtt<'_>, pfront_allocator_t) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let allocator = pfront_allocator_t::of(call, self.allocator)?;
        let [names_a, names_b] = const { &NAMES };
        let a = call.get(c"a", self.a)?.checked(names_a)?;
        let b = call.get(c"b", self.b)?.checked(names_b)?;
        let a_from_b = call.get(c"a_from_b", self.a_from_b)?.pose();
        let [room_a, room_b] = [Room::of(&a)?, Room::of(&b)?];
        let scratch_words = room_a.scratch.max(room_b.scratch);
        let mut block = Block::new(allocator, room_a.words() + room_b.words() + scratch_words)?;
        let (scratch, rest) = split(block.words(), scratch_words)?;
        let (words_a, words_b) = split(rest, room_a.words())?;
        let a = room_a.build(&a, call, words_a, scratch)?;
        let b = room_b.build(&b, call, words_b, scratch)?;
        ask(PairBvtt::new(a, b, a_from_b).map_err(Fault::pose(c"a_from_b"))?, allocator)
    }
}

/// How many words of 8 bytes a mesh and its BVH take.
struct Room {
    mesh: usize,
    nodes: usize,
    order: usize,
    scratch: usize,
}

impl Room {
    fn of(buffers: &Buffers) -> Result<Self, Fault> {
        let triangles = buffers.triangle_count();
        let [positions, indices] = buffers.words()?;
        // So that no sum overflows, whatever is asked for.
        let most = MAX_TRIANGLES.min(isize::MAX as usize / 512);
        let fault = Fault::of(PFRONT_TOO_MANY_TRIANGLES, buffers.names().triangles);
        if triangles > most {
            return Err(fault.numbers(most, triangles));
        }
        Ok(Self {
            mesh: (positions + indices).div_ceil(2),
            nodes: node_bound(triangles) * (size_of::<Node>() / size_of::<u64>()),
            order: triangles.div_ceil(2),
            scratch: 2 * triangles,
        })
    }

    /// The words that last as long as the BVH.
    fn words(&self) -> usize {
        self.mesh + self.nodes + self.order
    }

    fn build<'m>(
        &self,
        buffers: &Buffers,
        call: &Call<'m>,
        words: &'m mut [u64],
        scratch: &mut [u64],
    ) -> Result<Bvh<'m>, Fault> {
        let (mesh, rest) = split(words, self.mesh)?;
        let (nodes, order) = split(rest, self.nodes)?;
        let mesh = buffers.mesh(call, must_cast_slice_mut(mesh))?;
        let (_, nodes, _) = pod_align_to_mut(nodes);
        let storage = BvhStorage { nodes, order: must_cast_slice_mut(order) };
        Ok(morton(mesh, &BuildOptions::default(), storage, scratch)?)
    }
}

/// The first words, and the rest.
fn split(words: &mut [u64], count: usize) -> Result<(&mut [u64], &mut [u64]), Fault> {
    words.split_at_mut_checked(count).ok_or(Fault::new(PFRONT_DAMAGED))
}

/// All pairs of a query, sorted, in a block that grows twofold; and their number.
fn list(query: &impl Query, allocator: pfront_allocator_t) -> Result<(Block, usize), Fault> {
    let (mut block, mut count, mut cursor) = (Block::new(allocator, FIRST)?, 0, query.start());
    loop {
        let pairs: &mut [TrianglePair] = must_cast_slice_mut(block.words());
        let capacity = pairs.len();
        let mut free = pairs.iter_mut().skip(count);
        // Whether it broke or ended, the cursor knows.
        let _ = query.visit(&mut cursor, |pair| {
            if let Some(slot) = free.next() {
                *slot = pair;
                count += 1;
            }
            if count == capacity { Break(()) } else { Continue(()) }
        });
        if cursor.is_done() {
            break;
        }
        let mut larger = Block::new(allocator, capacity.saturating_mul(2))?;
        for (to, from) in larger.words().iter_mut().zip(block.words()) {
            *to = *from;
        }
        block = larger;
    }
    let pairs: &mut [TrianglePair] = must_cast_slice_mut(block.words());
    if let Some(found) = pairs.get_mut(..count) {
        found.sort_unstable();
    }
    Ok((block, count))
}

/// Finds all pairs of triangles of `a` and `b` that meet, `b` in the pose `a_from_b`: exactly, and sorted. BVHs are
/// built on the way and dropped; to ask again about the same meshes, keep them: see `pfront_query_pair`.
///
/// `list` need not be initialised; it takes memory of `allocator`, which a null pointer leaves to malloc, unless the
/// library is without the standard library. `pfront_pair_list_free` gives it back. Other memory, about 100 bytes a
/// triangle, is given back at once.
#[entry]
fn pfront_all(
    call: &mut Call<'_>,
    a: *const pfront_buffers_t,
    b: *const pfront_buffers_t,
    a_from_b: *const pfront_pose_t,
    allocator: *const pfront_allocator_t,
    list: *mut pfront_pair_list_t,
) -> Done {
    let out = call.out(c"list", list)?;
    let (found, allocator) = Meshes { a, b, a_from_b, allocator }
        .ask(call, |query, allocator| Ok((self::list(&query, allocator)?, allocator)))?;
    let (block, count) = found;
    let (pairs, capacity) = block.into_raw();
    out.set(pfront_pair_list_t { seal: SEAL, pairs: pairs.cast(), count, capacity, allocator });
    Ok(())
}

/// Finds all pairs of triangles of one mesh that meet, by a `pfront_rule_t`; all else is as for `pfront_all`.
#[entry]
fn pfront_self(
    call: &mut Call<'_>,
    buffers: *const pfront_buffers_t,
    rule: u32,
    allocator: *const pfront_allocator_t,
    list: *mut pfront_pair_list_t,
) -> Done {
    let out = call.out(c"list", list)?;
    let allocator = pfront_allocator_t::of(call, allocator)?;
    let buffers = call.get(c"buffers", buffers)?.checked(&crate::buffers::NAMES)?;
    let room = Room::of(&buffers)?;
    let mut block = Block::new(allocator, room.words() + room.scratch)?;
    let (scratch, words) = split(block.words(), room.scratch)?;
    let query = by_rule(room.build(&buffers, call, words, scratch)?, rule)?;
    let (pairs, count) = self::list(&query, allocator)?;
    drop(block);
    let (pairs, capacity) = pairs.into_raw();
    out.set(pfront_pair_list_t { seal: SEAL, pairs: pairs.cast(), count, capacity, allocator });
    Ok(())
}

/// Finds some pair of triangles of `a` and `b` that meet, and stops at the first: `found` is 1 if there is one, else 0
/// and `pair` is not written. All else is as for `pfront_all`; there is nothing to free.
#[entry]
fn pfront_any(
    call: &mut Call<'_>,
    a: *const pfront_buffers_t,
    b: *const pfront_buffers_t,
    a_from_b: *const pfront_pose_t,
    allocator: *const pfront_allocator_t,
    pair: *mut pfront_pair_t,
    found: *mut u32,
) -> Done {
    let (out, is_found) = (call.out(c"pair", pair)?, call.out(c"found", found)?);
    let meshes = Meshes { a, b, a_from_b, allocator };
    let some = meshes.ask(call, |query, _| Ok(query.any()))?;
    out.set_some(is_found, some.map(pfront_pair_t::from));
    Ok(())
}

/// Gives the memory of a list back to its allocator. The list is not one any more afterwards, and PFRONT_NOT_MADE if it
/// is freed again.
#[entry]
fn pfront_pair_list_free(call: &mut Call<'_>, list: *mut pfront_pair_list_t) -> Done {
    let list = call.one(c"list", list)?;
    if list.seal != SEAL {
        return Err(Fault::of(PFRONT_NOT_MADE, c"list"));
    }
    let (first, capacity, allocator) = (list.pairs.cast(), list.capacity, list.allocator);
    (list.seal, list.pairs, list.count, list.capacity) = (0, null_mut(), 0, 0);
    #[expect(unsafe_code, reason = "C gives back what a list holds")]
    // SAFETY: by the seal `pfront_all` has made it, and nobody has freed it.
    drop(unsafe { Block::from_raw(first, capacity, allocator) });
    Ok(())
}
