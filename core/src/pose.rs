//! Rigid poses, and the two ways a walk places a mesh.
//!
//! `accuracy.md` (contract 2) fixes the posed position of a vertex to the bit, since every backend
//! has to find the same triangles: per coordinate `((r0·x + r1·y) + r2·z) + t`, in f32, rounded to
//! nearest after each operation, never fused.

use crate::Aabb;
use crate::aabb::Bounds;
use core::fmt;
use glam::Vec3A;

/// A pose: `rows[i] = [r_i0, r_i1, r_i2, t_i]`, row-major 3×4. Meant to be rigid; any finite affine
/// map works.
///
/// # Examples
/// ```
/// use pfront_core::Pose;
/// let a_from_b = Pose::from_translation([0.0, 0.0, 2.0]);
/// assert_eq!(a_from_b.apply([1.0, 0.0, 0.0]), [1.0, 0.0, 2.0]);
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Pose {
    /// The three rows of the matrix.
    pub rows: [[f32; 4]; 3],
}

impl Pose {
    /// Leaves every point where it is, to the bit but for the sign of zero.
    pub const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// A pose from its rows.
    #[must_use]
    pub const fn new(rows: [[f32; 4]; 3]) -> Self {
        Self { rows }
    }

    /// A pose that only moves.
    #[must_use]
    pub const fn from_translation(t: [f32; 3]) -> Self {
        let mut pose = Self::IDENTITY;
        pose.rows[0][3] = t[0];
        pose.rows[1][3] = t[1];
        pose.rows[2][3] = t[2];
        pose
    }

    /// The posed point, by the formula of the contract.
    #[inline]
    #[must_use]
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        self.rows.map(|r| ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + r[3])
    }

    /// Checks that the pose is finite and keeps a mesh within `bounds`, which may be empty, well inside the
    /// range of f32, so that neither a posed corner nor a padded box can overflow.
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
        for (row, entries) in self.rows.iter().enumerate() {
            if let Some(column) = entries.iter().position(|x| !x.is_finite()) {
                return Err(PoseError::NonFinite { row, column });
            }
            let extent = |k: usize| match (bounds.min[k], bounds.max[k]) {
                (min, max) if min <= max => min.abs().max(max.abs()),
                _ => 0.0,
            };
            let reach = (0..3).fold(entries[3].abs(), |sum, k| sum + entries[k].abs() * extent(k));
            // Nor may a padded extent overflow before it is scaled: infinity times a zero is no number.
            if reach >= POSED_LIMIT || extent(row) >= f32::MAX / 2.0 {
                return Err(PoseError::Range { row });
            }
        }
        Ok(())
    }
}

/// How far a pose may take a mesh from the origin, 2^125: an eighth of the range of f32.
pub const POSED_LIMIT: f32 = 4.253_529_6e37;

impl From<glam::Affine3A> for Pose {
    fn from(m: glam::Affine3A) -> Self {
        let [x, y, z, t] = m.to_cols_array_2d();
        Self { rows: [0, 1, 2].map(|i| [x[i], y[i], z[i], t[i]]) }
    }
}

/// Why a mesh cannot be posed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PoseError {
    /// An entry is NaN or infinite.
    NonFinite {
        /// Its row.
        row: usize,
        /// Its column; 3 is the translation.
        column: usize,
    },
    /// The pose may take the mesh beyond [`POSED_LIMIT`].
    Range {
        /// The coordinate, and row, in which it does.
        row: usize,
    },
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite { row, column } => {
                write!(f, "entry {column} of row {row} of the pose is NaN or infinite")
            }
            Self::Range { row } => {
                write!(f, "row {row} of the pose takes the mesh beyond ±{POSED_LIMIT:e}")
            }
        }
    }
}

impl core::error::Error for PoseError {}

/// How a walk sees a mesh: where its boxes and corners are in the frame of the query.
pub(crate) trait Placement {
    /// A box that contains the placed corners of everything in `bounds`.
    fn bounds(&self, bounds: &Bounds) -> Bounds;
    /// The placed corner.
    fn point(&self, p: Vec3A) -> Vec3A;
}

impl<P: Placement> Placement for &P {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        P::bounds(self, bounds)
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        P::point(self, p)
    }
}

/// The mesh is in the frame of the query as it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InPlace;

impl Placement for InPlace {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        *bounds
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        p
    }
}

/// A pose by columns, with what box transformation needs beside it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posed {
    columns: [Vec3A; 3],
    magnitudes: [Vec3A; 3],
    translation: Vec3A,
    /// Padding that the translation alone asks for.
    slack: Vec3A,
}

/// 16 · 2^-24: see [`Posed::bounds`].
const PADDING: f32 = 9.536_743_e-7;

