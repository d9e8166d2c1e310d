//! BVHs: adopted, refitted, told about.

use crate::memory::{Call, Done};
use crate::mesh::{pfront_aabb_t, pfront_mesh_t};
use crate::pose::pfront_pose_t;
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use core::ffi::{CStr, c_void};
use core::mem::offset_of;
use pfront_capi_entry::entry;
use pfront_core::bvh::{Refit, quality, refit};
use pfront_core::bvtt::PosedBvh;
use pfront_core::{Aabb, Bvh, Node};

/// Rebuild a BVH once the quality that a refit returns is above so many times what it was when built.
pub const PFRONT_REBUILD_RATIO: f32 = 1.2;
const _: () = assert!(PFRONT_REBUILD_RATIO == pfront_core::bvh::REBUILD_RATIO);

/// A node of a BVH.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_node_t {
    /// The smallest corner of its box.
    pub min: [f32; 3],
    /// In a leaf, where its triangles begin in the order; else its left child, next to which is the right one.
    pub first: u32,
    /// The largest corner of its box.
    pub max: [f32; 3],
    /// How many triangles a leaf holds; else 0.
    pub count: u32,
}

const _: () = {
    assert!(size_of::<pfront_node_t>() == size_of::<Node>());
    assert!(align_of::<pfront_node_t>() == align_of::<Node>());
    assert!(offset_of!(pfront_node_t, first) == offset_of!(Node, first));
    assert!(offset_of!(pfront_node_t, max) == offset_of!(Node, max));
    assert!(offset_of!(pfront_node_t, count) == offset_of!(Node, count));
};

/// A mesh and its BVH: arrays of the caller's, which must stay where they are. A copy is another view of the same.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_bvh_t {
    /// For pfront to know that it has made it.
    pub seal: u32,
    /// The mesh.
    pub mesh: pfront_mesh_t,
    /// The nodes: first the root, then an unused one. Read-only if they are in a blob.
    pub nodes: *mut pfront_node_t,
    /// How many nodes are in use: more than that can be given back.
    pub node_count: usize,
    /// The triangles, leaf by leaf; one entry a triangle.
    pub order: *const u32,
}

/// Memory for one build at a time, which need not be initialised; or what is to be adopted.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_bvh_memory_t {
    /// Becomes part of the BVH.
    pub nodes: *mut pfront_node_t,
    /// `pfront_node_bound` nodes always are enough.
    pub node_capacity: usize,
    /// Becomes part of the BVH.
    pub order: *mut u32,
    /// One entry a triangle.
    pub order_capacity: usize,
    /// Free again after the build; of any alignment.
    pub scratch: *mut c_void,
    /// In bytes: `pfront_morton_scratch_bytes` or `pfront_sah_scratch_bytes`.
    pub scratch_bytes: usize,
}

const SEAL: u32 = u32::from_be_bytes(*b"bvh ");
/// The seal of a BVH that must not be written.
const BORROWED: u32 = u32::from_be_bytes(*b"blob");

impl pfront_bvh_t {
    /// A BVH of arrays that are valid.
    pub(crate) fn made(
        mesh: pfront_mesh_t,
        nodes: *mut pfront_node_t,
        node_count: usize,
        order: *const u32,
    ) -> Self {
        Self { seal: SEAL, mesh, nodes, node_count, order }
    }

    /// A BVH of arrays in a blob.
    pub(crate) fn borrowed(
        mesh: pfront_mesh_t,
        nodes: *const pfront_node_t,
        node_count: usize,
        order: *const u32,
    ) -> Self {
        Self { seal: BORROWED, ..Self::made(mesh, nodes.cast_mut(), node_count, order) }
    }

    /// Checks the seal.
    pub(crate) fn sealed(&self, what: &'static CStr) -> Result<&Self, Fault> {
        self.mesh.sealed(what)?;
        let made = matches!(self.seal, SEAL | BORROWED);
        if made { Ok(self) } else { Err(Fault::of(PFRONT_NOT_MADE, what)) }
    }

    /// The BVH, which was good when it was made.
    pub(crate) fn view<'c>(&self, call: &Call<'c>, what: &'static CStr) -> Result<Bvh<'c>, Fault> {
        let mesh = self.sealed(what)?.mesh.view(call, what)?;
        let nodes = call.read(c"nodes", self.nodes.cast_const().cast::<Node>(), self.node_count)?;
        Ok(Bvh::new_unchecked(
            mesh,
            nodes,
            call.read(c"order", self.order, self.mesh.triangle_count)?,
        ))
    }
}

