//! Frames dealt out to the caller's own threads.

#![expect(
    unsafe_code,
    reason = "C finds functions by name, and keeps to the contract of the header"
)]
#![expect(
    clippy::missing_safety_doc,
    reason = "the header has the contract, once for all functions"
)]

use crate::cursor::pfront_node_pair_t;
use crate::memory::{Call, Caller};
use crate::query::{Asked, pfront_query_t};
use crate::status::pfront_status_t::{self, *};
use crate::status::{Fault, pfront_error_t};
use core::mem::offset_of;
use pfront_core::front::{COHERENT, Estimate, Front, FrontNode, Grain, Past, PastCost};
use pfront_core::front::{Load, greedy};

/// What a triangle test costs, in box tests, as measured on x86-64.
pub const PFRONT_TRIANGLE_COST: f32 = 6.5;

/// A node of a front: a part of a query that one worker answers.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_front_node_t {
    /// Where its worker begins: for `pfront_cursor_at`.
    pub pair: pfront_node_pair_t,
    /// Private.
    pub path: u64,
    /// What it is expected to cost. The worker puts in its place what it did cost:
    /// `box_tests + PFRONT_TRIANGLE_COST * triangle_tests` of the cursor.
    pub cost: f32,
    /// The query it belongs to.
    pub query: u32,
    /// The worker it is dealt to.
    pub part: u32,
    /// Private.
    pub index: u32,
}

/// What one node of a front cost in the last frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_past_t {
    /// Private.
    pub words: [u64; 2],
}

/// What one worker was dealt.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_load_t {
    /// What it is expected to cost in all.
    pub cost: f64,
    /// The worker, from 0.
    pub part: u32,
}

const _: () = {
    assert!(size_of::<pfront_front_node_t>() == size_of::<FrontNode>());
    assert!(align_of::<pfront_front_node_t>() == align_of::<FrontNode>());
    assert!(offset_of!(pfront_front_node_t, path) == offset_of!(FrontNode, path));
    assert!(offset_of!(pfront_front_node_t, cost) == offset_of!(FrontNode, cost));
    assert!(offset_of!(pfront_front_node_t, query) == offset_of!(FrontNode, query));
    assert!(offset_of!(pfront_front_node_t, part) == offset_of!(FrontNode, part));
    assert!(offset_of!(pfront_front_node_t, index) == offset_of!(FrontNode, index));
    assert!(size_of::<pfront_past_t>() == size_of::<PastCost>());
    assert!(align_of::<pfront_past_t>() == align_of::<PastCost>());
    assert!(size_of::<pfront_load_t>() == size_of::<Load>());
    assert!(align_of::<pfront_load_t>() == align_of::<Load>());
    assert!(offset_of!(pfront_load_t, part) == offset_of!(Load, part));
};

/// The front of a frame and what is remembered of the last one: how the queries of a frame are divided among workers.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_front_t {
    /// For pfront to know that it has made it.
    pub seal: u32,
    /// How deep in the tree of a query its nodes begin, which is refined from there; 3 by default. May be changed.
    pub depth: u32,
    /// How many nodes a worker gets at least where the last frame told what they cost; 8 by default. May be changed.
    pub grain_measured: f64,
    /// The same where costs are estimates; 48 by default. May be changed.
    pub grain_estimated: f64,
    /// The front.
    pub nodes: *mut pfront_front_node_t,
    /// A front that is full is coarser, but nothing is lost. It needs at least one node a query; some 150 a worker are
    /// plenty.
    pub node_capacity: usize,
    /// How many nodes there are. To be read.
    pub node_count: usize,
    /// What is remembered; may be null.
    pub past: *mut pfront_past_t,
    /// As many as there are nodes; 0 to forget each frame.
    pub past_capacity: usize,
    /// How many are in use; set it to 0 to forget the last frame.
    pub past_count: usize,
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

    /// What is remembered.
    fn past<'c>(&self, call: &Call<'c>) -> Result<Past<'c>, Fault> {
        Fault::room(c"past", self.past_capacity, self.past_count)?;
        let past = self.past.cast_const().cast::<PastCost>();
        Ok(Past::new(call.read(c"past", past, self.past_count)?))
    }

    /// Divides queries among workers.
    fn divide(
        &mut self,
        queries: &Queries<'_, '_>,
        past: Past<'_>,
        nodes: &mut [FrontNode],
        loads: &mut [Load],
    ) -> Result<(), Fault> {
        let Self { grain_measured: measured, grain_estimated: estimated, .. } = *self;
        // One worker needs no front: the roots will do.
        let depth = if loads.len() == 1 { 0 } else { self.depth };
        let (estimate, mut past) = (Estimate::default(), past);
        let coherent = queries.start(nodes, depth, past)?.found(past) >= COHERENT;
        if !coherent {
            past = Past::NOTHING;
        }
        let mut front = queries.start(nodes, depth, past)?;
        if loads.len() > 1 {
            let grain = Grain { measured, estimated };
            front.refine(loads.len(), grain, estimate, past, |number| queries.again(number));
        }
        greedy(front.nodes_mut(), loads);
        (self.node_count, self.box_tests) = (front.nodes().len(), front.box_tests());
        (self.full, self.coherent) = (front.is_full().into(), coherent.into());
        Ok(())
    }
}

