//! Queries: two meshes or one, and which pairs count.

use crate::bvh::pfront_bvh_t;
use crate::memory::{Call, Done};
use crate::one_ring::pfront_history_bound;
use crate::pose::pfront_pose_t;
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use core::ffi::CStr;
use core::ptr::null;
use pfront_capi_entry::entry;
use pfront_core::Bvh;
use pfront_core::bvtt::{AnyBvtt, PairBvtt, PosedBvh, SelfBvtt};
use pfront_core::one_ring::{Certified, OneRings};
use pfront_core::triangle::Adjacency;

/// The rule by which pairs of triangles of one mesh count.
#[repr(u32)]
#[derive(Clone, Copy)]
pub enum pfront_rule_t {
    /// All that have more in common than what they share by index: neighbours count when they fold over.
    PFRONT_SHARED_INDEX = 0,
    /// Only those without a common vertex index.
    PFRONT_SKIP_NEIGHBOURS = 1,
    /// All whose boxes overlap. With each box of a set given as a triangle through two opposite corners, this is the
    /// broad phase of the set.
    PFRONT_BOXES_ONLY = 2,
}

/// A question about two BVHs, or about one. It holds copies of `pfront_bvh_t`, so make it again after a refit or a
/// build, and for each pose. Any number of threads may use it at once.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_query_t {
    /// For pfront to know that it has made it, and what of.
    pub seal: u32,
    /// A `pfront_rule_t`, for one BVH; may be changed.
    pub rule: u32,
    /// The first BVH.
    pub a: pfront_bvh_t,
    /// The second BVH; if there is only one, the same.
    pub b: pfront_bvh_t,
    /// Where a stands.
    pub frame_from_a: pfront_pose_t,
    /// Where b stands.
    pub frame_from_b: pfront_pose_t,
    /// The certified history of one-rings, for one BVH; or null.
    pub history: *const u32,
}

const PAIR: u32 = u32::from_be_bytes(*b"pair");
const SELF: u32 = u32::from_be_bytes(*b"self");

impl pfront_query_t {
    /// The query of `pfront_core` that this one stands for.
    pub(crate) fn asked<'c>(&self, call: &Call<'c>) -> Result<AnyBvtt<'c>, Fault> {
        match self.seal {
            PAIR => {
                let (a, b) = (self.a.view(call, c"a")?, self.b.view(call, c"b")?);
                let a = PosedBvh::new_unchecked(a, &self.frame_from_a.pose());
                let b = PosedBvh::new_unchecked(b, &self.frame_from_b.pose());
                Ok(AnyBvtt::Pair(PairBvtt::in_world(a, b)))
            }
            SELF => Ok(AnyBvtt::Itself(self.within(self.a.view(call, c"bvh")?, call)?)),
            _ => Err(Fault::of(PFRONT_NOT_MADE, c"query")),
        }
    }

    /// How many nodes there are on either side, by which a cursor knows a query.
    pub(crate) fn node_counts(&self) -> [u64; 2] {
        [self.a.node_count as u64, self.b.node_count as u64]
    }

    fn within<'c>(&self, bvh: Bvh<'c>, call: &Call<'c>) -> Result<SelfBvtt<'c>, Fault> {
        let query = by_rule(bvh, self.rule)?;
        if self.history.is_null() {
            return Ok(query);
        }
        let history = call.read(c"history", self.history, self.a.mesh.vertex_count)?;
        Ok(query.with_certificates(Certified::new_unchecked(bvh.mesh(), history)))
    }
}

