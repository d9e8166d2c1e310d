//! Frames divided among the caller's own threads.

use crate::cursor::pfront_node_pair_t;
use crate::memory::{Call, Done};
use crate::query::pfront_query_t;
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use core::cell::Cell;
use core::mem::offset_of;
use pfront_capi_entry::entry;
use pfront_core::bvtt::{AnyBvtt, Query, SelfBvtt, Work};
use pfront_core::front::{Front, FrontNode, Part, RefineOptions};
use pfront_core::{Bvh, Mesh};

/// The cost of a triangle test, in box tests, as measured on x86-64.
pub const PFRONT_TRIANGLE_COST: f32 = 6.5;

/// A node of a front: a part of a query that one worker answers.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_front_node_t {
    /// Where its worker begins: for `pfront_cursor_at`.
    pub pair: pfront_node_pair_t,
    /// Private.
    pub path: [u64; 2],
    /// Its expected cost. The worker puts its true cost in the same place:
    /// `1 + box_tests + PFRONT_TRIANGLE_COST * triangle_tests` of the cursor, so that it is above 0.
    pub cost: f32,
    /// The query it belongs to.
    pub query: u32,
    /// The worker it is assigned to.
    pub part: u32,
    /// Private.
    pub history: u32,
}

/// The part of a front that one worker gets.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_part_t {
    /// Its expected cost in all.
    pub cost: f64,
    /// The worker, from 0.
    pub number: u32,
}

const _: () = {
    assert!(PFRONT_TRIANGLE_COST as f64 == Work::TRIANGLE_COST);
    assert!(size_of::<pfront_front_node_t>() == size_of::<FrontNode>());
    assert!(align_of::<pfront_front_node_t>() == align_of::<FrontNode>());
    assert!(offset_of!(pfront_front_node_t, cost) == offset_of!(FrontNode, cost));
    assert!(offset_of!(pfront_front_node_t, query) == offset_of!(FrontNode, query));
    assert!(offset_of!(pfront_front_node_t, part) == offset_of!(FrontNode, part));
    assert!(size_of::<pfront_part_t>() == size_of::<Part>());
    assert!(align_of::<pfront_part_t>() == align_of::<Part>());
    assert!(offset_of!(pfront_part_t, number) == offset_of!(Part, number));
};

/// The front of a frame and what is remembered of the last one: how the queries of a frame are divided among workers.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_front_t {
    /// For pfront to know that it has made it.
    pub seal: u32,
    /// No node that can be split costs more than 1/g of what a worker gets, where the last frame told what it cost; 8 by
    /// default. May be changed.
    pub g: f64,
    /// The same where costs are estimates; 48 by default. May be changed.
    pub g_estimated: f64,
    /// The front.
    pub nodes: *mut pfront_front_node_t,
    /// A front that is full is coarser, but nothing is lost. It needs at least one node a query; some 150 a worker are
    /// plenty.
    pub node_capacity: usize,
    /// How many nodes there are. To be read.
    pub node_count: usize,
    /// The cost history: the nodes of the last front, with what they cost; may be null.
    pub history: *mut pfront_front_node_t,
    /// As many as there are nodes; 0 to forget each frame.
    pub history_capacity: usize,
    /// How many are in use; set it to 0 to forget the last frame.
    pub history_count: usize,
    /// 1 if some node is coarser than was asked for. To be read.
    pub full: u32,
    /// 1 if what was remembered was of use. To be read.
    pub coherent: u32,
    /// Box tests that the front took. To be read.
    pub box_tests: u64,
}

const SEAL: u32 = u32::from_be_bytes(*b"cut ");

impl pfront_front_t {
    fn sealed(self) -> Result<Self, Fault> {
        if self.seal == SEAL { Ok(self) } else { Err(Fault::of(PFRONT_NOT_MADE, c"front")) }
    }

    /// The cost history that is in use.
    fn history<'c>(&self, call: &mut Call<'c>) -> Result<&'c mut [FrontNode], Fault> {
        Fault::room(c"history", self.history_capacity, self.history_count)?;
        call.write(c"history", self.history.cast::<FrontNode>(), self.history_count)
    }

    /// Divides queries among workers.
    fn divide(
        &mut self,
        queries: &Queries<'_, '_>,
        history: &mut [FrontNode],
        nodes: &mut [FrontNode],
        parts: &mut [Part],
    ) -> Done {
        let mut front = Front::new(nodes);
        for (query, number) in queries.queries.iter().zip(0..) {
            if let Some(root) = query.asked(queries.call)?.root() {
                front.add(number, root)?;
            }
        }
        let options =
            RefineOptions { workers: parts.len(), g: self.g, g_estimated: self.g_estimated };
        let refined = front.refine(&options, history, |number| queries.again(number));
        self.node_count = front.partition(parts).len();
        (self.full, self.coherent) = (refined.full.into(), refined.coherent.into());
        self.box_tests = refined.box_tests;
        Ok(())
    }
}

/// The queries of a frame.
struct Queries<'q, 'c> {
    queries: &'q [pfront_query_t],
    call: &'q Call<'c>,
}

