//! Queries about positions or poses in f64.
//!
//! What lanes and boxes see of them are shadows (see [`Mesh::from_f64`](crate::Mesh::from_f64)), in a frame whose origin is
//! that of the first shadow as it is posed: large translations cancel in f64, before they are rounded to f32. Boxes are
//! padded by how far a shadow may be from what it stands for, and lanes only reject pairs, by a bound that allows for it. All
//! other pairs are decided by the positions themselves, posed in f64.

use super::TrianglePair;
use crate::Mesh;
use crate::aabb::Bounds;
use crate::pose::{Affine, Pose64, PoseError};
use crate::triangle::{Adjacency, intersects_in_f64, intersects_in_mesh_f64};

/// A mesh in a pose, and the box of its shadow.
#[derive(Clone, Copy)]
pub(crate) struct Side<'a> {
    pub(crate) mesh: Mesh<'a>,
    pub(crate) bounds: Bounds,
    pub(crate) pose: Pose64,
}

/// What only these queries call. It comes by pointer with a mesh or a pose in f64, so that firmware that has neither links
/// none of it.
#[derive(Debug)]
pub(crate) struct F64 {
    pub(super) check: fn(&Side<'_>) -> Result<(), PoseError>,
    pub(super) in_world: fn(&Side<'_>) -> Affine,
    pub(super) in_frame_of_first: fn(&[Side<'_>; 2]) -> [Affine; 2],
    pub(super) intersects: fn(&[(Mesh<'_>, Pose64); 2], TrianglePair) -> bool,
    pub(super) intersects_in_mesh: fn(Mesh<'_>, TrianglePair, Adjacency) -> bool,
}

impl F64 {
    pub(crate) const METHODS: Self =
        Self { check, in_world, in_frame_of_first, intersects, intersects_in_mesh };
}

/// A pose in f64, and what a query in f64 calls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Posed64 {
    pub(super) pose: Pose64,
    pub(super) f64: &'static F64,
}

fn check(side: &Side<'_>) -> Result<(), PoseError> {
    let half = side.bounds.min.abs().max(side.bounds.max.abs()).as_dvec3();
    let origin = origin(side).abs();
    // At least 1, so that no entry of the pose overflows in f32.
    side.pose.check_reach((origin + half.max(glam::DVec3::ZERO)).max(glam::DVec3::ONE).to_array())
}

/// The pose of a shadow in the world itself.
fn in_world(side: &Side<'_>) -> Affine {
    Affine::of_shadow(&side.pose, origin(side), &side.bounds, glam::DVec3::ZERO)
}

/// The poses of both shadows in the frame whose origin is that of the first as it is posed.
fn in_frame_of_first(sides: &[Side<'_>; 2]) -> [Affine; 2] {
    let zero = sides[0].pose.apply(sides[0].mesh.origin());
    sides.each_ref().map(|side| {
        Affine::of_shadow(&side.pose, origin(side), &side.bounds, glam::DVec3::from_array(zero))
    })
}

fn origin(side: &Side<'_>) -> glam::DVec3 {
    glam::DVec3::from_array(side.mesh.origin())
}

#[inline(never)]
fn intersects([(a, pose_a), (b, pose_b)]: &[(Mesh<'_>, Pose64); 2], pair: TrianglePair) -> bool {
    let posed = |mesh: &Mesh<'_>, pose: &Pose64, triangle: u32| {
        mesh.triangle_f64(triangle).map(|p| pose.apply(p))
    };
    intersects_in_f64(&posed(a, pose_a, pair.a), &posed(b, pose_b, pair.b))
}

#[inline(never)]
fn intersects_in_mesh(mesh: Mesh<'_>, pair: TrianglePair, adjacency: Adjacency) -> bool {
    intersects_in_mesh_f64(mesh, pair.a, pair.b, adjacency)
}
