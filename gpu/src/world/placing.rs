//! How the boxes of two posed bodies are compared: in the frame of the first, where those of the second grow least.
//!
//! The box of a rotated box is larger. So the boxes of the first body stay as they are, and the pose of the second is seen
//! from the frame of the first, as the core's `Affine::seen_from` does. Triangles are posed into the world all the same:
//! only what has to be tested depends on it. A pose that cannot be inverted well enough leaves the world to compare in.

use crate::layout::InstancePair;
use pfront_core::{Aabb, Pose};
use pfront_shaders::constants::PADDING;

/// A vector or matrix in f64.
type Vector = [f64; 3];
type Matrix = [Vector; 3];

/// The error of rounding a posed coordinate relative to its reach, and of f64 roundings after it: 16 units.
const ROUNDING: f64 = 16.0 / (1 << 24) as f64;

/// A body with what its pairs ask of its pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pose: Pose,
    matrix: Matrix,
    /// The largest coordinates of the mesh.
    far: Vector,
    /// The farthest that posed corners get from the origin.
    reach: Vector,
    /// The padding of boxes that are posed into the world.
    world_padding: [f32; 3],
}

/// The way back from the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inverse {
    matrix: Matrix,
    /// A bound on the error of each entry.
    error: f64,
}

impl Placed {
    pub(super) fn new(pose: &Pose, bounds: &Aabb) -> Self {
        let matrix = pose.rows.map(|[x, y, z, _]| [x, y, z].map(f64::from));
        let far = [0, 1, 2].map(|k| f64::from(bounds.min[k].abs().max(bounds.max[k].abs())));
        let reach =
            [0, 1, 2].map(|k| dot(matrix[k].map(f64::abs), far) + f64::from(pose.rows[k][3]).abs());
        let world_padding = padding(far, pose.rows.map(|row| f64::from(row[3])), [0.0; 3]);
        Self { pose: *pose, matrix, far, reach, world_padding }
    }

    /// `None` if the pose flattens or stretches too much.
    pub(super) fn inverse(&self) -> Option<Inverse> {
        const LIMIT: f64 = (1 << 20) as f64;
        let [x, y, z] = self.matrix;
        let columns = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = dot(x, columns[0]);
        let size = (self.matrix.iter().flatten()).fold(0.0, |size, entry| entry.abs().max(size));
        // Cofactors and determinant are off by some 2^-51 of size^2 and 2^-49 of size^3.
        let stretch = size.powi(3) / determinant.abs();
        let matrix = [0, 1, 2].map(|k| columns.map(|column| column[k] / determinant));
        let largest = (matrix.iter().flatten()).fold(0.0, |most, entry| entry.abs().max(most));
        let error = stretch * largest * f64::exp2(-44.0);
        (stretch <= LIMIT && error.is_finite()).then_some(Inverse { matrix, error })
    }
}

/// The padding of boxes of a mesh with coordinates up to `far` under a pose with this translation, beside the shaders'
/// [`PADDING`] of the magnitudes that it turns: the same of the translation, what an adapter may flush of it, of entries of the
/// matrix and of the results, and `more`.
fn padding(far: Vector, translation: Vector, more: Vector) -> [f32; 3] {
    let flushed = f64::exp2(-122.0) + f64::exp2(-123.0) * far.iter().sum::<f64>();
    [0, 1, 2].map(|k| {
        let padding = translation[k].abs() * f64::from(PADDING) + flushed + more[k];
        (padding * (1.0 + ROUNDING)) as f32
    })
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
    const LIMIT: f64 = 1e30;
    // Some operations on numbers that may be subnormal.
    let underflow = f64::exp2(-145.0);
    let reach = [0, 1, 2].map(|k| (a.reach[k] + b.reach[k]) * ROUNDING + underflow);
    let apart = [0, 1, 2].map(|k| f64::from(b.pose.rows[k][3]) - f64::from(a.pose.rows[k][3]));
    let off = inverse.error * [a.reach, b.reach].iter().flatten().sum::<f64>();
    let columns = [0, 1, 2].map(|k| b.matrix.map(|row| row[k]));
    let turn = inverse.matrix.map(|row| columns.map(|column| dot(row, column)));
    let offset = inverse.matrix.map(|row| dot(row, apart));
    let error = inverse.matrix.map(|row| dot(row.map(f64::abs), reach) + off);
    let is_held = |k: usize| {
        let most = dot(turn[k].map(f64::abs), b.far) + offset[k].abs() + error[k];
        most <= LIMIT && turn[k].iter().all(|entry| entry.abs() <= LIMIT)
    };
    (0..3).all(is_held).then(|| {
        let row = |k: usize| [turn[k][0], turn[k][1], turn[k][2], offset[k]].map(|x| x as f32);
        ([row(0), row(1), row(2)], padding(b.far, offset, error))
    })
}

fn dot([x, y, z]: Vector, [u, v, w]: Vector) -> f64 {
    x * u + y * v + z * w
}

fn cross([x, y, z]: Vector, [u, v, w]: Vector) -> Vector {
    [y * w - z * v, z * u - x * w, x * v - y * u]
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
                let common = a.pose.apply(x);
                let offset = [0, 1, 2].map(|k| f64::from(common[k]) - f64::from(b.pose.rows[k][3]));
                let y = back.matrix.map(|row| dot(row, offset) as f32);
                if y.iter().any(|y| y.abs() > 1.0) {
                    continue;
                }
                tried += 1;
                for k in 0..3 {
                    let row = rows[k].map(f64::from);
                    let seen = dot([row[0], row[1], row[2]], y.map(f64::from)) + row[3];
                    let turned = dot([row[0], row[1], row[2]].map(f64::abs), [1.0; 3]);
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
