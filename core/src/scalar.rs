//! The coordinates of positions and poses: f32 or f64.

use glam::DVec3;

/// Whether meshes and poses in f64 can be made. Without the feature, what only they need is left out of the program.
pub(crate) const IN_F64: bool = cfg!(feature = "f64");

/// The largest position in f64 that a mesh may have, and a pose may lead to: 2^125. Positions in f32 that are decided in f64,
/// unposed, reach up to 2^128; filters and integers have room for them.
pub(crate) const LIMIT: f64 = 42_535_295_865_117_307_932_921_825_928_971_026_432.0;

/// A coordinate: a finite f32, or an f64 of at most [`LIMIT`].
pub(crate) trait Scalar: Copy + PartialOrd + From<f32> + Into<f64> {
    /// The nearest point.
    fn point(p: DVec3) -> [Self; 3];
}

impl Scalar for f32 {
    fn point(p: DVec3) -> [Self; 3] {
        p.as_vec3().to_array()
    }
}

impl Scalar for f64 {
    fn point(p: DVec3) -> [Self; 3] {
        p.to_array()
    }
}
