//! Building BVHs, and how much memory that takes.

use crate::bvh::{pfront_bvh_memory_t, pfront_bvh_t};
use crate::memory::{Call, Done};
use crate::mesh::pfront_mesh_t;
use crate::status::Fault;
use pfront_capi_entry::entry;
use pfront_core::MAX_TRIANGLES;
use pfront_core::bvh::node_bound;
use pfront_core::bvh::{BuildOptions, BvhStorage, morton, sah};
use pfront_core::{Bvh, CapacityError, Mesh, Node};

/// Bytes for `count` elements at any address, if there can be so many.
const fn bytes<T>(count: usize) -> usize {
    let Some(bytes) = count.checked_mul(size_of::<T>()) else { return usize::MAX };
    let Some(bytes) = bytes.checked_add(align_of::<T>() - 1) else { return usize::MAX };
    bytes
}

/// `bound`, if a mesh can have so many triangles.
fn bounded(triangle_count: usize, bound: impl Fn(usize) -> usize) -> usize {
    let most = MAX_TRIANGLES.min(usize::MAX / 4);
    if triangle_count <= most { bound(triangle_count) } else { usize::MAX }
}

/// How many nodes are enough for a BVH of so many triangles; SIZE_MAX if no mesh has so many. With leaves of 8
/// triangles most take a fifth of it.
#[entry]
fn pfront_node_bound(triangle_count: usize) -> usize {
    bounded(triangle_count, node_bound)
}

/// How much scratch `pfront_bvh_build_morton` needs for so many triangles; SIZE_MAX if that cannot be.
#[entry]
fn pfront_morton_scratch_bytes(triangle_count: usize) -> usize {
    bounded(triangle_count, |count| bytes::<u64>(2 * count))
}

/// How much scratch `pfront_bvh_build_sah` needs for so many triangles; SIZE_MAX if that cannot be.
#[entry]
fn pfront_sah_scratch_bytes(triangle_count: usize) -> usize {
    bounded(triangle_count, bytes::<Node>)
}

/// How much scratch `pfront_bvh_adopt` and `pfront_bvh_from_blob` need for so many triangles to take one pass over the
/// order, and 7 bytes at least; SIZE_MAX if that cannot be.
#[entry]
fn pfront_adopt_scratch_bytes(triangle_count: usize) -> usize {
    bounded(triangle_count, |count| bytes::<u32>(count.div_ceil(32).max(1)))
}

/// The arguments of a build.
struct Build {
    mesh: *const pfront_mesh_t,
    leaf_size: u32,
    memory: *const pfront_bvh_memory_t,
    bvh: *mut pfront_bvh_t,
}

type Method<S> = for<'a> fn(
    Mesh<'a>,
    &BuildOptions<'_>,
    BvhStorage<'a>,
    &mut [S],
) -> Result<Bvh<'a>, CapacityError>;

impl Build {
    /// Builds with so much scratch of elements `S`.
    fn by<S: bytemuck::Pod>(
        self,
        call: &mut Call<'_>,
        method: Method<S>,
        scratch_bytes: usize,
    ) -> Done {
        let (out, mesh) = (call.out(c"bvh", self.bvh)?, call.get(c"mesh", self.mesh)?);
        let memory = call.get(c"memory", self.memory)?;
        let most = pfront_core::bvh::MAX_LEAF_SIZE;
        Fault::below(c"leaf_size", self.leaf_size as usize, most as usize + 1)?;
        Fault::room(c"order", memory.order_capacity, mesh.sealed(c"mesh")?.triangle_count)?;
        Fault::room(c"scratch", memory.scratch_bytes, scratch_bytes)?;
        let nodes = call.write(c"nodes", memory.nodes.cast::<Node>(), memory.node_capacity)?;
        let order = call.write(c"order", memory.order, mesh.triangle_count)?;
        let scratch = call.write(c"scratch", memory.scratch.cast::<u8>(), memory.scratch_bytes)?;
        let (_, scratch, _) = bytemuck::pod_align_to_mut::<u8, S>(scratch);
        let leaf_size = if self.leaf_size == 0 { most } else { self.leaf_size };
        let storage = BvhStorage { nodes, order };
        let checked = mesh.view(call, c"mesh")?;
        let node_count = method(
            checked,
            &BuildOptions { leaf_size, ..BuildOptions::default() },
            storage,
            scratch,
        )?
        .nodes()
        .len();
        let (nodes, order) = (memory.nodes, memory.order);
        out.set(pfront_bvh_t::made(mesh, nodes, node_count, order));
        Ok(())
    }
}

/// Builds a BVH along a Morton curve, in O(n) and several times faster than `pfront_bvh_build_sah`, for those who
/// rebuild every frame. `leaf_size` is the most triangles that a leaf may hold, 1 to 8, or 0 for the default.
///
/// Fewer nodes than `pfront_node_bound` do if the tree has no more; PFRONT_TOO_SMALL then tells how many it has.
#[entry]
fn pfront_bvh_build_morton(
    call: &mut Call<'_>,
    mesh: *const pfront_mesh_t,
    leaf_size: u32,
    memory: *const pfront_bvh_memory_t,
    bvh: *mut pfront_bvh_t,
) -> Done {
    let triangles = call.get(c"mesh", mesh)?.triangle_count;
    let scratch_bytes = pfront_morton_scratch_bytes(triangles);
    Build { mesh, leaf_size, memory, bvh }.by(call, morton, scratch_bytes)
}

/// Builds a BVH by the surface area heuristic, in O(n log n): the tree that queries walk fastest. `leaf_size` is as for
/// `pfront_bvh_build_morton`. Takes up to 72 KiB of stack.
#[entry]
fn pfront_bvh_build_sah(
    call: &mut Call<'_>,
    mesh: *const pfront_mesh_t,
    leaf_size: u32,
    memory: *const pfront_bvh_memory_t,
    bvh: *mut pfront_bvh_t,
) -> Done {
    let triangles = call.get(c"mesh", mesh)?.triangle_count;
    let scratch_bytes = pfront_sah_scratch_bytes(triangles);
    Build { mesh, leaf_size, memory, bvh }.by(call, sah, scratch_bytes)
}
