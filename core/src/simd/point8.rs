//! Eight points: all x, all y, all z.

use super::lanes::{LANES, Simd};

/// Eight points in memory.
pub(crate) type Points = [[f32; LANES]; 3];

/// The first lane of each vector of `S`.
#[inline(always)]
pub(crate) fn chunk_starts<S: Simd>() -> impl Iterator<Item = usize> {
    (0..LANES / S::WIDTH).map(|i| i * S::WIDTH)
}

#[inline(always)]
pub(crate) fn load<S: Simd>(p: &Points, at: usize) -> [S; 3] {
    [S::load(&p[0], at), S::load(&p[1], at), S::load(&p[2], at)]
}

#[inline(always)]
pub(crate) fn pick<S: Simd>(p: &Points, places: u64, at: usize) -> [S; 3] {
    [S::pick(&p[0], places, at), S::pick(&p[1], places, at), S::pick(&p[2], places, at)]
}

#[inline(always)]
pub(crate) fn splat<S: Simd>(p: &Points, lane: usize) -> [S; 3] {
    [S::splat(p[0][lane]), S::splat(p[1][lane]), S::splat(p[2][lane])]
}

#[inline(always)]
pub(crate) fn store<S: Simd>(from: [S; 3], to: &mut Points, at: usize) {
    for k in 0..3 {
        from[k].store(&mut to[k], at);
    }
}

#[inline(always)]
pub(crate) fn difference<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
pub(crate) fn sum<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0] + q[0], p[1] + q[1], p[2] + q[2]]
}

#[inline(always)]
pub(crate) fn lowest<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0].min(q[0]), p[1].min(q[1]), p[2].min(q[2])]
}

#[inline(always)]
pub(crate) fn highest<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[0].max(q[0]), p[1].max(q[1]), p[2].max(q[2])]
}

#[inline(always)]
pub(crate) fn abs<S: Simd>(p: [S; 3]) -> [S; 3] {
    [p[0].abs(), p[1].abs(), p[2].abs()]
}

#[inline(always)]
pub(crate) fn dot<S: Simd>(p: [S; 3], q: [S; 3]) -> S {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline(always)]
pub(crate) fn cross<S: Simd>(p: [S; 3], q: [S; 3]) -> [S; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

#[inline(always)]
pub(crate) fn select<S: Simd>(mask: &S::Mask, yes: [S; 3], no: [S; 3]) -> [S; 3] {
    let mut out = no;
    for k in 0..3 {
        out[k] = S::select(mask, yes[k], no[k]);
    }
    out
}
