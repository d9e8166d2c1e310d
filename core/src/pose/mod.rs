//! Poses: affine maps of vertices, and how a posed vertex is rounded.
//!
//! The posed position of a vertex is defined to the bit, since every backend has to find the same triangles: per
//! coordinate `((r0·x + r1·y) + r2·z) + t`, in f32, rounded to nearest after each operation, never fused. In f64 the formula
//! is the same: if a mesh or a pose of two is in f64, both are posed so, and what is in f32 widens exactly.
//!
//! # Poses of an engine
//! | type | as a pose |
//! |---|---|
//! | `Affine3A`, as `GlobalTransform::affine` of bevy returns it | `Pose::from(map)`, with the feature of its version of glam |
//! | `Isometry3d` of bevy | `Pose::from(Affine3A::from(isometry))` |
//! | `Mat4` of any version | `Pose::from_cols_array(&matrix.to_cols_array())` |
//! | rotation and translation, as rapier's `Pose3` has them | `Pose::from_rotation_translation(p.rotation.into(), p.translation.into())` |
//!
//! "`From<Affine3A>` is not implemented", or "expected `Affine3A`, found `Affine3A`", means that the feature is missing, or that
//! of another version. Rapier's prelude has a `Pose` too: import one of them by its name.
//!
//! `Pose` converts back by `Affine3A::from(pose)`; its rows are public. The features `glam033` (bevy_math 0.20, rapier3d
//! 0.36) and `glam034` may be on together, and no type of glam is in the interface without them. There is none for mint:
//! it is off by default in these engines, glam has no conversion of `Affine3A` to it, and arrays do for the rest.

mod affine;
#[cfg(test)]
mod tests;

pub(crate) use affine::Affine;

use crate::Aabb;
use crate::scalar::Scalar;

/// A pose over one type of coordinates: [`Pose`] of meshes with f32 positions, or [`Pose64`].
///
/// `rows[i] = [r_i0, r_i1, r_i2, t_i]`, row-major 3×4. It is meant to be rigid, but any finite affine map works. With the
/// feature `serde` both are stored under the name `Pose`, in formats that store names.
///
/// # Examples
/// ```
/// use pfront_core::Pose;
/// let a_from_b = Pose::from_translation([0.0, 0.0, 2.0]);
/// assert_eq!(a_from_b.apply([1.0, 0.0, 0.0]), [1.0, 0.0, 2.0]);
/// ```
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename = "Pose"))]
pub struct PoseOf<S> {
    /// The three rows of the matrix.
    pub rows: [[S; 4]; 3],
}

impl<S: Scalar> PoseOf<S> {
    /// The pose that leaves every point where it is, to the bit but for the sign of zero.
    pub const IDENTITY: Self = {
        let (zero, one) = (S::ZERO, S::ONE);
        Self { rows: [[one, zero, zero, zero], [zero, one, zero, zero], [zero, zero, one, zero]] }
    };

    /// Makes a pose from its rows.
    #[must_use]
    pub const fn new(rows: [[S; 4]; 3]) -> Self {
        Self { rows }
    }

    /// Makes a pose that only translates.
    #[must_use]
    pub const fn from_translation(t: [S; 3]) -> Self {
        let mut pose = Self::IDENTITY;
        pose.rows[0][3] = t[0];
        pose.rows[1][3] = t[1];
        pose.rows[2][3] = t[2];
        pose
    }

    /// Makes a pose from a matrix by columns, as glam, bevy, rapier, OpenGL and three.js keep it. Its last row, 0 0 0 1
    /// of every affine map, is not read.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Pose;
    /// let matrix =
    ///     [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0];
    /// assert_eq!(Pose::from_cols_array(&matrix), Pose::from_translation([5.0, 6.0, 7.0]));
    /// ```
    #[must_use]
    pub const fn from_cols_array(m: &[S; 16]) -> Self {
        Self {
            rows: [
                [m[0], m[4], m[8], m[12]],
                [m[1], m[5], m[9], m[13]],
                [m[2], m[6], m[10], m[14]],
            ],
        }
    }

