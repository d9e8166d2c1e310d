//! Meshes and boxes.

use crate::memory::{Call, Done};
use crate::status::Fault;
use crate::status::pfront_status_t::*;
use core::ffi::CStr;
use pfront_capi_entry::entry;
use pfront_core::Mesh;

/// A mesh that was checked: arrays of the caller's, which must stay where they are.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_mesh_t {
    /// For pfront to know that it has checked it.
    pub seal: u32,
    /// x, y, z of each vertex in turn.
    pub positions: *const f32,
    /// How many vertices: a third of the floats.
    pub vertex_count: usize,
    /// The three vertices of each triangle in turn.
    pub triangles: *const u32,
    /// How many triangles: a third of the indices.
    pub triangle_count: usize,
}

const SEAL: u32 = u32::from_be_bytes(*b"mesh");

impl pfront_mesh_t {
    /// A mesh of arrays that are valid, or about to be checked.
    pub(crate) fn made(
        positions: *const f32,
        vertex_count: usize,
        triangles: *const u32,
        triangle_count: usize,
    ) -> Self {
        Self { seal: SEAL, positions, vertex_count, triangles, triangle_count }
    }

    /// Checks the seal.
    pub(crate) fn sealed(&self, what: &'static CStr) -> Result<&Self, Fault> {
        if self.seal == SEAL { Ok(self) } else { Err(Fault::of(PFRONT_NOT_MADE, what)) }
    }

    /// The mesh, which was checked when it was made.
    pub(crate) fn view<'c>(&self, call: &Call<'c>, what: &'static CStr) -> Result<Mesh<'c>, Fault> {
        self.sealed(what)?;
        Ok(Mesh::new_unchecked(self.points(call)?, self.corners(call)?))
    }

    /// The same triangles over other positions, which are checked.
    pub(crate) fn moved<'c>(&self, call: &Call<'c>) -> Result<Mesh<'c>, Fault> {
        let (points, corners) = (self.points(call)?, self.corners(call)?);
        Ok(Mesh::new_unchecked(points, corners).with_positions(points)?)
    }

    fn points<'c>(&self, call: &Call<'c>) -> Result<&'c [[f32; 3]], Fault> {
        call.read(c"positions", self.positions.cast(), self.vertex_count)
    }

    fn corners<'c>(&self, call: &Call<'c>) -> Result<&'c [[u32; 3]], Fault> {
        call.read(c"triangles", self.triangles.cast(), self.triangle_count)
    }
}

/// Checks that every coordinate is finite and every index below `vertex_count`, and makes a mesh of it. Duplicate
/// triangles, triangles without area, vertices in no triangle and no triangles at all are fine.
///
/// Takes time in O(vertices + triangles).
#[entry]
fn pfront_mesh_check(
    call: &mut Call<'_>,
    positions: *const f32,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    mesh: *mut pfront_mesh_t,
) -> Done {
    let out = call.out(c"mesh", mesh)?;
    let checked = pfront_mesh_t::made(positions, vertex_count, triangles, triangle_count);
    Mesh::new(checked.points(call)?, checked.corners(call)?)?;
    out.set(checked);
    Ok(())
}

/// A box along the axes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_aabb_t {
    /// The smallest corner.
    pub min: [f32; 3],
    /// The largest corner.
    pub max: [f32; 3],
}
