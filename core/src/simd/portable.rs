//! Eight floats in two vectors of four, on any processor: used where AVX2 is not detected.

use super::lanes::{LANES, Simd};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};
use glam::{BVec4A, Vec4};

/// Two of glam's `Vec4`, which is SSE2, NEON or wasm's simd128 where the target has it and plain floats
/// elsewhere.
#[derive(Clone, Copy)]
pub(crate) struct Portable(Vec4, Vec4);

/// Truth values of [`Portable`]: the masks of glam's `Vec4`, unless its feature `scalar-math` is on.
#[derive(Clone, Copy)]
pub(crate) struct PortableMask(BVec4A, BVec4A);

macro_rules! impl_by_halves {
    ($($trait:ident $method:ident $of:ty),*) => {$(
        impl $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($trait::$method(self.0, other.0), $trait::$method(self.1, other.1))
            }
        }
    )*};
}

impl_by_halves!(Add add Portable, Sub sub Portable, Mul mul Portable, Div div Portable);
impl_by_halves!(BitAnd bitand PortableMask, BitOr bitor PortableMask);

impl Simd for Portable {
    const WIDTH: usize = LANES;
    type Mask = PortableMask;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(Vec4::splat(x), Vec4::splat(x))
    }
    #[inline(always)]
    fn load(from: &[f32; LANES], _: usize) -> Self {
        let [a, b, c, d, e, f, g, h] = *from;
        Self(Vec4::new(a, b, c, d), Vec4::new(e, f, g, h))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; LANES], _: usize) {
        let ([a, b, c, d], [e, f, g, h]) = (self.0.to_array(), self.1.to_array());
        *to = [a, b, c, d, e, f, g, h];
    }
    #[inline(always)]
    fn pick(from: &[f32; LANES], places: u64, at: usize) -> Self {
        let picked = places.to_le_bytes().map(|place| from[place as usize % LANES]);
        Self::load(&picked, at)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn le(self, other: Self) -> PortableMask {
        PortableMask(self.0.cmple(other.0), self.1.cmple(other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> PortableMask {
        PortableMask(self.0.cmpeq(other.0), self.1.cmpeq(other.1))
    }
    #[inline(always)]
    fn select(mask: &PortableMask, yes: Self, no: Self) -> Self {
        Self(Vec4::select(mask.0, yes.0, no.0), Vec4::select(mask.1, yes.1, no.1))
    }
    #[inline(always)]
    fn bits(mask: PortableMask) -> u32 {
        mask.0.bitmask() | mask.1.bitmask() << 4
    }
}
