//! How the boxes of two posed bodies are compared: in the frame of the first, where those of the second grow least.
//!
//! The box of a rotated box is larger. So the boxes of the first body stay as they are, and the pose of the second is seen
//! from the frame of the first, as the core's `Affine::seen_from` does. Triangles are posed into the world all the same:
//! only what has to be tested depends on it. A pose that cannot be inverted well enough leaves the world to compare in.

use crate::layout::InstancePair;
use glam::{DMat3, DVec3};
use pfront_core::{Aabb, Pose};
use pfront_shaders::constants::PADDING;

/// The error of rounding a posed coordinate relative to its reach, and of f64 roundings after it: 16 units.
const ROUNDING: f64 = 16.0 / (1 << 24) as f64;

/// A body with what its pairs ask of its pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) pose: Pose,
    matrix: DMat3,
    translation: DVec3,
    /// The largest coordinates of the mesh.
    far: DVec3,
    /// The farthest that posed corners get from the origin.
    reach: DVec3,
    /// The padding of boxes that are posed into the world.
    world_padding: [f32; 3],
}

/// The way back from the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inverse {
    matrix: DMat3,
    /// A bound on the error of each entry.
    error: f64,
}

impl Placed {
    pub(super) fn new(pose: &Pose, bounds: &Aabb) -> Self {
        let rows = pose.rows.map(|row| row.map(f64::from));
        let matrix = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
        let translation = DVec3::from_array(rows.map(|[.., translation]| translation));
        let corner = |corner: [f32; 3]| DVec3::from_array(corner.map(f64::from)).abs();
        let far = corner(bounds.min).max(corner(bounds.max));
        let reach = magnitudes(matrix) * far + translation.abs();
        let world_padding = padding(far, translation, DVec3::ZERO);
        Self { pose: *pose, matrix, translation, far, reach, world_padding }
    }

    /// `None` if the pose flattens or stretches too much.
    pub(super) fn inverse(&self) -> Option<Inverse> {
        const LIMIT: f64 = (1 << 20) as f64;
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = self.matrix.transpose();
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let determinant = x.dot(cofactors.x_axis);
        // Cofactors and determinant are off by some 2^-51 of size^2 and 2^-49 of size^3.
        let stretch = largest(self.matrix).powi(3) / determinant.abs();
        let matrix = cofactors / determinant;
        let error = stretch * largest(matrix) * f64::exp2(-44.0);
        (stretch <= LIMIT && error.is_finite()).then_some(Inverse { matrix, error })
    }
}

fn magnitudes(matrix: DMat3) -> DMat3 {
    DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
}

/// The largest magnitude of an entry.
fn largest(matrix: DMat3) -> f64 {
    let DMat3 { x_axis, y_axis, z_axis } = magnitudes(matrix);
    x_axis.max(y_axis).max(z_axis).max_element()
}

/// The padding of boxes of a mesh with coordinates up to `far` under a pose with this translation, beside the shaders'
/// [`PADDING`] of the magnitudes that it turns: the same of the translation, what an adapter may flush of it, of entries of the
/// matrix and of the results, and `more`.
fn padding(far: DVec3, translation: DVec3, more: DVec3) -> [f32; 3] {
    // 2^-122, and 2^-123 for each unit of the coordinates.
    const FLUSHED: f64 = 16.0 * f32::MIN_POSITIVE as f64;
    let flushed = FLUSHED + FLUSHED / 2.0 * far.element_sum();
    let padding = translation.abs() * f64::from(PADDING) + DVec3::splat(flushed) + more;
    (padding * (1.0 + ROUNDING)).to_array().map(|x| x as f32)
}

