//! The cones of a solid's triangles, added up along trees of its edges.
//!
//! A function of the vertices is added over those that are inside another solid without a visit to any of them. The edges on which
//! a search over the surface first reaches each vertex form trees; each vertex has the sum over the subtree below it. If one gets
//! inside along an edge from a vertex to one that it leads to, the subtree of the latter is added, and if outside, subtracted; with the
//! whole tree if its root is inside, what remains is the sum over the vertices inside. So an edge that is cut adds a term, in any order,
//! and no other is looked at.
//!
//! The function is the cone over the triangles whose last corner the vertex is: the determinant of their corners, six times a
//! volume, and their normals, by which a cone from one point becomes that from another. Both are whole multiples of a unit, so that
//! sums are exact, modulo 2^64 in between.

use super::ball::Ball;
use glam::DVec3;

/// Words for each vertex: the one that leads to it, a sum of cones, and how many triangles these are.
pub(super) const WORDS: usize = 1 + SUM;
pub(super) const SUM: usize = 10;

/// Words for all: the apex and the largest coordinate; units, errors, and the sum of all edges.
pub(super) const HEADER: usize = 2 * 9;

/// The bit of a vertex to which no edge leads: the others are those of the patch from which the tree was begun.
pub(super) const ROOT: u32 = 1 << 31;

/// The sum of some cones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    /// The determinant and the three components of the normals, in their units.
    pub(super) cones: [i64; 4],
    /// How many triangles, and how many of them are marked and have no cone.
    pub(super) counts: [u32; 2],
}

impl Sum {
    /// Adds another so many times.
    pub(super) fn add(&mut self, other: &Self, times: i32) {
        for (own, other) in self.cones.iter_mut().zip(other.cones) {
            *own = own.wrapping_add(other.wrapping_mul(times.into()));
        }
        for (own, other) in self.counts.iter_mut().zip(other.counts) {
            *own = own.wrapping_add(other.wrapping_mul(times as u32));
        }
    }

    pub(super) fn triangles(&self) -> u32 {
        self.counts[0]
    }

    /// Whether a marked triangle is among those added.
    pub(super) fn has_marked(&self) -> bool {
        self.counts[1] != 0
    }

    pub(super) fn read(words: &[u32]) -> Self {
        let cones = [0, 1, 2, 3].map(|i| read_u64(words, 2 * i) as i64);
        Self { cones, counts: [words[8], words[9]] }
    }

    pub(super) fn write(&self, words: &mut [u32]) {
        self.cones.iter().enumerate().for_each(|(i, &x)| write_u64(words, 2 * i, x as u64));
        words[8..SUM].copy_from_slice(&self.counts);
    }
}

fn read_u64(words: &[u32], at: usize) -> u64 {
    u64::from(words[at]) | u64::from(words[at + 1]) << 32
}

fn write_u64(words: &mut [u32], at: usize, x: u64) {
    words[at] = x as u32;
    words[at + 1] = (x >> 32) as u32;
}

/// The frame of all cones of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// The point from which the cones are taken.
    pub(super) apex: DVec3,
    /// The largest coordinate.
    pub(super) farthest: f64,
    /// The unit of the determinants, and of the normals.
    pub(super) units: [f64; 2],
    /// By how much the sums of these may be off for rounding before they became multiples of a unit.
    pub(super) errors: [f64; 2],
    /// The sum of what the edges of all triangles are long along the three axes, those of triangles without an area five times,
    /// since these have no cones, and rounding gives them an area.
    pub(super) edges: f64,
}

impl Frame {
    fn read(words: &[u32]) -> Self {
        let at = |i: usize| f64::from_bits(read_u64(words, 2 * i));
        let apex = DVec3::new(at(0), at(1), at(2));
        Self { apex, farthest: at(3), units: [at(4), at(5)], errors: [at(6), at(7)], edges: at(8) }
    }

    pub(super) fn write(&self, words: &mut [u32]) {
        let [x, y, z] = self.apex.to_array();
        let ([unit, area], [error, areas]) = (self.units, self.errors);
        let all = [x, y, z, self.farthest, unit, area, error, areas, self.edges];
        all.iter().enumerate().for_each(|(i, x)| write_u64(words, 2 * i, x.to_bits()));
    }

    /// The area of all triangles, or more.
    pub(super) fn area(&self) -> f64 {
        // A triangle's is half its normal, at most 0.87 of the largest component.
        0.87 * self.units[1] * ONE
    }

    /// The determinant and the normals of a sum.
    pub(super) fn balls(&self, sum: &Sum) -> (Ball, [Ball; 3]) {
        let many = f64::from(sum.counts[0]);
        let ball = |cone: i64, i: usize| {
            // Each cone was cut to a multiple of the unit, and the sum is rounded once.
            let middle = cone as f64 * self.units[i];
            let radius = many * self.units[i] + middle.abs() * f64::EPSILON;
            Ball::new(middle, if many == 0.0 { 0.0 } else { radius + self.errors[i] })
        };
        let [all, normals @ ..] = sum.cones;
        (ball(all, 0), normals.map(|cone| ball(cone, 1)))
    }
}

/// The trees of a solid, and the sums of their cones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cones<'a>(pub(super) &'a [u32]);

impl Cones<'_> {
    pub(super) fn frame(&self) -> Frame {
        Frame::read(self.0)
    }

    fn of_vertex(&self, vertex: u32) -> &[u32] {
        &self.0[HEADER + WORDS * vertex as usize..][..WORDS]
    }

    /// The sum over a whole tree, if it begins with a vertex of the triangle of a patch.
    pub(super) fn of_tree(&self, vertex: u32, patch: u32) -> Option<Sum> {
        let words = self.of_vertex(vertex);
        (words[0] == ROOT | patch).then(|| Sum::read(&words[1..]))
    }

    /// Adds what it means that one gets so many times inside along an edge.
    pub(super) fn step(&self, from: u32, to: u32, times: i32, sum: &mut Sum) {
        let (own, other) = (self.of_vertex(from), self.of_vertex(to));
        if other[0] == from {
            sum.add(&Sum::read(&other[1..]), times);
        } else if own[0] == to {
            sum.add(&Sum::read(&own[1..]), -times);
        }
    }
}

/// 2^62.
const ONE: f64 = (1_u64 << 62) as f64;

/// A power of two, less than 2^62 of which are so much.
pub(super) fn unit_of(total: f64) -> f64 {
    let exponent = (total.to_bits() >> 52).clamp(62, 0x7FE);
    f64::from_bits((exponent - 61) << 52)
}