    /// Makes a pose from a rotation, as a unit quaternion (x, y, z, w), and a translation that comes after it.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Pose;
    /// let half_turn_about_z =
    ///     Pose::from_rotation_translation([0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 5.0]);
    /// assert_eq!(half_turn_about_z.apply([1.0, 2.0, 3.0]), [-1.0, -2.0, 8.0]);
    /// ```
    #[must_use]
    pub fn from_rotation_translation(rotation: [S; 4], translation: [S; 3]) -> Self {
        let ([x, y, z, w], [tx, ty, tz]) = (rotation.map(S::into), translation);
        let row = |r: [f64; 3], t: S| [S::nearest(r[0]), S::nearest(r[1]), S::nearest(r[2]), t];
        let (xx, yy, zz) = (x * x, y * y, z * z);
        Self {
            rows: [
                row([1.0 - 2.0 * (yy + zz), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)], tx),
                row([2.0 * (x * y + z * w), 1.0 - 2.0 * (xx + zz), 2.0 * (y * z - x * w)], ty),
                row([2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (xx + yy)], tz),
            ],
        }
    }

    /// The pose that takes every point back; `None` if there is none, since the pose is flat or not finite. Computed in
    /// f64 and rounded once.
    ///
    /// # Examples
    /// With the poses of two bodies in the world, the pose of a query is
    /// `a_from_b = world_from_a⁻¹ · world_from_b`:
    /// ```
    /// use pfront_core::Pose;
    /// let world_from_a =
    ///     Pose::from_rotation_translation([0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    /// let world_from_b = Pose::from_translation([3.0, 0.0, 0.0]);
    /// let inverse = world_from_a.inverse().expect("a rigid pose has an inverse");
    /// assert_eq!((inverse * world_from_b).apply([0.0; 3]), [-2.0, 0.0, 0.0]);
    /// ```
    #[must_use]
    pub fn inverse(&self) -> Option<Self> {
        let m = self.rows.map(|row| row.map(S::into));
        let minor = |i: usize, j: usize| {
            let ([r, s], [c, d]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
            m[r][c] * m[s][d] - m[r][d] * m[s][c]
        };
        let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
        let rows = [0, 1, 2].map(|i| {
            let r = [0, 1, 2].map(|j| minor(j, i) / determinant);
            let t = -(r[0] * m[0][3] + r[1] * m[1][3] + r[2] * m[2][3]);
            [r[0], r[1], r[2], t].map(S::nearest)
        });
        rows.iter().flatten().all(|&x| x.into().is_finite()).then_some(Self { rows })
    }

    /// Returns the posed point, rounded as the [module](self) says.
    #[inline]
    #[must_use]
    pub fn apply(&self, p: [S; 3]) -> [S; 3] {
        self.rows.map(|r| ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + r[3])
    }

    /// Checks that the pose is finite and keeps a mesh within `bounds`, which may be empty, well inside the range of
    /// f32, so that neither a posed corner nor a padded box can overflow.
    ///
    /// # Errors
    /// [`PoseError`] names the entry or the row.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{Aabb, Pose, pose::PoseError};
    /// let far = Pose::from_translation([0.0, 1e38, 0.0]);
    /// let unit = Aabb { min: [0.0; 3], max: [1.0; 3] };
    /// assert_eq!(far.check(&unit), Err(PoseError::Range { row: 1 }));
    /// ```
    pub fn check(&self, bounds: &Aabb) -> Result<(), PoseError> {
        let extent =
            |min: f32, max: f32| S::from(if min <= max { min.abs().max(max.abs()) } else { 0.0 });
        let ([a, b, c], [d, e, f]) = (bounds.min, bounds.max);
        self.check_reach([extent(a, d), extent(b, e), extent(c, f)])
    }

    /// [`Self::check`] for a mesh whose coordinates are at most so large.
    pub(crate) fn check_reach(&self, extent: [S; 3]) -> Result<(), PoseError> {
        for (row, entries) in self.rows.iter().enumerate() {
            if let Some(column) = entries.iter().position(|&x| !x.into().is_finite()) {
                return Err(PoseError::NonFinite { row, column });
            }
            let [x, y, z, t] = entries.map(S::abs);
            let reach: f64 = (t + x * extent[0] + y * extent[1] + z * extent[2]).into();
            if reach.is_nan() || reach >= POSED_LIMIT.into() {
                return Err(PoseError::Range { row });
            }
        }
        Ok(())
    }
}

