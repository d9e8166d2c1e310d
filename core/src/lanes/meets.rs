//! One triangle pair in f32, where that is sure of the answer: hits, mostly, since
//! [`Block::pairs`] has rejected nearly all that miss.
//!
//! The test is that of [`crate::triangle`], its corners side by side in lanes, with the bound of
//! [`super::apart`]. Where a sign is not sure, the pair is left to the exact test.

use super::apart::{BOUND, MOST, SLACK};
use super::block::Block;
use crate::triangle::{lone_corner, one_sided};
use glam::Vec4;

impl Block {
    /// Whether triangle `i` of these meets `j` of others, if f32 knows. They must share no vertex.
    #[inline]
    pub(crate) fn meets(&self, i: usize, others: &Self, j: usize) -> Option<bool> {
        let a_sides = others.sides_of(j, self, i)?;
        let b_sides = self.sides_of(i, others, j)?;
        if one_sided(&a_sides) || one_sided(&b_sides) {
            return Some(false);
        }
        // See `triangle::cross` for why these two signs decide.
        let (p, delta) = lone_corner(&a_sides);
        let (q, epsilon) = lone_corner(&b_sides);
        let (a1, a2) = ((p + 1) % 3, (p + 2) % 3);
        let (mut b1, mut b2) = ((q + 1) % 3, (q + 2) % 3);
        if delta != epsilon {
            (b1, b2) = (b2, b1);
        }
        let (mut v, mut from_p) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3]);
        for k in 0..3 {
            let (a, b) = (|c| self.at(c, k, i), |c| others.at(c, k, j));
            let base = Vec4::splat(a(p));
            v[k] = Vec4::splat(b(q)) - base;
            from_p[k] = Vec4::new(a(a1), a(a2), b(b1), b(b2)) - base;
        }
        // det(a1 − p, q − p, b1 − p) and the same with a2 and b2, in the first two lanes.
        let u = from_p;
        let w = [swapped(u[0]), swapped(u[1]), swapped(u[2])];
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let extent = |k: usize| u[k].abs().max(v[k].abs()).max(w[k].abs());
        let (above, below) = signs(&normal, &w, [extent(0), extent(1), extent(2)]);
        let sign = |lane: u32| (above >> lane & 1) as i32 - (below >> lane & 1) as i32;
        match (sign(0) * epsilon, sign(1) * epsilon) {
            (1, _) | (_, -1) => Some(false),
            (0, _) | (_, 0) => None,
            _ => Some(true),
        }
    }

    /// The sides of the plane of triangle `i` of these on which the corners of `j` of others lie, if all
    /// are surely on one.
    #[inline]
    fn sides_of(&self, i: usize, others: &Self, j: usize) -> Option<[i32; 3]> {
        let (mut w, mut extent, mut normal) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3], [Vec4::ZERO; 3]);
        for k in 0..3 {
            let at = |c| others.at(c, k, j);
            w[k] = Vec4::new(at(0), at(1), at(2), at(0)) - Vec4::splat(self.at(0, k, i));
            extent[k] = Vec4::splat(self.extent[k][i]).max(w[k].abs());
            normal[k] = Vec4::splat(self.normal[k][i]);
        }
        let (above, below) = signs(&normal, &w, extent);
        let side = |corner: u32| 2 * (above >> corner & 1) as i32 - 1;
        (above | below == 0xf).then_some([side(0), side(1), side(2)])
    }

    #[inline]
    fn at(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self.corners[corner][axis][lane]
    }
}

/// Bits for the lanes in which the determinant is surely positive, and surely negative.
#[inline]
fn signs(normal: &[Vec4; 3], w: &[Vec4; 3], extent: [Vec4; 3]) -> (u32, u32) {
    let determinant = normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2];
    let bound = extent[0] * extent[1] * extent[2] * BOUND + Vec4::splat(SLACK);
    let sure = extent[0].max(extent[1]).max(extent[2]).cmple(Vec4::splat(MOST));
    ((determinant.cmpgt(bound) & sure).bitmask(), (determinant.cmplt(-bound) & sure).bitmask())
}

/// The two halves the other way round.
#[inline]
fn swapped(v: Vec4) -> Vec4 {
    glam::Vec4Swizzles::zwxy(v)
}
