//! Numbers that are known within a radius.

use core::ops::{Add, Mul, Sub};

/// All numbers at most `radius` from `middle`. Sums and products contain those of all numbers of both; radii are rounded
/// up by more than f64 rounds them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ball {
    pub(super) middle: f64,
    pub(super) radius: f64,
}

/// 2^-53, by which a result is rounded.
const UNIT: f64 = f64::EPSILON * 0.5;

/// 1 + 2^-48: radii are sums of few products.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

impl Ball {
    pub(super) fn new(middle: f64, radius: f64) -> Self {
        Self { middle, radius }
    }

    /// A result that was rounded, of operands with so large an error.
    fn rounded(middle: f64, error: f64) -> Self {
        Self { middle, radius: (error + middle.abs() * UNIT) * UP + f64::MIN_POSITIVE }
    }
}

impl Add for Ball {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::rounded(self.middle + other.middle, self.radius + other.radius)
    }
}

impl Sub for Ball {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::rounded(self.middle - other.middle, self.radius + other.radius)
    }
}

impl Mul for Ball {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let error = self.middle.abs() * other.radius
            + other.middle.abs() * self.radius
            + self.radius * other.radius;
        Self::rounded(self.middle * other.middle, error)
    }
}

/// u × v.
pub(super) fn cross(u: &[Ball; 3], v: &[Ball; 3]) -> [Ball; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| u[i] * v[j] - u[j] * v[i])
}

/// p · q.
pub(super) fn dot(p: &[Ball; 3], q: &[Ball; 3]) -> Ball {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

/// det(p, q, r).
pub(super) fn determinant([p, q, r]: &[[Ball; 3]; 3]) -> Ball {
    dot(p, &cross(q, r))
}
