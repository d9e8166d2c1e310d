//! A vector of floats, and code that is compiled for several kinds of vectors.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// The number of lanes: as many as a leaf may hold triangles.
pub(crate) const LANES: usize = 8;

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
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The number of floats, a divisor of [`LANES`].
    const WIDTH: usize;

    /// A truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    fn splat(x: f32) -> Self;
    /// The lanes from `at` on, a multiple of the width.
    fn load(from: &[f32; LANES], at: usize) -> Self;
    fn store(self, to: &mut [f32; LANES], at: usize);
    /// For each lane from `at` on, the float at its place: the lowest three bits of a byte of `places`.
    fn pick(from: &[f32; LANES], places: u64, at: usize) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn le(self, other: Self) -> Self::Mask;
    fn eq(self, other: Self) -> Self::Mask;
    fn select(mask: &Self::Mask, yes: Self, no: Self) -> Self;
    /// One bit per lane.
    fn bits(mask: Self::Mask) -> u32;
}

/// A computation that is compiled for each width of registers.
pub(crate) trait Task {
    type Output;
    fn run<S: Simd>(self) -> Self::Output;
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
    fn pick(from: &[f32; LANES], places: u64, at: usize) -> Self {
        from[(places >> (8 * at)) as usize % LANES]
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