/// The poses of a pair and how its boxes are compared; the rest of the row is zero.
///
/// A point common to both bodies as they are posed in f32 is A(x) + d = B(y) + e for points x and y of the boxes, with d
/// and e at most 6 units of the reaches, and what underflows. So x = A⁻¹(B(y)) + A⁻¹(e − d): a box of A⁻¹·B,
/// padded by |A⁻¹| times 16 units of both reaches and by what A⁻¹ is off by, contains x.
pub(super) fn place(a: &Placed, inverse: Option<&Inverse>, b: &Placed) -> InstancePair {
    let poses = [a.pose.rows, b.pose.rows];
    let seen = inverse.and_then(|inverse| seen_from(a, inverse, b));
    let (boxes, pad_b) = seen.unwrap_or((b.pose.rows, b.world_padding));
    let is_posed = |side: &Placed| u32::from(side.pose != Pose::IDENTITY);
    let posed_boxes = if seen.is_some() { 2 } else { is_posed(a) | is_posed(b) << 1 };
    let pad_a = a.world_padding;
    InstancePair { boxes, pad_a, posed_boxes, pad_b, poses, ..bytemuck::Zeroable::zeroed() }
}

/// The second body seen from the first; `None` where f32 could not hold it.
fn seen_from(a: &Placed, inverse: &Inverse, b: &Placed) -> Option<([[f32; 4]; 3], [f32; 3])> {
    const LIMIT: DVec3 = DVec3::splat(1e30);
    // 2^-145: some operations on numbers that may be subnormal.
    const UNDERFLOW: f64 = f32::MIN_POSITIVE as f64 / (1 << 19) as f64;
    let reach = a.reach + b.reach;
    let off = inverse.error * reach.element_sum();
    let turn = inverse.matrix * b.matrix;
    let offset = inverse.matrix * (b.translation - a.translation);
    let spread = magnitudes(inverse.matrix) * (reach * ROUNDING + DVec3::splat(UNDERFLOW));
    let error = spread + DVec3::splat(off);
    let sizes = magnitudes(turn);
    let most = sizes * b.far + offset.abs() + error;
    let is_held = [sizes.x_axis, sizes.y_axis, sizes.z_axis, most]
        .iter()
        .all(|magnitudes| magnitudes.cmple(LIMIT).all());
    is_held.then(|| {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = turn.transpose();
        let row = |row: DVec3, offset: f64| row.extend(offset).as_vec4().to_array();
        let rows = [row(x, offset.x), row(y, offset.y), row(z, offset.z)];
        (rows, padding(b.far, offset, error))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that two random bodies have in common, as far as f32 tells.
    #[test]
    fn padding_covers_points_in_common() {
        let mut state = 1_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let bounds = Aabb { min: [-1.0; 3], max: [1.0; 3] };
        let mut tried = 0;
        for scale in [1.0, 1e-38, 1e-20, 1e-3, 1e6, 1e20] {
            for _ in 0..2_000 {
                let mut pose = || Pose::new([(); 3].map(|()| [(); 4].map(|()| scale * random())));
                let (a, b) = (Placed::new(&pose(), &bounds), Placed::new(&pose(), &bounds));
                let x = [(); 3].map(|()| random());
                let (Some(inverse), Some(back)) = (a.inverse(), b.inverse()) else { continue };
                let Some((rows, pad)) = seen_from(&a, &inverse, &b) else { continue };
                let common = DVec3::from_array(a.pose.apply(x).map(f64::from));
                let y = (back.matrix * (common - b.translation)).as_vec3();
                if y.abs().max_element() > 1.0 {
                    continue;
                }
                tried += 1;
                for k in 0..3 {
                    let [turn @ .., offset] = rows[k].map(f64::from);
                    let turn = DVec3::from_array(turn);
                    let seen = turn.dot(y.as_dvec3()) + offset;
                    let turned = turn.abs().element_sum();
                    let most = f64::from(pad[k]) + turned * f64::from(PADDING);
                    assert!(
                        (seen - f64::from(x[k])).abs() <= most,
                        "{scale:e}: {seen} {x:?} {most}"
                    );
                }
            }
        }
        assert!(tried > 1_000, "{tried}");
        let flat = Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]]);
        assert!(Placed::new(&flat, &bounds).inverse().is_none());
    }
}