/// 2^-147: four times the smallest subnormal number.
const SUBNORMAL_SLACK: f32 = f32::from_bits(4);

impl Posed {
    pub(crate) fn new(pose: &Pose) -> Self {
        let column = |k: usize| Vec3A::from_array([0, 1, 2].map(|i| pose.rows[i][k]));
        let columns = [column(0), column(1), column(2)];
        Self {
            columns,
            magnitudes: columns.map(Vec3A::abs),
            translation: column(3),
            slack: column(3).abs() * PADDING + Vec3A::splat(f32::MIN_POSITIVE),
        }
    }
}

impl Placement for Posed {
    /// The box of centre R·c + t and half extent |R|·e, padded by 16u(|R|(|c| + e) + |t|), u = 2^-24.
    ///
    /// A posed vertex carries at most 6 roundings of u relative to |R||v| + |t|, and the centre
    /// and half extent computed here at most 9 together relative to the same sum, so that the true
    /// and the computed posed vertex both lie inside. Underflow costs centre and extent half a step of
    /// the subnormal range a product, before a stretching pose magnifies it, and the posed vertex less
    /// than the smallest normal number after; [`Pose::check`] rules out overflow.
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        let centre = bounds.min * 0.5 + bounds.max * 0.5;
        let extent = bounds.max * 0.5 - bounds.min * 0.5;
        let grown = extent + (centre.abs() + extent) * PADDING + Vec3A::splat(SUBNORMAL_SLACK);
        let [x, y, z] = self.columns;
        let middle = x * centre.x + y * centre.y + z * centre.z + self.translation;
        let [x, y, z] = self.magnitudes;
        let reach = x * grown.x + y * grown.y + z * grown.z + self.slack;
        Bounds { min: middle - reach, max: middle + reach }
    }

    /// The formula of [`Pose::apply`], three rows at once; glam fuses nothing in these operators.
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        let [x, y, z] = self.columns;
        ((x * p.x + y * p.y) + z * p.z) + self.translation
    }
}

/// Either, for what is asked of single nodes; a walk asks once and keeps to the one or the other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    InPlace,
    Posed(Posed),
}

impl Place {
    pub(crate) fn new(pose: &Pose) -> Self {
        if *pose == Pose::IDENTITY { Self::InPlace } else { Self::Posed(Posed::new(pose)) }
    }
}

impl Placement for Place {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        match self {
            Self::InPlace => InPlace.bounds(bounds),
            Self::Posed(posed) => posed.bounds(bounds),
        }
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        match self {
            Self::InPlace => InPlace.point(p),
            Self::Posed(posed) => posed.point(p),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course() -> impl Iterator<Item = (Pose, [[f32; 3]; 2])> {
        let mut state = 7_u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let scale = [1e-6, 1.0, 3.0, 1e4][(state >> 4) as usize % 4];
            ((state >> 9) as f32 / 4_194_304.0 - 1.0) * scale
        };
        (0..if cfg!(miri) { 20 } else { 50_000 }).map(move |_| {
            let rows = core::array::from_fn(|_| core::array::from_fn(|_| next()));
            (Pose::new(rows), core::array::from_fn(|_| core::array::from_fn(|_| next())))
        })
    }

    #[test]
    fn corners_are_posed_by_the_formula_of_the_contract_to_the_bit() {
        for (pose, points) in course() {
            for p in points {
                let posed = Posed::new(&pose).point(Vec3A::from_array(p)).to_array();
                assert_eq!(posed.map(f32::to_bits), pose.apply(p).map(f32::to_bits));
            }
        }
    }

    #[test]
    fn posed_boxes_contain_posed_corners() {
        for (pose, points) in course() {
            let aabb = Aabb::of(&points);
            let placed = Posed::new(&pose).bounds(&Bounds::new(&aabb));
            for corner in 0..8 {
                let p = [0, 1, 2].map(|k| [aabb.min, aabb.max][corner >> k & 1][k]);
                let p = Vec3A::from_array(pose.apply(p));
                assert!(placed.min.cmple(p).all() && p.cmple(placed.max).all());
            }
        }
    }

    #[test]
    fn refuses_what_cannot_be_posed() {
        let unit = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let mut pose = Pose::IDENTITY;
        pose.rows[1][3] = f32::NAN;
        assert_eq!(pose.check(&unit), Err(PoseError::NonFinite { row: 1, column: 3 }));
        pose.rows[1][3] = f32::MAX;
        assert_eq!(pose.check(&unit), Err(PoseError::Range { row: 1 }));
        assert_eq!(pose.check(&Aabb::EMPTY), Err(PoseError::Range { row: 1 }));
        assert_eq!(Pose::IDENTITY.check(&unit), Ok(()));
        assert_eq!(Pose::IDENTITY.check(&Aabb::EMPTY), Ok(()));
    }
}
