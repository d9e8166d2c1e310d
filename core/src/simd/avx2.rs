//! Eight floats in one register, where the processor has AVX2.
//!
//! The one module of this crate with `unsafe`: safe Rust cannot use wide registers that are detected at run time, and
//! compilers find no masks in loops over arrays. `benches/record` has what it gains.
//!
//! A closure is not compiled for the features of the function that it is in, and calls of intrinsics from
//! one stay calls. So code over [`Simd`] is written in functions marked `#[inline(always)]`, all of
//! which end up in [`with_features`].

#![expect(unsafe_code, reason = "calls intrinsics that need a feature found at run time")]

use super::lanes::{LANES, Simd, Task};
use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// Whether [`run`] may be called. Without `std` that is settled when compiling.
#[inline]
pub(super) fn is_here() -> bool {
    #[cfg(feature = "std")]
    {
        std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("bmi1")
            && std::is_x86_feature_detected!("popcnt")
    }
    #[cfg(not(feature = "std"))]
    {
        cfg!(all(target_feature = "avx2", target_feature = "bmi1", target_feature = "popcnt"))
    }
}

/// Does a task in [`Avx`].
///
/// # Panics
/// If not [`is_here`].
#[inline]
pub(super) fn run<T: Task>(task: T) -> T::Output {
    assert!(is_here(), "no AVX2");
    // SAFETY: the features are there, as just seen.
    unsafe { with_features(task) }
}

#[target_feature(enable = "avx2,bmi1,popcnt")]
fn with_features<T: Task>(task: T) -> T::Output {
    task.run::<Avx>()
}

/// Eight floats. Only [`with_features`] makes any: the type is private to this module otherwise, and a
/// task can name it only as the [`Simd`] it is given.
#[derive(Clone, Copy)]
struct Avx(__m256);

/// All bits of a lane, or none.
#[derive(Clone, Copy)]
struct Mask(__m256);

/// Calls an intrinsic on the registers of its arguments.
macro_rules! call {
    ($intrinsic:ident$(::<$constant:ident>)?($($of:expr),*)) => {
        // SAFETY: `Avx` and `Mask` exist only below `with_features`, so AVX2 is there; the intrinsics
        // used here ask for nothing else.
        unsafe { $intrinsic$(::<$constant>)?($($of),*) }
    };
}

macro_rules! operators {
    ($($trait:ident $method:ident $of:ident $intrinsic:ident),*) => {$(
        impl $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(call!($intrinsic(self.0, other.0)))
            }
        }
    )*};
}

operators!(Add add Avx _mm256_add_ps, Sub sub Avx _mm256_sub_ps);
operators!(Mul mul Avx _mm256_mul_ps, Div div Avx _mm256_div_ps);
operators!(BitAnd bitand Mask _mm256_and_ps, BitOr bitor Mask _mm256_or_ps);

impl Simd for Avx {
    const WIDTH: usize = LANES;
    type Mask = Mask;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(call!(_mm256_set1_ps(x)))
    }
    #[inline(always)]
    fn load(from: &[f32; LANES], _: usize) -> Self {
        Self(bytemuck::must_cast(*from))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; LANES], _: usize) {
        *to = bytemuck::must_cast(self.0);
    }
    #[inline(always)]
    fn pick(from: &[f32; LANES], places: u64, at: usize) -> Self {
        let places = call!(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(places.cast_signed())));
        Self(call!(_mm256_permutevar8x32_ps(Self::load(from, at).0, places)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(call!(_mm256_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(call!(_mm256_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(call!(_mm256_andnot_ps(Self::splat(-0.0).0, self.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask {
        Mask(call!(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Mask {
        Mask(call!(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn select(mask: &Mask, yes: Self, no: Self) -> Self {
        Self(call!(_mm256_blendv_ps(no.0, yes.0, mask.0)))
    }
    #[inline(always)]
    fn bits(mask: Mask) -> u32 {
        call!(_mm256_movemask_ps(mask.0)).cast_unsigned()
    }
}
