//! Bodies as the device compares their boxes: in the frame of the first of two, where those of the second grow least.
//!
//! The box of a rotated box is larger. So the boxes of the first body stay as they are, and the pose of the second is seen
//! from the frame of the first, as the core's `Affine::seen_from` does. `pose.wgsl` does this in f32 for each pair, from what
//! is computed here for each body, in f64. Triangles are posed into the world all the same: only what has to be tested depends
//! on it. A pose that cannot be inverted well enough, or is out of range, leaves the world to compare in.
//!
//! A point common to both bodies as they are posed in f32 is A(x) + d = B(y) + e for points x and y of the boxes, with d
//! and e at most 6 units, of 2^-24, of the reaches, and what underflows. So x = A⁻¹(B(y)) + A⁻¹(e − d). The device has A⁻¹ in f32,
//! each entry off by a unit of it and by `error`, and multiplies it by B, which takes three roundings of two units, and by the
//! difference of the translations, which takes four, whichever way they go and whatever is fused. A box of what it finds,
//! padded by |A⁻¹| times 6 + 1 + 8 units of both reaches and by `error` times both, contains x. It is padded by |A⁻¹| times
//! [`PADDING`], 32 units: the rest is more than what the padding loses where it is computed.
//!
//! An adapter may flush any number below f = 2^-126. Entries of B, the difference of the translations and what d and e lose cost
//! |A⁻¹| times 4f at most, and that for each unit of the coordinates of the second mesh; reaches are as much larger as makes twice that of PADDING.
//! Entries of A⁻¹, and their products with PADDING, cost 2f of the reaches, and `error` is 4f larger. Products and sums cost at most
//! 16f, and 5f for each unit of the coordinates, and boxes as they are posed take 16f and 8f (`boxes.wgsl`): `flushed` is 32f, and that
//! for each unit.

use crate::layout::Body;
use bytemuck::Zeroable;
use glam::{DMat3, DVec3};
use pfront_core::{Aabb, Pose};
use pfront_shaders::constants::{IN_RANGE, INVERTIBLE, PADDING, POSED};

/// The most that coordinates, reaches, and entries of matrices may be of bodies that are compared in the frame of one of them: what is
/// multiplied and added up of them stays below 2^100.
const LIMIT: f64 = (1_u64 << 48) as f64;

/// Rounds a positive f32 up, and what is computed of it in f64.
const UP: f64 = 1.0 + 1.0 / (1 << 22) as f64;

/// A body with a mesh within `bounds`; where its mesh lies is zero.
pub(super) fn place(pose: &Pose, bounds: &Aabb) -> Body {
    let rows = pose.rows.map(|row| row.map(f64::from));
    let matrix = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
    let translation = DVec3::from_array(rows.map(|[.., translation]| translation));
    let corner = |corner: [f32; 3]| DVec3::from_array(corner.map(f64::from)).abs();
    let far = corner(bounds.min).max(corner(bounds.max));
    let reach = magnitudes(matrix) * far + translation.abs();
    let flushed = f64::from(f32::MIN_POSITIVE) * (1.0 + far.element_sum());
    let in_range = [far, reach, DVec3::splat(largest(matrix))];
    let is_in_range = in_range.iter().all(|sizes| sizes.cmple(DVec3::splat(LIMIT)).all());
    let inverse = inverse(matrix).filter(|_| is_in_range);
    let kind = [
        (*pose != Pose::IDENTITY, POSED),
        (is_in_range, IN_RANGE),
        (inverse.is_some(), INVERTIBLE),
    ];
    Body {
        pose: pose.rows,
        inverse: inverse.unwrap_or_default(),
        reach: ((reach + 8.0 / f64::from(PADDING) * flushed) * UP).as_vec3().to_array(),
        flushed: (32.0 * flushed * UP) as f32,
        kind: kind.iter().filter(|(is_so, _)| *is_so).map(|(_, kind)| kind).sum(),
        ..Body::zeroed()
    }
}

/// The way back from the world without its translation, and in w a bound on the error of its entries; `None` if the pose flattens
/// or stretches too much.
fn inverse(matrix: DMat3) -> Option<[[f32; 4]; 3]> {
    const STRETCH: f64 = (1 << 20) as f64;
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = matrix.transpose();
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let determinant = x.dot(cofactors.x_axis);
    // Cofactors and determinant are off by some 2^-51 of size^2 and 2^-49 of size^3.
    let stretch = largest(matrix).powi(3) / determinant.abs();
    let inverse = cofactors / determinant;
    let error = stretch * largest(inverse) * f64::exp2(-44.0);
    let error = (error + 4.0 * f64::from(f32::MIN_POSITIVE)) * UP;
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = inverse.transpose();
    let rows = [x, y, z].map(|row| row.extend(error).as_vec4().to_array());
    (stretch <= STRETCH && largest(inverse) <= LIMIT).then_some(rows)
}

fn magnitudes(matrix: DMat3) -> DMat3 {
    DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
}

/// The largest magnitude of an entry.
fn largest(matrix: DMat3) -> f64 {
    let DMat3 { x_axis, y_axis, z_axis } = magnitudes(matrix);
    x_axis.max(y_axis).max(z_axis).max_element()
}
