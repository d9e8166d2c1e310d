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

use super::Solid;
use super::ball::{Ball, cross, dot};
use super::fans::{Bits, fan};
use super::solid::DEGENERATE;
use glam::DVec3;

/// Words for each vertex: the one that leads to it, a sum of cones, and how many triangles these are.
pub(super) const WORDS: usize = 1 + SUM;
const SUM: usize = 10;

/// Words for all: the apex and the largest coordinate; units, errors, and the sum of all edges.
pub(super) const HEADER: usize = 2 * 9;

/// The bit of a vertex to which no edge leads: the others are those of the patch from which the tree was begun.
pub(super) const ROOT: u32 = 1 << 31;

/// The sum of some cones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    /// The determinant and the three components of the normals, in their units.
    cones: [i64; 4],
    /// How many triangles, and how many of them are marked and have no cone.
    counts: [u32; 2],
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

    fn read(words: &[u32]) -> Self {
        let cones = [0, 1, 2, 3].map(|i| read_u64(words, 2 * i) as i64);
        Self { cones, counts: [words[8], words[9]] }
    }

    fn write(&self, words: &mut [u32]) {
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

/// What holds for all cones of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// The point from which the cones are taken.
    pub(super) apex: DVec3,
    /// The largest coordinate.
    pub(super) farthest: f64,
    /// Those of the determinants and of the normals.
    units: [f64; 2],
    /// By how much the sums of these may be off for rounding before they became multiples of a unit.
    errors: [f64; 2],
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

    fn write(&self, words: &mut [u32]) {
        let [x, y, z] = self.apex.to_array();
        let ([unit, area], [error, areas]) = (self.units, self.errors);
        let all = [x, y, z, self.farthest, unit, area, error, areas, self.edges];
        all.iter().enumerate().for_each(|(i, x)| write_u64(words, 2 * i, x.to_bits()));
    }

    /// The area of all triangles, or more.
    pub(super) fn area(&self) -> f64 {
        // That of a triangle is half its normal, at most 0.87 of the largest component of that.
        0.87 * self.units[1] * ONE
    }

    /// The sum of one triangle.
    fn sum_of(&self, solid: &Solid<'_>, triangle: u32) -> Sum {
        let facing = solid.facing(triangle);
        if solid.is_marked(triangle) {
            return Sum { counts: [0, 1], ..Sum::default() };
        }
        let (determinant, normal) = cone(&solid.bvh().mesh().triangle_f64(triangle), self.apex);
        let cut = |ball: Ball, i: usize| (ball.middle / self.units[i]) as i64 * i64::from(facing);
        let [x, y, z] = normal.map(|component| cut(component, 1));
        Sum { cones: [cut(determinant, 0), x, y, z], counts: [u32::from(facing != 0), 0] }
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

/// The determinant of the corners of a triangle seen from an apex, and its normal.
fn cone(corners: &[[f64; 3]; 3], apex: DVec3) -> (Ball, [Ball; 3]) {
    let ball = |x: f64| Ball::new(x, x.abs() * f64::EPSILON);
    let [p, q, r] = corners.map(DVec3::from_array);
    let [from, u, v] = [p - apex, q - p, r - p].map(|x| x.to_array().map(ball));
    let normal = cross(&u, &v);
    (dot(&from, &normal), normal)
}

/// 2^62.
const ONE: f64 = (1_u64 << 62) as f64;

/// A power of two, less than 2^62 of which are so much.
fn unit_of(total: f64) -> f64 {
    let exponent = (total.to_bits() >> 52).clamp(62, 0x7FE);
    f64::from_bits((exponent - 61) << 52)
}

/// Writes the cones of a solid, all of which is known but them. The order has a word for each vertex, the queue one for each triangle;
/// visited are bits of triangles.
pub(super) fn write_cones(
    solid: &Solid<'_>,
    words: &mut [u32],
    [order, queue]: [&mut [u32]; 2],
    visited: &mut Bits<'_>,
) {
    let (frame, vertices) = (measured(solid), &mut words[HEADER..]);
    vertices.fill(0);
    for triangle in triangles_of(solid) {
        let last = solid.corners()[triangle as usize][2];
        let words = &mut vertices[WORDS * last as usize + 1..][..SUM];
        let mut sum = Sum::read(words);
        sum.add(&frame.sum_of(solid, triangle), 1);
        sum.write(words);
    }
    let reached = grow(solid, vertices, [order, queue], visited);
    for &vertex in order[..reached].iter().rev() {
        let [below, above] =
            [vertex, vertices[WORDS * vertex as usize]].map(|vertex| WORDS * vertex as usize + 1);
        let mut sum = Sum::read(&vertices[above..]);
        sum.add(&Sum::read(&vertices[below..]), 1);
        sum.write(&mut vertices[above..]);
    }
    frame.write(words);
}

/// Triangles with an area.
fn triangles_of(solid: &Solid<'_>) -> impl Iterator<Item = u32> {
    let solid = *solid;
    (0..solid.corners().len() as u32).filter(move |&t| solid.patch_of(t) != DEGENERATE)
}

/// The frame in which the cones of a solid are taken.
fn measured(solid: &Solid<'_>) -> Frame {
    let mesh = solid.bvh().mesh();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let corners = |triangle| mesh.triangle_f64(triangle).map(DVec3::from_array);
    for p in triangles_of(solid).flat_map(corners) {
        (low, high) = (low.min(p), high.max(p));
    }
    let apex = low * 0.5 + high * 0.5;
    let farthest = low.abs().max(high.abs()).max_element();
    let (mut totals, mut errors, mut edges) = ([0.0; 2], [0.0; 2], 0.0);
    for triangle in 0..solid.corners().len() as u32 {
        let [p, q, r] = corners(triangle);
        let around = [q - p, r - q, p - r].iter().map(|edge| edge.abs().element_sum()).sum::<f64>();
        if solid.patch_of(triangle) == DEGENERATE {
            edges += 5.0 * around;
            continue;
        }
        edges += around;
        let (determinant, normals) = cone(&mesh.triangle_f64(triangle), apex);
        let most = |x: f64, ball: Ball| if x < ball.middle.abs() { ball.middle.abs() } else { x };
        totals[0] += determinant.middle.abs();
        totals[1] += normals.into_iter().fold(0.0, most);
        errors[0] += determinant.radius;
        errors[1] += normals.iter().fold(0.0, |error: f64, normal| error + normal.radius);
    }
    // Sums of n positive numbers are rounded by less than n u of them.
    let up = 1.0 + (solid.corners().len() + 8) as f64 * 4.0 * f64::EPSILON;
    let units = totals.map(|total| unit_of(total * up));
    Frame { apex, farthest, units, errors: errors.map(|error| error * up), edges: edges * up }
}

/// Writes what leads to each vertex, and the vertices to which an edge leads, those nearer to the roots first. Returns how many they are.
fn grow(
    solid: &Solid<'_>,
    vertices: &mut [u32],
    [order, queue]: [&mut [u32]; 2],
    visited: &mut Bits<'_>,
) -> usize {
    const NONE: u32 = u32::MAX;
    let corners = solid.corners();
    for vertex in vertices.chunks_exact_mut(WORDS) {
        vertex[0] = NONE;
    }
    let mut reached = 0;
    for patch in 0..solid.patches() as u32 {
        let first = solid.patch(patch).0;
        if visited.has(first) {
            continue;
        }
        visited.set(first);
        let of = corners[first as usize];
        let mut lead = |vertices: &mut [u32], from: u32, to: u32| {
            if vertices[WORDS * to as usize] == NONE {
                vertices[WORDS * to as usize] = from;
                order[reached] = to;
                reached += 1;
            }
        };
        let known = of.into_iter().find(|&v| vertices[WORDS * v as usize] != NONE);
        let start = known.unwrap_or(of[0]);
        if known.is_none() {
            vertices[WORDS * start as usize] = ROOT | patch;
        }
        of.into_iter().filter(|&v| v != start).for_each(|v| lead(vertices, start, v));
        let (mut done, mut len) = (0, 1);
        queue[0] = first;
        while done < len {
            let own = queue[done];
            done += 1;
            for half_edge in 3 * own..3 * own + 3 {
                for other in fan(solid.next(), half_edge).skip(1) {
                    let (triangle, k) = (other / 3, other as usize % 3);
                    if visited.has(triangle) {
                        continue;
                    }
                    visited.set(triangle);
                    let of = corners[triangle as usize];
                    lead(vertices, of[k], of[(k + 2) % 3]);
                    queue[len] = triangle;
                    len += 1;
                }
            }
        }
    }
    reached
}
