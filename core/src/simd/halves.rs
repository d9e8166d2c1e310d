//! Eight floats in two vectors of four, for processors without AVX2.

use super::lanes::{LANES, Simd};
use core::ops::{Add, BitAnd, BitOr, Mul, Sub};
use glam::{BVec4A, Vec4};

/// Two of glam's `Vec4`, which is SSE2, NEON or wasm's simd128 where the target has it and plain floats
/// elsewhere.
#[derive(Clone, Copy)]
pub(crate) struct Halves(Vec4, Vec4);

/// Truth values of [`Halves`]: the masks of glam's `Vec4`, unless its feature `scalar-math` is on.
#[derive(Clone, Copy)]
pub(crate) struct HalfMasks(BVec4A, BVec4A);

macro_rules! in_halves {
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

in_halves!(Add add Halves, Sub sub Halves, Mul mul Halves);
in_halves!(BitAnd bitand HalfMasks, BitOr bitor HalfMasks);

impl Simd for Halves {
    const WIDTH: usize = LANES;
    type Mask = HalfMasks;

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
    fn le(self, other: Self) -> HalfMasks {
        HalfMasks(self.0.cmple(other.0), self.1.cmple(other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> HalfMasks {
        HalfMasks(self.0.cmpeq(other.0), self.1.cmpeq(other.1))
    }
    #[inline(always)]
    fn select(mask: &HalfMasks, yes: Self, no: Self) -> Self {
        Self(Vec4::select(mask.0, yes.0, no.0), Vec4::select(mask.1, yes.1, no.1))
    }
    #[inline(always)]
    fn bits(mask: HalfMasks) -> u32 {
        mask.0.bitmask() | mask.1.bitmask() << 4
    }
}
