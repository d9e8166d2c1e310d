//! Checks of poses before they come to the device.

use crate::GpuError;
use crate::layout::LARGEST_POSED;
use pfront_core::bvtt::Shadows;
use pfront_core::{Aabb, Pose};

/// Checks that a pose suits a mesh within `bounds`: as [`Pose::check`] does, and by [`LARGEST_POSED`].
pub(crate) fn check_pose(pose: &Pose, bounds: &Aabb) -> Result<(), GpuError> {
    pose.check(bounds)?;
    match (0..3).find(|&k| bounds.min[k].abs().max(bounds.max[k].abs()) > LARGEST_POSED) {
        Some(axis) => Err(GpuError::Coordinate { axis }),
        None => Ok(()),
    }
}

/// Checks that shadows may be those of meshes within `bounds`: everything is finite, no error is negative, and no posed
/// coordinate overflows.
pub(crate) fn check_shadows(shadows: &Shadows, bounds: [&Aabb; 2]) -> Result<(), GpuError> {
    let Shadows { poses, padding, error } = shadows;
    let is_error = |e: &f32| e.is_finite() && *e >= 0.0;
    let is_posed = |(pose, bounds): (&Pose, &Aabb)| {
        pose.rows.iter().all(|[x, y, z, t]| {
            let reach = |k: usize, entry: &f32| {
                f64::from(entry.abs()) * f64::from(bounds.min[k].abs().max(bounds.max[k].abs()))
            };
            let reach = f64::from(t.abs()) + reach(0, x) + reach(1, y) + reach(2, z);
            reach <= f64::from(LARGEST_POSED)
        })
    };
    let errors = padding.as_flattened().iter().chain(error);
    match errors.into_iter().all(is_error) && poses.iter().zip(bounds).all(is_posed) {
        true => Ok(()),
        false => Err(GpuError::Shadows),
    }
}
