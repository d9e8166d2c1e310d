//! Whether all triangles of two blocks are farther apart than a distance, told at once.

use super::block::TriangleBlock;
use super::near::farthest_square;
use super::nearest::UNIT;
use crate::simd::point8::{chunk_starts, difference, dot, load};
use crate::simd::{LANES, Simd};
use glam::Vec3A;

impl TriangleBlock {
    /// Whether all triangles are certainly farther from all of `other` than a distance, along the line through the middles of both:
    /// where these are small beside it, that line is nearly the shortest.
    ///
    /// Heights are taken from one middle. With R the largest coordinate of a corner from there, at most the extent of both, and n the
    /// direction, one is off by less than 8 u |n|₁ R, so that the margin of 64 u leaves room for the difference of two. Squares are
    /// compared, above where they underflow.
    #[inline(always)]
    pub(super) fn is_apart<S: Simd>(
        &self,
        other: &Self,
        distance: f32,
        error: Option<Vec3A>,
    ) -> bool {
        let distance = distance + error.unwrap_or(Vec3A::ZERO).max_element() * 1.733;
        let (a, b) = (&self.bounds, &other.bounds);
        let from = (a.min + a.max) * 0.5;
        let n = (b.min + b.max) * 0.5 - from;
        let extent = (a.max.max(b.max) - a.min.min(b.min)).max_element();
        let own = self.heights::<S>(from, n);
        let others = other.heights::<S>(from, n);
        let end = own.iter().take(self.len).fold(f32::NEG_INFINITY, |m, h| m.max(h[1]));
        let begin = others.iter().take(other.len).fold(f32::INFINITY, |m, h| m.min(h[0]));
        let highest = (n.x.abs() + n.y.abs() + n.z.abs()) * extent;
        let gap = begin - end - 64.0 * UNIT * highest;
        // Heights that overflow are not numbers, and tell nothing.
        let is_finite = highest < f32::MAX * 0.125;
        is_finite
            && gap > 0.0
            && gap * gap > n.length_squared() * farthest_square(distance) + f32::MIN_POSITIVE
    }

    /// The lowest and the highest height of each triangle along `n`, from a point.
    #[inline(always)]
    fn heights<S: Simd>(&self, from: Vec3A, n: Vec3A) -> [[f32; 2]; LANES] {
        let from = [S::splat(from.x), S::splat(from.y), S::splat(from.z)];
        let n = [S::splat(n.x), S::splat(n.y), S::splat(n.z)];
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        for at in chunk_starts::<S>() {
            let p = dot(difference(load::<S>(&self.corners[0], at), from), n);
            let q = dot(difference(load::<S>(&self.corners[1], at), from), n);
            let r = dot(difference(load::<S>(&self.corners[2], at), from), n);
            p.min(q).min(r).store(&mut low, at);
            p.max(q).max(r).store(&mut high, at);
        }
        let mut heights = [[0.0; 2]; LANES];
        for (to, (low, high)) in heights.iter_mut().zip(low.into_iter().zip(high)) {
            *to = [low, high];
        }
        heights
    }
}
