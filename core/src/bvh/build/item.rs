//! The scratch of the SAH build: triangles with their boxes, laid out for vector registers.

use crate::aabb::Bounds;
use crate::simd::{LANES, Simd};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3A, Vec4};

/// A box in eight lanes: the smallest corner and the largest one negated, so that a union is one minimum. The fourth
/// lane and the eighth are free.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct LaneBox(pub(super) [f32; LANES]);

impl LaneBox {
    pub(super) const EMPTY: Self = Self([f32::INFINITY; LANES]);

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        let [[a, b], [c, d]]: [[Vec4; 2]; 2] = [self.0, other.0].map(bytemuck::must_cast);
        Self(bytemuck::must_cast([a.min(c), b.min(d)]))
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        let [min, negated_max]: [Vec4; 2] = bytemuck::must_cast(self.0);
        Bounds { min: Vec3A::from_vec4(min), max: Vec3A::from_vec4(-negated_max) }
    }
}

/// Scratch of [`sah()`](super::sah()): a triangle and its box.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct SahItem(pub(super) LaneBox);

impl SahItem {
    /// Arithmetic runs over all eight lanes, and is slow on subnormal numbers, which the bits of an index would be. So
    /// each half of the index is a number of its own.
    #[inline(always)]
    pub(super) fn new(triangle: u32, bounds: &Bounds) -> Self {
        let (low, high) = ((triangle & 0xffff) as f32, (triangle >> 16) as f32);
        Self(LaneBox(bytemuck::must_cast([bounds.min.extend(low), (-bounds.max).extend(high)])))
    }

    pub(super) fn triangle(&self) -> u32 {
        (self.0.0[7] as u32) << 16 | self.0.0[3] as u32
    }

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self) -> S {
        S::load(&self.0.0, 0)
    }

    /// Half the centre of the box, so that neither it nor the difference of two can overflow. Rounded as in [`centre`].
    pub(super) fn centre(&self, axis: usize) -> f32 {
        self.0.0[axis] * 0.25 - self.0.0[4 + axis] * 0.25
    }
}

/// [`SahItem::centre`] of an item in lanes, and its negation in the upper half: a [`LaneBox`].
#[inline(always)]
pub(super) fn centre<S: Simd>(item: S) -> S {
    let quarter = item * S::splat(0.25);
    quarter - quarter.swap_halves()
}
