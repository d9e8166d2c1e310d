//! Queries about positions or poses in f64.
//!
//! Lanes and boxes see only shadows of them (see [`Mesh::from_f64`](crate::Mesh::from_f64)), in a frame whose origin is that of
//! the first shadow as it is posed: large translations cancel in f64, before they are rounded to f32. Boxes are padded by how
//! far a shadow may be from what it stands for, and lanes certify signs by a bound that allows for it. All other pairs are
//! decided by the positions themselves, posed in f64.

use super::TrianglePair;
use super::trees::view;
use crate::Mesh;
use crate::aabb::Bounds;
use crate::one_ring::turns_in_f64;
use crate::pose::{Affine, Pose, Pose64, PoseError};
use crate::triangle::{Adjacency, Contact, contact_of, intersects_in_f64, intersects_in_mesh_f64};
use glam::{DVec3, Vec3A};

/// The shadows of two meshes as a query in f64 poses them, for a device that poses them by itself: both into the frame whose
/// origin is that of the first shadow as it is posed. See [`PairBvtt::shadows`](super::PairBvtt::shadows).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadows {
    /// The poses of both.
    pub poses: [Pose; 2],
    /// How far a corner of each, as [`Pose::apply`] poses it, may be from what it stands for, on each axis.
    pub padding: [[f32; 3]; 2],
    /// How far the difference of two coordinates of such corners may be from that of what they stand for.
    pub error: [f32; 3],
}

/// The functions that only these queries call. They come by pointer with a mesh or a pose in f64, so that firmware that has
/// neither links none of them.
#[derive(Debug)]
pub(crate) struct F64 {
    pub(super) check: fn(Mesh<'_>, &Bounds, &Pose) -> Result<(), PoseError>,
    pub(super) pose: fn(Side<'_>, &Pose),
    pub(super) pose_in_frame_of_first: fn([Side<'_>; 2], &mut [Option<Affine>; 2]) -> Vec3A,
    pub(super) intersects: fn([PosedMesh<'_>; 2], TrianglePair) -> bool,
    pub(super) contact: fn([PosedMesh<'_>; 2], TrianglePair) -> Option<Contact<f64>>,
    pub(crate) intersects_in_mesh: fn(Mesh<'_>, [u32; 2], Adjacency) -> bool,
    /// The turns of a triangle, by which one-rings are certified.
    pub(crate) turns: fn(Mesh<'_>, &[u32; 3]) -> u32,
}

/// A mesh, the box of its shadow, and the poses of both.
pub(super) struct Side<'s> {
    pub(super) mesh: &'s Mesh<'s>,
    pub(super) bounds: &'s Bounds,
    pub(super) pose: &'s mut Option<Affine>,
    pub(super) exact: &'s mut Option<Posed64>,
}

/// A mesh, and the pose of its positions unless it is the identity.
pub(super) type PosedMesh<'m> = (&'m Mesh<'m>, &'m Option<Posed64>);

/// A pose in f64, and what a query in f64 calls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Posed64 {
    pub(super) pose: Pose64,
    pub(super) f64: &'static F64,
}

impl F64 {
    pub(crate) const METHODS: Self = Self {
        check: |mesh, bounds, pose| check(mesh, bounds, &(*pose).into()),
        pose: |side, pose| _ = place(side, (*pose).into(), DVec3::ZERO),
        pose_in_frame_of_first,
        intersects: |sides, pair| {
            let [a, b] = posed(sides, pair);
            intersects_in_f64(&a, &b)
        },
        contact: |sides, pair| {
            let [a, b] = posed(sides, pair);
            contact_of(&a, &b)
        },
        intersects_in_mesh: intersects_in_mesh_f64,
        turns: turns_in_f64,
    };
}

/// Checks that a pose in f64 is finite and keeps a mesh, the box of whose shadow these are, in range.
pub(super) fn check(mesh: Mesh<'_>, bounds: &Bounds, pose: &Pose64) -> Result<(), PoseError> {
    let half = bounds.min.abs().max(bounds.max.abs()).as_dvec3();
    let half = if bounds.min.x <= bounds.max.x { half } else { DVec3::ZERO };
    // At least 1, so that no entry of the pose overflows in f32.
    let extent = (DVec3::from_array(mesh.origin()).abs() + half).max(DVec3::ONE);
    pose.check_reach(extent.to_array())
}

/// Poses both shadows in the frame whose origin is that of the first as it is posed, and their boxes. Returns how far the
/// difference of two coordinates there may be from that of the positions.
fn pose_in_frame_of_first(sides: [Side<'_>; 2], box_poses: &mut [Option<Affine>; 2]) -> Vec3A {
    let poses = sides.each_ref().map(|side| match (&side.exact, &side.pose) {
        (Some(exact), _) => exact.pose,
        (None, Some(pose)) => pose.to_pose().into(),
        (None, None) => Pose64::IDENTITY,
    });
    let zero = DVec3::from_array(poses[0].apply(sides[0].mesh.origin()));
    let [a, b] = sides;
    let (of_b, pose_a, pose_b) = (b.bounds, place(a, poses[0], zero), place(b, poses[1], zero));
    *box_poses = [Some(pose_a), Some(pose_b)];
    view(box_poses, of_b);
    // Boxes need all of the paddings, corners no more than 13/16 of each.
    pose_a.padding().max(pose_b.padding()) * 1.75
}

/// Poses positions, and their shadow in a frame whose origin is at `zero`. Returns the pose of the shadow.
pub(super) fn place(side: Side<'_>, pose: Pose64, zero: DVec3) -> Affine {
    let origin = DVec3::from_array(side.mesh.origin());
    let shadow = Affine::of_shadow(&pose, origin, side.bounds, zero);
    *side.pose = Some(shadow);
    *side.exact = Some(Posed64 { pose, f64: &F64::METHODS });
    shadow
}

/// The posed corners of two triangles.
fn posed([a, b]: [PosedMesh<'_>; 2], pair: TrianglePair) -> [[[f64; 3]; 3]; 2] {
    let posed = |(mesh, exact): PosedMesh<'_>, triangle: u32| {
        let corners = mesh.triangle_f64(triangle);
        exact.map_or(corners, |exact| corners.map(|p| exact.pose.apply(p)))
    };
    [posed(a, pair.a), posed(b, pair.b)]
}