/// The query about one BVH by a `pfront_rule_t`.
pub(crate) fn by_rule(bvh: Bvh<'_>, rule: u32) -> Result<SelfBvtt<'_>, Fault> {
    let query = SelfBvtt::new(bvh);
    Ok(match rule {
        0 => query,
        1 => query.with_adjacency(Adjacency::SkipNeighbours),
        2 => query.boxes_only(),
        other => return Err(out_of_range(c"rule", other)),
    })
}

fn out_of_range(what: &'static CStr, given: u32) -> Fault {
    Fault::of(PFRONT_OUT_OF_RANGE, what).numbers(3, given as usize)
}

/// A BVH and its pose, as C gives them, and what it calls both.
struct Side {
    bvh: *const pfront_bvh_t,
    pose: *const pfront_pose_t,
    names: [&'static CStr; 2],
}

impl Side {
    /// Copies of both, which go together.
    fn placed(&self, call: &Call<'_>) -> Result<(pfront_bvh_t, pfront_pose_t), Fault> {
        let Self { names: [bvh_name, pose_name], .. } = *self;
        let (bvh, pose) = (call.get(bvh_name, self.bvh)?, call.get(pose_name, self.pose)?);
        let placed = PosedBvh::new(bvh.view(call, bvh_name)?, &pose.pose());
        placed.map_err(Fault::pose(pose_name))?;
        Ok((bvh, pose))
    }

    /// The query of two of them.
    fn ask([a, b]: [Self; 2], query: *mut pfront_query_t, call: &mut Call<'_>) -> Done {
        let out = call.out(c"query", query)?;
        let ((a, frame_from_a), (b, frame_from_b)) = (a.placed(call)?, b.placed(call)?);
        let rule = pfront_rule_t::PFRONT_SHARED_INDEX as u32;
        let history = null();
        let query = pfront_query_t { seal: PAIR, rule, a, b, frame_from_a, frame_from_b, history };
        query.asked(call)?;
        out.set(query);
        Ok(())
    }
}

/// Asks which triangles of `a` meet which of `b`, posed by `a_from_b`. The frame is that of a, and so are contacts.
#[entry]
fn pfront_query_pair(
    call: &mut Call<'_>,
    a: *const pfront_bvh_t,
    b: *const pfront_bvh_t,
    a_from_b: *const pfront_pose_t,
    query: *mut pfront_query_t,
) -> Done {
    let a = Side { bvh: a, pose: &pfront_pose_t::IDENTITY, names: [c"a"; 2] };
    let b = Side { bvh: b, pose: a_from_b, names: [c"b", c"a_from_b"] };
    Side::ask([a, b], query, call)
}

/// Asks which triangles of `a` meet which of `b`, both posed into a third frame. The choice of a frame changes how
/// vertices are rounded, and so what is found.
#[entry]
fn pfront_query_world(
    call: &mut Call<'_>,
    a: *const pfront_bvh_t,
    world_from_a: *const pfront_pose_t,
    b: *const pfront_bvh_t,
    world_from_b: *const pfront_pose_t,
    query: *mut pfront_query_t,
) -> Done {
    let a = Side { bvh: a, pose: world_from_a, names: [c"a", c"world_from_a"] };
    let b = Side { bvh: b, pose: world_from_b, names: [c"b", c"world_from_b"] };
    Side::ask([a, b], query, call)
}

/// Asks which triangles of one mesh meet each other, each unordered pair once. `history`, which may be null, is that of
/// `pfront_one_rings_link` for the same triangles, with `PFRONT_HISTORY_BOUND` words. It changes no answer but makes most
/// neighbours cheap: it is certified for the positions of the mesh here, in O(vertices + triangles), and must last as
/// long as the query. `rule` is a `pfront_rule_t`.
#[entry]
fn pfront_query_self(
    call: &mut Call<'_>,
    bvh: *const pfront_bvh_t,
    history: *mut u32,
    rule: u32,
    query: *mut pfront_query_t,
) -> Done {
    let (out, bvh) = (call.out(c"query", query)?, call.get(c"bvh", bvh)?);
    let (frame_from_a, frame_from_b) = (pfront_pose_t::IDENTITY, pfront_pose_t::IDENTITY);
    let words = match history.is_null() {
        true => 0,
        false => pfront_history_bound(bvh.mesh.vertex_count, bvh.mesh.triangle_count),
    };
    let words = call.write(c"history", history, words)?;
    let mut query = pfront_query_t {
        seal: SELF,
        rule,
        a: bvh,
        b: bvh,
        frame_from_a,
        frame_from_b,
        history: null(),
    };
    query.asked(call)?;
    if !words.is_empty() {
        let mesh = bvh.view(call, c"bvh")?.mesh();
        let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles());
        let mut rings = OneRings::new_unchecked(vertices, triangles, words);
        rings.certify(mesh, None);
        query.history = history;
    }
    out.set(query);
    Ok(())
}