/// The queries of a frame, all of which can be asked.
struct Queries<'q, 'c> {
    queries: &'q [pfront_query_t],
    call: &'q Call<'c>,
}

impl<'c> Queries<'_, 'c> {
    /// The starting front of all.
    fn start<'n>(
        &self,
        nodes: &'n mut [FrontNode],
        depth: u32,
        past: Past<'_>,
    ) -> Result<Front<'n>, Fault> {
        let mut front = Front::new(nodes);
        for (query, number) in self.queries.iter().zip(0..) {
            front.keep_free(self.queries.len() - 1 - number as usize);
            let asked = query.asked(self.call)?;
            front.start(&asked, number, depth, Estimate::default(), past)?;
        }
        Ok(front)
    }

    /// A query that could be asked before.
    fn again(&self, number: u32) -> Asked<'c> {
        let query = self.queries.get(number as usize);
        query.and_then(|query| query.asked(self.call).ok()).unwrap_or_else(Asked::nothing)
    }
}

/// Makes a front in the caller's memory, with nothing remembered, which need not be initialised. `past` may be null if
/// `past_capacity` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_front_init(
    front: *mut pfront_front_t,
    nodes: *mut pfront_front_node_t,
    node_capacity: usize,
    past: *mut pfront_past_t,
    past_capacity: usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let out = call.out(c"front", front)?;
        call.write(c"nodes", nodes.cast::<FrontNode>(), node_capacity)?;
        call.write(c"past", past.cast::<PastCost>(), past_capacity)?;
        let grain = Grain::default();
        out.set(pfront_front_t {
            seal: SEAL,
            depth: 3,
            grain_measured: grain.measured,
            grain_estimated: grain.estimated,
            nodes,
            node_capacity,
            node_count: 0,
            past,
            past_capacity,
            past_count: 0,
            full: 0,
            coherent: 0,
            box_tests: 0,
        });
        Ok(())
    })
}

/// Divides the queries of a frame into nodes of about equal cost, and deals these out to `workers`, of whom there is at
/// least one: the p-partition front of Zhang and Kim (2014). `loads` has one element a worker and tells in the end what
/// each is expected to do, in no particular order.
///
/// Then each worker, on a thread of its own, goes through the nodes whose `part` is its number: it sets its own cursor to
/// the node by `pfront_cursor_at`, asks page by page until that is done, and writes what this cost to the node. All
/// pages together are the answer; which pairs come from which node is the same for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_front_divide(
    front: *mut pfront_front_t,
    queries: *const pfront_query_t,
    query_count: usize,
    loads: *mut pfront_load_t,
    workers: usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, mut own) = (call.out(c"front", front)?, call.get(c"front", front)?.sealed()?);
        Fault::room(c"loads", workers, 1)?;
        Fault::room(c"nodes", own.node_capacity, query_count)?;
        let loads = call.write(c"loads", loads.cast::<Load>(), workers)?;
        let nodes = call.write(c"nodes", own.nodes.cast::<FrontNode>(), own.node_capacity)?;
        let queries = call.read(c"queries", queries, query_count)?;
        let past = own.past(call)?;
        own.divide(&Queries { queries, call }, past, nodes, loads)?;
        out.set(own);
        Ok(())
    })
}

/// Remembers what the nodes of a front have cost, for the next `pfront_front_divide`: after all workers are done.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_front_remember(
    front: *mut pfront_front_t,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, mut own) = (call.out(c"front", front)?, call.get(c"front", front)?.sealed()?);
        let past = call.write(c"past", own.past.cast::<PastCost>(), own.past_capacity)?;
        let nodes = own.nodes.cast_const().cast::<FrontNode>();
        let nodes = call.read(c"nodes", nodes, own.node_count)?;
        let wrong = |node: &FrontNode| !(0.0..=f32::MAX).contains(&node.cost);
        if let Some(index) = nodes.iter().position(wrong) {
            return Err(Fault::of(PFRONT_OUT_OF_RANGE, c"nodes.cost").at(index));
        }
        Past::record(past, nodes, |node| node.cost)?;
        own.past_count = nodes.len();
        out.set(own);
        Ok(())
    })
}

/// Tells a front that the next frame asks other queries than the last: the one with number `i` gets `numbers[i]`, or is
/// gone if that is UINT32_MAX or `i` is not below `count`. No two get the same. Without this, change no numbers, or set
/// `past_count` to 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pfront_front_renumber(
    front: *mut pfront_front_t,
    numbers: *const u32,
    count: usize,
    error: *mut pfront_error_t,
) -> pfront_status_t {
    // SAFETY: the contract of the header.
    unsafe { Caller::trusted() }.call(error, |call| {
        let (out, mut own) = (call.out(c"front", front)?, call.get(c"front", front)?.sealed()?);
        Fault::room(c"past", own.past_capacity, own.past_count)?;
        let past = call.write(c"past", own.past.cast::<PastCost>(), own.past_count)?;
        let numbers = call.read(c"numbers", numbers, count)?;
        own.past_count = Past::renumber(past, |old| {
            numbers.get(old as usize).copied().filter(|&new| new != u32::MAX)
        });
        out.set(own);
        Ok(())
    })
}