impl<'c> Queries<'_, 'c> {
    /// A query that could be asked before.
    fn again(&self, number: u32) -> AnyBvtt<'c> {
        let query = self.queries.get(number as usize);
        query.and_then(|query| query.asked(self.call).ok()).unwrap_or_else(|| {
            // Nothing, since it cannot fail.
            AnyBvtt::Itself(SelfBvtt::new(Bvh::new_unchecked(
                Mesh::new_unchecked(&[], &[]),
                &[],
                &[],
            )))
        })
    }
}

/// Makes a front in the caller's memory, with nothing remembered, which need not be initialised. `history` may be null
/// if `history_capacity` is 0.
#[entry]
fn pfront_front_init(
    call: &mut Call<'_>,
    front: *mut pfront_front_t,
    nodes: *mut pfront_front_node_t,
    node_capacity: usize,
    history: *mut pfront_front_node_t,
    history_capacity: usize,
) -> Done {
    let out = call.out(c"front", front)?;
    call.write(c"nodes", nodes.cast::<FrontNode>(), node_capacity)?;
    call.write(c"history", history.cast::<FrontNode>(), history_capacity)?;
    let RefineOptions { g, g_estimated, .. } = RefineOptions::new(1);
    out.set(pfront_front_t {
        seal: SEAL,
        g,
        g_estimated,
        nodes,
        node_capacity,
        node_count: 0,
        history,
        history_capacity,
        history_count: 0,
        full: 0,
        coherent: 0,
        box_tests: 0,
    });
    Ok(())
}

/// Divides the queries of a frame into nodes of about equal cost, and assigns these to `workers`, of which there is at
/// least one: the p-partition front of Zhang and Kim (2014). `parts` has one element a worker and tells in the end what
/// each is predicted to cost. `history` is sorted.
///
/// Then each worker, on a thread of its own, goes through the nodes whose `part` is its number: it sets its own cursor to
/// the node by `pfront_cursor_at`, asks page by page until that is done, and writes what this cost to the node. All
/// pages together are the answer; which pairs come from which node is the same for any number of threads.
#[entry]
fn pfront_front_divide(
    call: &mut Call<'_>,
    front: *mut pfront_front_t,
    queries: *const pfront_query_t,
    query_count: usize,
    parts: *mut pfront_part_t,
    workers: usize,
) -> Done {
    let (out, mut own) = (call.out(c"front", front)?, call.get(c"front", front)?.sealed()?);
    Fault::room(c"parts", workers, 1)?;
    Fault::room(c"nodes", own.node_capacity, query_count)?;
    let parts = call.write(c"parts", parts.cast::<Part>(), workers)?;
    let nodes = call.write(c"nodes", own.nodes.cast::<FrontNode>(), own.node_capacity)?;
    let queries = call.read(c"queries", queries, query_count)?;
    let history = own.history(call)?;
    own.divide(&Queries { queries, call }, history, nodes, parts)?;
    out.set(own);
    Ok(())
}

/// Remembers what the nodes of a front have cost, for the next `pfront_front_divide`: after all workers are done.
#[entry]
fn pfront_front_remember(call: &mut Call<'_>, front: *mut pfront_front_t) -> Done {
    let (out, mut own) = (call.out(c"front", front)?, call.get(c"front", front)?.sealed()?);
    own.history_count = own.node_count;
    let history = own.history(call)?;
    let nodes = own.nodes.cast_const().cast::<FrontNode>();
    let nodes = call.read(c"nodes", nodes, own.node_count)?;
    let wrong = |node: &FrontNode| !(0.0..=f32::MAX).contains(&node.cost);
    if let Some(index) = nodes.iter().position(wrong) {
        return Err(Fault::of(PFRONT_OUT_OF_RANGE, c"nodes.cost").at(index));
    }
    // As many of both; a loop, since copying slices checks that with a panic.
    for (remembered, node) in history.iter_mut().zip(nodes) {
        *remembered = *node;
    }
    out.set(own);
    Ok(())
}

/// Tells a front that the next frame asks other queries than the last: the one with number `i` gets `numbers[i]`, or is
/// gone if that is UINT32_MAX or `i` is not below `count`. No two get the same. Without this, keep all numbers, or set
/// `history_count` to 0.
#[entry]
fn pfront_front_renumber(
    call: &mut Call<'_>,
    front: *mut pfront_front_t,
    numbers: *const u32,
    count: usize,
) -> Done {
    let (out, mut own) = (call.out(c"front", front)?, call.get(c"front", front)?.sealed()?);
    let history = own.history(call)?;
    let numbers = call.read(c"numbers", numbers, count)?;
    own.history_count = 0;
    // Nodes move to the front of the array as they are met, never past the one that is read.
    let history = Cell::from_mut(history).as_slice_of_cells();
    let mut kept = history.iter();
    for node in history {
        let mut node = node.get();
        if let Some(&query) = numbers.get(node.query as usize)
            && query != u32::MAX
            && let Some(slot) = kept.next()
        {
            node.query = query;
            slot.set(node);
            own.history_count += 1;
        }
    }
    out.set(own);
    Ok(())
}
