//! The coordinates of positions and poses: f32 or f64.

use core::ops::{Add, Mul};
use glam::DVec3;

/// Whether meshes and poses in f64 can be made. Without the feature, what only they need is left out of the program.
pub(crate) const IN_F64: bool = cfg!(feature = "f64");

/// Whether queries within a distance can be made. Without the feature, what only they need is left out of the program.
pub(crate) const WITHIN: bool = cfg!(feature = "within");

/// The largest position in f64 that a mesh may have, and a pose may lead to: 2^125. Positions in f32 that are decided in f64,
/// unposed, reach up to 2^128; filters and integers have room for them.
pub(crate) const LIMIT: f64 = 42_535_295_865_117_307_932_921_825_928_971_026_432.0;

/// A coordinate: f32 or f64.
#[expect(private_bounds, reason = "sealed: what is done with coordinates is internal")]
pub trait Scalar: Real {}

impl<S: Real> Scalar for S {}

/// A finite f32, or an f64 of at most [`LIMIT`], and what is done with it.
pub(crate) trait Real:
    Copy + PartialOrd + From<f32> + Into<f64> + Add<Output = Self> + Mul<Output = Self>
{
    const ZERO: Self;
    const ONE: Self;

    fn nearest(x: f64) -> Self;

    fn abs(self) -> Self;

    /// The nearest point.
    fn point(p: DVec3) -> [Self; 3];
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    fn nearest(x: f64) -> Self {
        x as Self
    }

    fn abs(self) -> Self {
        self.abs()
    }

    fn point(p: DVec3) -> [Self; 3] {
        p.as_vec3().to_array()
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    fn nearest(x: f64) -> Self {
        x
    }

    fn abs(self) -> Self {
        self.abs()
    }

    fn point(p: DVec3) -> [Self; 3] {
        p.to_array()
    }
}
