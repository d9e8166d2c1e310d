//! Floats side by side: eight where there are vector registers, else one after the other.

use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Neg, Sub};
use glam::{BVec4A, Vec4};

/// The number of lanes: as many as a leaf may hold triangles.
pub(crate) const LANES: usize = 8;
const _: () = assert!(LANES == crate::bvh::MAX_LEAF_SIZE as usize);

/// Whether the target has vector registers. Without them, a traversal with one lane is faster, since most boxes are
/// separated by the first comparisons, and takes less machine code.
pub(crate) const VECTORS: bool = cfg!(any(
    target_arch = "x86_64",
    target_arch = "aarch64",
    target_feature = "sse2",
    target_feature = "neon",
    target_feature = "simd128",
));

/// A vector of floats. Every operation rounds as that on one float does, and none is fused.
pub(crate) trait Simd:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The number of floats, a divisor of [`LANES`].
    const WIDTH: usize;

    /// A truth value per lane.
    type Mask: BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + BitXor<Output = Self::Mask>;

    fn splat(x: f32) -> Self;
    /// The lanes from `at` on, a multiple of the width.
    fn load(from: &[f32; LANES], at: usize) -> Self;
    fn store(self, to: &mut [f32; LANES], at: usize);
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn le(self, other: Self) -> Self::Mask;
    fn lt(self, other: Self) -> Self::Mask;
    fn eq(self, other: Self) -> Self::Mask;
    fn select(mask: &Self::Mask, yes: Self, no: Self) -> Self;
    /// One bit per lane.
    fn bits(mask: Self::Mask) -> u32;
}

/// Eight floats.
pub(crate) trait Eight: Simd {
    /// The last four lanes, then the first four.
    fn swap_halves(self) -> Self;
}

/// A computation that is compiled for each width of registers.
pub(crate) trait Task {
    type Output;
    fn run<S: Eight>(self) -> Self::Output;
}

#[inline]
pub(crate) fn widest<T: Task>(task: T) -> T::Output {
    #[cfg(all(target_arch = "x86_64", any(feature = "std", target_feature = "avx2")))]
    if super::avx2::is_here() {
        return super::avx2::run(task);
    }
    in_halves(task)
}

/// A function of its own, so that its stack frame does not add to that of wider registers.
#[inline(never)]
fn in_halves<T: Task>(task: T) -> T::Output {
    task.run::<Halves>()
}

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
in_halves!(BitAnd bitand HalfMasks, BitOr bitor HalfMasks, BitXor bitxor HalfMasks);

impl Neg for Halves {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

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
    fn lt(self, other: Self) -> HalfMasks {
        HalfMasks(self.0.cmplt(other.0), self.1.cmplt(other.1))
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

impl Eight for Halves {
    #[inline(always)]
    fn swap_halves(self) -> Self {
        Self(self.1, self.0)
    }
}

/// One lane: most boxes are separated by the first comparisons.
impl Simd for f32 {
    const WIDTH: usize = 1;
    type Mask = bool;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn load(from: &[f32; LANES], at: usize) -> Self {
        from[at % LANES]
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; LANES], at: usize) {
        to[at % LANES] = self;
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(mask: &bool, yes: Self, no: Self) -> Self {
        if *mask { yes } else { no }
    }
    #[inline(always)]
    fn bits(mask: bool) -> u32 {
        u32::from(mask)
    }
}
