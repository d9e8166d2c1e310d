//! Pairs of moving triangles side by side in lanes, each from one certificate that they are apart to the next: the steps of
//! [`motion`](crate::motion) as far as f32 certifies them.
//!
//! Pairs of all leaf pairs are gathered until every lane has one. At a time of its own in each lane near points of both are found, and the
//! direction from one to the other separates them up to another time; a pair is apart if that is the end. Pairs that stall, or come near, are left open.
//!
//! # The bound
//! Coordinates are taken from a corner of the pair, scaled by a power of two; let R be the largest of the pair at either end, and 2^-20 at least,
//! and u = 2^-24. A height along n is off by 4 u |n|₁ R, and the difference of two, at most 2 |n|₁ R, by 10 u |n|₁ R. The line between two ends as it
//! is evaluated at a time is off by 3 u of 2 |n|₁ R, and its root, with three roundings, is so late that the line has lost as much there: 22 u
//! in all, and the margin is 48 u. Underflow takes far less than the smallest normal number, which is added. Within a distance d, heights have to exceed
//! d |n| as well, and the root loses no more, for the height less the margin is no greater than the height.

use super::TrianglePair;
use super::moving::MovingBlock;
use super::near::{Group, scale};
use super::nearest::{LEAST, MOST, UNIT, between, relative};
use super::planes::longest;
use crate::simd::point8::{abs, chunk_starts, dot, highest, load};
use crate::simd::{LANES, Simd, Task, VECTORS, widest};

/// The margin of heights.
const MARGIN: f32 = 48.0 * UNIT;

/// A policy: what has not ended after so many steps is left open.
const STEPS: usize = 4;

/// As many pairs as there are lanes, at the start and at the end, and the distance within which they may be.
pub(crate) struct MovingGroup {
    ends: [Group; 2],
    scale: [f32; LANES],
    distance: f32,
    pairs: [TrianglePair; LANES],
}

impl MovingGroup {
    #[inline(always)]
    pub(crate) fn new(distance: f32) -> Self {
        let ends = [Group::new(), Group::new()];
        Self { ends, scale: [1.0; LANES], distance, pairs: [TrianglePair::default(); LANES] }
    }

    /// Whether every lane has a pair.
    pub(crate) fn is_full(&self) -> bool {
        self.ends[0].len == LANES
    }

    /// Takes pairs of two blocks until every lane has one. Returns those that are left.
    #[inline(always)]
    pub(crate) fn gather(&mut self, a: MovingBlock<'_>, b: MovingBlock<'_>, pairs: u64) -> u64 {
        let (first, mut left, mut least) = (self.ends[0].len, 0, f32::INFINITY);
        for (group, (a, b)) in self.ends.iter_mut().zip(a.0.into_iter().zip(b.0)) {
            least = least.min(scale(&a.bounds, &b.bounds));
            left = group.gather(a, b, pairs);
        }
        for lane in first..self.ends[0].len {
            let bit = self.ends[0].bits[lane] as usize;
            (self.scale[lane], self.pairs[lane]) = (least, a.pair(b, [bit, bit / LANES]));
        }
        left
    }

    /// Takes all pairs out. Returns them, and as bits those that are not certainly apart all the time.
    pub(crate) fn flush(&mut self) -> ([TrianglePair; LANES], u32) {
        let open = if VECTORS { widest(&*self) } else { (&*self).run::<f32>() };
        let open = open & ((1 << self.ends[0].len) - 1);
        self.ends.iter_mut().for_each(|group| group.len = 0);
        (self.pairs, open)
    }

    /// Lanes from `at` on whose pairs are not certainly apart.
    #[inline(always)]
    fn open<S: Simd>(&self, at: usize) -> u32 {
        let scale = S::load(&self.scale, at);
        let (mut extent, zero, one) = ([S::splat(LEAST); 3], S::splat(0.0), S::splat(1.0));
        let mut ends = [[[[zero; 3]; 3]; 2]; 2];
        for (to, Group { corners, .. }) in ends.iter_mut().zip(&self.ends) {
            let origin = load::<S>(&corners[0][0], at);
            for side in 0..2 {
                for corner in 0..3 {
                    let p = relative(load::<S>(&corners[side][corner], at), origin, scale);
                    extent = highest(extent, abs(p));
                    to[side][corner] = p;
                }
            }
        }
        let extent = extent[0].max(extent[1]).max(extent[2]);
        let (mut time, mut left) = (zero, S::bits(zero.le(zero)));
        for _ in 0..STEPS {
            let after = one - time;
            let [mut a, mut b] = ends[0];
            for corner in 0..3 {
                for axis in 0..3 {
                    let (x, y) = (&mut a[corner][axis], &mut b[corner][axis]);
                    *x = *x * after + ends[1][0][corner][axis] * time;
                    *y = *y * after + ends[1][1][corner][axis] * time;
                }
            }
            // From the second to the first.
            let z = between(&a, &b);
            let size = abs(z)[0] + abs(z)[1] + abs(z)[2];
            let mut margin = size * extent * S::splat(MARGIN) + S::splat(f32::MIN_POSITIVE);
            if self.distance > 0.0 {
                margin =
                    margin + longest(z) * (S::splat(self.distance) * scale) * S::splat(1.000_001);
            }
            let (mut of_start, mut of_end) = ([[zero; 3]; 2], [[zero; 3]; 2]);
            for side in 0..2 {
                for corner in 0..3 {
                    of_start[side][corner] = dot(z, ends[0][side][corner]);
                    of_end[side][corner] = dot(z, ends[1][side][corner]);
                }
            }
            let mut until = one;
            let mut holds = extent.le(S::splat(MOST));
            for i in 0..3 {
                for j in 0..3 {
                    let start = of_start[0][i] - of_start[1][j];
                    let end = of_end[0][i] - of_end[1][j];
                    let (above, stays) = (margin.le(start), margin.le(end));
                    let now = margin.le(start * after + end * time);
                    // Above at the end, it has to be so now; else it is until the line falls to the margin.
                    let root = (start - margin) / (start - end);
                    let root = S::select(&above, root, zero);
                    holds = holds & (above | stays & now);
                    until = S::select(&stays, until, until.min(root));
                }
            }
            let until = S::select(&holds, until, zero);
            let goes_on = S::bits(until.le(time)) ^ u32::MAX;
            left &= S::bits(one.le(until)) ^ u32::MAX;
            time = time.max(until.min(one));
            if left & goes_on == 0 {
                break;
            }
        }
        left
    }
}

/// A task of its own, so that it is there once in each traversal.
impl Task for &MovingGroup {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self) -> u32 {
        let mut open = 0;
        for at in chunk_starts::<S>().take_while(|at| *at < self.ends[0].len) {
            open |= self.open::<S>(at) << at;
        }
        open
    }
}