/// `a_from_b * b_from_c` is `a_from_c`: the pose on the right comes first. Computed in f64 and rounded once, so that a
/// point posed by it may differ from one posed twice in the last digits.
impl<S: Scalar> core::ops::Mul for PoseOf<S> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let other = other.rows.map(|row| row.map(S::into));
        Self {
            rows: self.rows.map(|row| {
                let r = row.map(S::into);
                let entry = |k: usize| r[0] * other[0][k] + r[1] * other[1][k] + r[2] * other[2][k];
                [entry(0), entry(1), entry(2), entry(3) + r[3]].map(S::nearest)
            }),
        }
    }
}

/// A pose of meshes with f32 positions.
pub type Pose = PoseOf<f32>;

/// A pose in f64, of meshes with positions of either kind: see `Mesh::from_f64`.
pub type Pose64 = PoseOf<f64>;

impl Pose {
    /// The rounding error of [`Pose::apply`] in a coordinate is less than this times |R|·|p| + |t| of that coordinate,
    /// plus [`f32::MIN_POSITIVE`]: 16 · 2⁻²⁴, of which the posed point takes 6 · 2⁻²⁴ and what bounds it the rest.
    pub const ROUNDING: f32 = 9.536_743_e-7;
}

/// The same entries in f64, in which the posed points differ: they are rounded there.
impl From<Pose> for Pose64 {
    fn from(pose: Pose) -> Self {
        Self { rows: pose.rows.map(|row| row.map(f64::from)) }
    }
}

/// The largest coordinate that a pose may take a mesh to: 2^125.
const POSED_LIMIT: f32 = 4.253_529_6e37;

/// Conversions, both ways, between poses and the affine maps of one version of glam.
macro_rules! affine_maps_of {
    ($glam:ident, $feature:literal, $map:ident, $pose:ident) => {
        #[cfg(feature = $feature)]
        impl From<$glam::$map> for $pose {
            fn from(map: $glam::$map) -> Self {
                let [x, y, z, t] = map.to_cols_array_2d();
                Self { rows: [0, 1, 2].map(|i| [x[i], y[i], z[i], t[i]]) }
            }
        }

        #[cfg(feature = $feature)]
        impl From<$pose> for $glam::$map {
            fn from(pose: $pose) -> Self {
                Self::from_cols_array_2d(&[0, 1, 2, 3].map(|column| pose.rows.map(|r| r[column])))
            }
        }
    };
}
affine_maps_of!(glam033, "glam033", Affine3A, Pose);
affine_maps_of!(glam, "glam034", Affine3A, Pose);
affine_maps_of!(glam033, "glam033", DAffine3, Pose64);
affine_maps_of!(glam, "glam034", DAffine3, Pose64);

/// A pose that a mesh cannot have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// An entry is NaN or infinite.
    #[error("entry {column} of row {row} of the pose is NaN or infinite")]
    NonFinite {
        /// The row of the entry.
        row: usize,
        /// The column of the entry; 3 is the translation.
        column: usize,
    },
    /// The pose may take the mesh beyond 2^125, an eighth of the range of f32.
    #[error("row {row} of the pose takes the mesh beyond ±{POSED_LIMIT:e}")]
    Range {
        /// The row, and coordinate, at fault.
        row: usize,
    },
}