/// Makes a BVH of arrays from elsewhere, as from a file, after checking all that a query relies on. The capacities in
/// `memory` are how many nodes and entries there are. With less scratch than `pfront_adopt_scratch_bytes`, down to 7
/// bytes, the answer is the same and takes more passes over the order. Nothing but scratch is written; nodes and order
/// may lie in read-only memory unless the BVH is refitted.
#[entry]
fn pfront_bvh_adopt(
    call: &mut Call<'_>,
    mesh: *const pfront_mesh_t,
    memory: *const pfront_bvh_memory_t,
    bvh: *mut pfront_bvh_t,
) -> Done {
    let (out, mesh) = (call.out(c"bvh", bvh)?, call.get(c"mesh", mesh)?);
    let memory = call.get(c"memory", memory)?;
    let scratch = call.marks(memory.scratch, memory.scratch_bytes)?;
    let node_count = memory.node_capacity;
    let nodes = call.read(c"nodes", memory.nodes.cast_const().cast::<Node>(), node_count)?;
    let order = call.read(c"order", memory.order.cast_const(), memory.order_capacity)?;
    Bvh::new(mesh.view(call, c"mesh")?, nodes, order, scratch)?;
    let (nodes, order) = (memory.nodes, memory.order);
    out.set(pfront_bvh_t::made(mesh, nodes, node_count, order));
    Ok(())
}

/// Fits a BVH to new positions of its mesh, in O(triangles). Its arrays are written; queries and fronts that hold the
/// BVH are to be made again, and cursors to be started again.
///
/// `positions` take the place of those of the mesh; they may be the same array, changed in place. If one is not finite
/// the boxes stay as they were: then give other positions before the next query. `quality`, which may be null, is told
/// how good the tree still is, see PFRONT_REBUILD_RATIO. A BVH that borrows a blob is refused.
#[entry]
fn pfront_bvh_refit(
    call: &mut Call<'_>,
    bvh: *mut pfront_bvh_t,
    positions: *const f32,
    vertex_count: usize,
    quality: *mut f32,
) -> Done {
    let (out, mut own) = (call.out(c"bvh", bvh)?, call.get(c"bvh", bvh)?);
    let count = own.sealed(c"bvh")?.mesh.vertex_count;
    if own.seal == BORROWED {
        return Err(Fault::of(PFRONT_READ_ONLY, c"bvh"));
    }
    if vertex_count != count {
        let fault = Fault::of(PFRONT_VERTEX_COUNT, c"positions");
        return Err(fault.numbers(count, vertex_count));
    }
    let told = if quality.is_null() { None } else { Some(call.out(c"quality", quality)?) };
    own.mesh.positions = positions;
    let nodes = call.write(c"nodes", own.nodes.cast::<Node>(), own.node_count)?;
    let mesh = own.mesh.moved(call)?;
    let order = call.read(c"order", own.order, own.mesh.triangle_count)?;
    let now = refit(mesh, nodes, order, Refit::default())?;
    out.set(own);
    if let Some(told) = told {
        told.set(now);
    }
    Ok(())
}

/// How many tests a triangle of the mesh is expected to need to find those near it; lower is better. In O(triangles).
#[entry]
fn pfront_bvh_quality(call: &mut Call<'_>, bvh: *const pfront_bvh_t, quality: *mut f32) -> Done {
    let (out, bvh) = (call.out(c"quality", quality)?, call.get(c"bvh", bvh)?);
    out.set(self::quality(&bvh.view(call, c"bvh")?));
    Ok(())
}

/// A box that contains every vertex of every triangle in a pose, rounding included, for a broad phase. The box of an empty
/// mesh reaches from infinity to minus infinity. In O(1).
#[entry]
fn pfront_bvh_bounds(
    call: &mut Call<'_>,
    bvh: *const pfront_bvh_t,
    world_from_bvh: *const pfront_pose_t,
    bounds: *mut pfront_aabb_t,
) -> Done {
    let (out, bvh) = (call.out(c"bounds", bounds)?, call.get(c"bvh", bvh)?);
    let pose = call.get(c"world_from_bvh", world_from_bvh)?.pose();
    let placed = PosedBvh::new(bvh.view(call, c"bvh")?, &pose);
    let placed = placed.map_err(Fault::pose(c"world_from_bvh"))?;
    let Aabb { min, max } = placed.aabb().unwrap_or(Aabb::EMPTY);
    out.set(pfront_aabb_t { min, max });
    Ok(())
}
