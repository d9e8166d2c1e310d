//! Poses: from what engines keep, inverses and products.

use crate::memory::{Call, Done};
use crate::status::Fault;
use crate::status::pfront_status_t::{PFRONT_NO_INVERSE, PFRONT_NOT_UNIT};
use pfront_capi_entry::entry;
use pfront_core::Pose;

/// A pose: three rows of a matrix, and in the last column the translation. Meant to be rigid; any finite affine map
/// works. `a_from_b` takes the coordinates of b to those of a. A posed coordinate is `((r0*x + r1*y) + r2*z) + t` in
/// f32, never fused.
///
/// With the poses of two bodies in the world, that of a query is `a_from_b = world_from_a^-1 * world_from_b`:
/// `pfront_pose_inverse`, then `pfront_pose_multiply`. Entries may be anything until a query checks them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_pose_t {
    /// Row-major.
    pub rows: [[f32; 4]; 3],
}

impl pfront_pose_t {
    pub(crate) const IDENTITY: Self = Self { rows: Pose::IDENTITY.rows };

    pub(crate) fn pose(&self) -> Pose {
        Pose::new(self.rows)
    }
}

impl From<Pose> for pfront_pose_t {
    fn from(Pose { rows }: Pose) -> Self {
        Self { rows }
    }
}

/// A pose in f64, which the bodies of scenes may have. A posed coordinate is `((r0*x + r1*y) + r2*z) + t` in f64, never
/// fused.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_pose64_t {
    /// Row-major.
    pub rows: [[f64; 4]; 3],
}

/// Makes a pose from a matrix of 16 floats by columns, as OpenGL, Vulkan, glam and three.js keep it. Its last row, 0 0 0
/// 1 of every affine map, is ignored.
#[entry]
fn pfront_pose_from_cols_array(
    call: &mut Call<'_>,
    matrix: *const f32,
    pose: *mut pfront_pose_t,
) -> Done {
    let out = call.out(c"pose", pose)?;
    let matrix: [f32; 16] = call.get(c"matrix", matrix.cast())?;
    out.set(Pose::from_cols_array(&matrix).into());
    Ok(())
}

/// How far from 1 the square of the length of a quaternion may be. Rounding in f32 takes it some 10^-6 away, and what engines
/// integrate from frame to frame a few times as much; a pose of one that is this far from it moves a point by a thousandth of its
/// distance from where the rotation does.
const OFF_UNIT: f64 = 1.0 / 1024.0;

/// Makes a pose from a rotation, a unit quaternion of 4 floats (x, y, z, w), and a translation of 3 that comes after it. A
/// quaternion the square of whose length differs from 1 by more than 1/1024, or is NaN, is PFRONT_NOT_UNIT: normalise it first.
/// One within that is taken as it is.
#[entry]
fn pfront_pose_from_rotation_translation(
    call: &mut Call<'_>,
    rotation: *const f32,
    translation: *const f32,
    pose: *mut pfront_pose_t,
) -> Done {
    let out = call.out(c"pose", pose)?;
    let rotation: [f32; 4] = call.get(c"rotation", rotation.cast())?;
    let translation: [f32; 3] = call.get(c"translation", translation.cast())?;
    let square: f64 = rotation.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
    // Nor is NaN within it.
    let is_unit = (square - 1.0).abs() <= OFF_UNIT;
    if !is_unit {
        return Err(Fault::of(PFRONT_NOT_UNIT, c"rotation"));
    }
    out.set(Pose::from_rotation_translation(rotation, translation).into());
    Ok(())
}

/// Makes the pose that takes every point back, computed in f64 and rounded once. `inverse` may be `pose` itself.
#[entry]
fn pfront_pose_inverse(
    call: &mut Call<'_>,
    pose: *const pfront_pose_t,
    inverse: *mut pfront_pose_t,
) -> Done {
    let (out, pose) = (call.out(c"inverse", inverse)?, call.get(c"pose", pose)?);
    let inverse = pose.pose().inverse().ok_or(Fault::of(PFRONT_NO_INVERSE, c"pose"))?;
    out.set(inverse.into());
    Ok(())
}

/// Makes the product `a_from_c = a_from_b * b_from_c`: the pose on the right comes first. Computed in f64 and rounded
/// once. `a_from_c` may be one of the others.
#[entry]
fn pfront_pose_multiply(
    call: &mut Call<'_>,
    a_from_b: *const pfront_pose_t,
    b_from_c: *const pfront_pose_t,
    a_from_c: *mut pfront_pose_t,
) -> Done {
    let out = call.out(c"a_from_c", a_from_c)?;
    let (left, right) = (call.get(c"a_from_b", a_from_b)?, call.get(c"b_from_c", b_from_c)?);
    out.set((left.pose() * right.pose()).into());
    Ok(())
}
