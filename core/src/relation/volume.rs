//! The volume that two solids have in common, from the triangle pairs that intersect.
//!
//! The volume of a polyhedron is the sum of the cones from the origin over its faces. The faces of the intersection of two solids are the
//! parts of each triangle that are inside the other solid. A part is bounded by the segments in which the triangle meets others, and
//! by pieces of its own edges. Its cone is a sixth of the sum of det(c, x, y) over its directed boundary segments xy, for any point c of
//! its plane. With c the first corner, of the pieces of edges only those of the opposite edge count: at the fraction t of that edge an end
//! counts t times the determinant of the corners. So each pair adds what it knows, in any order, and no part is ever put together
//! (after Franklin, *Polygon Properties Calculated from the Vertex Neighborhoods*, SoCG 1987).
//!
//! The second solid is thought to be shifted by (ε, ε², ε³) for ε towards 0 (Edelsbrunner & Mücke 1990), so that no four points are
//! coplanar: a sign that is 0 is that of the first component of a normal, or of the cross product of two edges. Volume is continuous, so
//! that the limit is the volume without the shift.
//!
//! Signs are exact. Numbers carry a bound of their error, and points on edges are within 2^-44 of the length of the edge.

use super::ball::{Ball, determinant};
use super::fans::{edge_of, fan};
use super::ray::Posed;
use super::solid::{DEGENERATE, MARKED};
use super::{NotSolid, RelationQuery};
use crate::bvtt::TrianglePair;
use crate::exact::difference;
use crate::exact::filter64::{ERROR_3D, UNDERFLOW_3D, larger};
use crate::exact::integer::orient3d_ratio;
use crate::exact::orientation::{orient2d, sides};
use crate::scalar::Scalar;
use crate::triangle::{flat, turn};
use crate::{CapacityError, exact::Exact};
use core::ops::ControlFlow;
use glam::DVec3;

/// The number of words that an [`Overlap`] takes, for the triangles of both solids together: 20 bytes a triangle.
#[must_use]
pub const fn overlap_bound(triangles: usize) -> usize {
    5 * triangles
}

/// The common volume of two solids, from the pairs that are added to it.
#[derive(Debug)]
pub struct Overlap<'s, 'a> {
    query: &'s RelationQuery<'a>,
    /// Six times the volume, so far.
    sum: Ball,
    origin: DVec3,
    /// For each half-edge that is the lowest of its edge, by how much inside it gets along it.
    steps: [&'s mut [i32]; 2],
    /// For each triangle: 0 before it is visited, else 1 plus 2, 4 and 8 for corners inside.
    corners: [&'s mut [u32]; 2],
    queue: &'s mut [u32],
}

/// An end of the segment in which two triangles meet: where an edge of one cuts the other.
#[derive(Clone, Copy)]
struct End<C> {
    mesh: usize,
    /// The edge from this corner to the next.
    edge: usize,
    /// Whether it leads to the front of the other triangle.
    is_up: bool,
    /// Its ends, from behind the other triangle to its front.
    ends: [[C; 3]; 2],
}

impl<'s, 'a> Overlap<'s, 'a> {
    /// Nothing added yet.
    ///
    /// # Errors
    /// [`NotSolid::MeetsItself`] if a triangle of one of the two meets its own mesh; [`NotSolid::Capacity`] if there are fewer than
    /// [`overlap_bound`] words.
    pub fn new(query: &'s RelationQuery<'a>, words: &'s mut [u32]) -> Result<Self, NotSolid> {
        if let Some(pair) = query.solids.iter().find_map(|solid| solid.marked_pair()) {
            return Err(NotSolid::MeetsItself { pair });
        }
        let counts = [0, 1].map(|mesh| query.solids[mesh].corners().len());
        let needed = overlap_bound(counts[0] + counts[1]);
        CapacityError::check("words", needed, words.len())?;
        let words = &mut words[..needed];
        words.fill(0);
        let (steps_a, words) = words.split_at_mut(3 * counts[0]);
        let (steps_b, words) = words.split_at_mut(3 * counts[1]);
        let (corners_a, words) = words.split_at_mut(counts[0]);
        let (corners_b, queue) = words.split_at_mut(counts[1]);
        let steps = [steps_a, steps_b].map(bytemuck::must_cast_slice_mut);
        let origin = query.middle();
        let corners = [corners_a, corners_b];
        Ok(Self { query, sum: Ball::default(), origin, steps, corners, queue })
    }

    /// Adds a pair of triangles that intersect.
    pub fn add(&mut self, pair: TrianglePair) {
        match self.query.query.is_f64() {
            false => self.add_posed::<f32>(pair),
            true => self.add_posed::<f64>(pair),
        }
    }

    /// The volume, when all pairs have been added: an interval that holds it.
    ///
    /// # Complexity
    /// O(triangles), and a ray for each part of a surface.
    #[must_use]
    pub fn conclude(mut self) -> [f64; 2] {
        match self.query.query.is_f64() {
            false => self.add_corners::<f32>(),
            true => self.add_corners::<f64>(),
        }
        let volume = self.sum * Ball::new(1.0 / 6.0, f64::EPSILON);
        // Rounded outward once more.
        let [low, high] = [volume.middle - volume.radius, volume.middle + volume.radius];
        [low.next_down().max(0.0), high.next_up().max(0.0)]
    }

    /// 1 for a triangle whose front is outside, −1 for one whose back is, and 0 for one that bounds nothing.
    fn facing(&self, mesh: usize, triangle: u32) -> i32 {
        let solid = &self.query.solids[mesh];
        let patch = solid.patch_of(triangle);
        if patch == DEGENERATE {
            return 0;
        }
        let front = solid.patch(patch & !MARKED).1;
        let [front, back] = [front, front + 1].map(|n| i32::from(solid.rule().is_inside(n)));
        back - front
    }

    fn point<C: Scalar>(&self, p: &[C; 3]) -> [Ball; 3] {
        let own = DVec3::new(p[0].into(), p[1].into(), p[2].into());
        let moved = (own - self.origin).to_array();
        moved.map(|x| Ball::new(x, x.abs() * f64::EPSILON))
    }

    /// The determinant of the corners of a triangle.
    fn cone<C: Scalar>(&self, t: &[[C; 3]; 3]) -> Ball {
        determinant(t.each_ref().map(|p| self.point(p)))
    }

    fn add_posed<C: Posed>(&mut self, pair: TrianglePair) {
        let faces = [pair.a, pair.b];
        let facing = [0, 1].map(|mesh| self.facing(mesh, faces[mesh]));
        if facing.contains(&0) {
            return;
        }
        let t = [0, 1].map(|mesh| C::corners(self.query.query.sides()[mesh], faces[mesh]));
        let sides = [shifted_sides(&t[1], &t[0], -1), shifted_sides(&t[0], &t[1], 1)];
        let cuts = [0, 1].map(|mesh| cut_by(mesh, &t[mesh], &sides[mesh]));
        let [Some([first_a, last_a]), Some([last_b, first_b])] = cuts else { return };
        // Along n × m, n and m the normals, the first triangle begins where it is cut upward, the second where downward.
        let is_after = |a: &End<C>, b: &End<C>| is_after(&a.ends, &b.ends);
        if !is_after(&first_a, &last_b) || is_after(&last_a, &first_b) {
            return;
        }
        let ends = [
            if is_after(&first_a, &first_b) { first_b } else { first_a },
            if is_after(&last_a, &last_b) { last_a } else { last_b },
        ];
        let both = facing[0] * facing[1];
        let mut points = [[Ball::default(); 3]; 2];
        for (end, point) in ends.iter().zip(&mut points) {
            let (own, other) = (end.mesh, 1 - end.mesh);
            let [p, q] = [end.edge, (end.edge + 1) % 3].map(|k| &t[own][k]);
            let fraction = fraction(&t[other], p, q);
            let ([from, to], mut cut) = ([self.point(p), self.point(q)], [Ball::default(); 3]);
            for k in 0..3 {
                cut[k] = from[k] + (to[k] - from[k]) * fraction;
            }
            *point = cut;
            // Along the edge it leaves the other solid if it leads to a front that is outside.
            let leaves = if end.is_up { facing[other] } else { -facing[other] };
            if end.edge == 1 {
                let sign = Ball::new(f64::from(leaves * facing[own]), 0.0);
                self.sum = self.sum + sign * fraction * self.cone(&t[own]);
            }
            let half_edge = 3 * faces[own] + end.edge as u32;
            if self.query.is_lowest(own, half_edge) {
                self.steps[own][half_edge as usize] -= leaves;
            }
        }
        let [c, d] = [&t[0][0], &t[1][0]].map(|p| self.point(p));
        let apart = [0, 1, 2].map(|k| c[k] - d[k]);
        let sign = Ball::new(f64::from(both), 0.0);
        self.sum = self.sum + sign * determinant([apart, points[0], points[1]]);
    }

    /// Adds triangles whose last corner is inside the other solid.
    fn add_corners<C: Posed>(&mut self) {
        for mesh in 0..2 {
            for first in 0..self.corners[mesh].len() as u32 {
                let patch = self.query.solids[mesh].patch_of(first);
                if patch == DEGENERATE || self.corners[mesh][first as usize] != 0 {
                    continue;
                }
                let is_inside = self.is_first_corner_inside::<C>(mesh, first);
                self.visit(mesh, first, 0, is_inside);
                let (mut done, mut len) = (0, 1);
                self.queue[0] = first;
                while done < len {
                    let triangle = self.queue[done];
                    done += 1;
                    self.add_corner::<C>(mesh, triangle);
                    let corners = self.corners[mesh][triangle as usize];
                    for edge in 0..3 {
                        let half_edge = 3 * triangle + edge;
                        let solid = self.query.solids[mesh];
                        for other in fan(solid.next(), half_edge).skip(1) {
                            if self.corners[mesh][other as usize / 3] != 0 {
                                continue;
                            }
                            let is_alike = edge_of(solid.corners(), other).1
                                == edge_of(solid.corners(), half_edge).1;
                            let shared = if is_alike { edge } else { (edge + 1) % 3 };
                            self.visit(
                                mesh,
                                other / 3,
                                other % 3,
                                corners >> (shared + 1) & 1 != 0,
                            );
                            self.queue[len] = other / 3;
                            len += 1;
                        }
                    }
                }
            }
        }
    }

    /// Notes which corners of a triangle are inside, of which one is known.
    fn visit(&mut self, mesh: usize, triangle: u32, corner: u32, is_inside: bool) {
        let mut bits = 1 | u32::from(is_inside) << (corner + 1);
        let mut inside = i32::from(is_inside);
        for k in [corner, (corner + 1) % 3] {
            inside += self.step(mesh, 3 * triangle + k);
            bits |= u32::from(inside != 0) << ((k + 1) % 3 + 1);
        }
        self.corners[mesh][triangle as usize] = bits;
    }

    /// By how much inside one gets along a half-edge.
    fn step(&self, mesh: usize, half_edge: u32) -> i32 {
        let solid = &self.query.solids[mesh];
        let lowest = fan(solid.next(), half_edge).min().unwrap_or(half_edge);
        let step = self.steps[mesh][lowest as usize];
        let is_alike = edge_of(solid.corners(), half_edge).1 == edge_of(solid.corners(), lowest).1;
        if is_alike { step } else { -step }
    }

    fn add_corner<C: Posed>(&mut self, mesh: usize, triangle: u32) {
        let facing = self.facing(mesh, triangle);
        if self.corners[mesh][triangle as usize] & 8 != 0 && facing != 0 {
            let corners = C::corners(self.query.query.sides()[mesh], triangle);
            let sign = Ball::new(f64::from(facing), 0.0);
            self.sum = self.sum + sign * self.cone(&corners);
        }
    }

    /// Whether the first corner of a triangle is inside the other solid, by a ray along the first axis.
    fn is_first_corner_inside<C: Posed>(&self, mesh: usize, triangle: u32) -> bool {
        let (query, other) = (&self.query.query, 1 - mesh);
        let sides_of = query.sides();
        let [point, ..] = C::corners(sides_of[mesh], triangle);
        let vertex = sides_of[mesh].bvh.mesh().triangles()[triangle as usize][0];
        let shift = if mesh == 0 { -1 } else { 1 };
        let mut winding = 0;
        let _ = query.visit_overlapping(other, &query.box_of_ray(mesh, vertex, 0), |face| {
            let corners = C::corners(sides_of[other], face);
            let turned = turn::<Exact<C>>(&corners, 0).unwrap_or(0);
            let below = flat(&corners, 0);
            let at = [point[1], point[2]];
            let is_within = (0..3).all(|k| {
                let (p, q) = (&below[k], &below[(k + 1) % 3]);
                let side = match orient2d(p, q, &at) {
                    // The shift is larger along the first of both axes.
                    0 if p[1] != q[1] => {
                        if p[1] > q[1] {
                            shift
                        } else {
                            -shift
                        }
                    }
                    0 => {
                        if q[0] > p[0] {
                            shift
                        } else {
                            -shift
                        }
                    }
                    side => side,
                };
                side == turned
            });
            if turned != 0 && is_within {
                let [side] = shifted_sides(&corners, &[point], shift);
                winding += if side == turned { 0 } else { turned };
            }
            ControlFlow::Continue(())
        });
        self.query.solids[other].rule().is_inside(winding)
    }
}

/// The sign of the first component of a normal that is not 0.
fn first_of_normal<C: Scalar>(t: &[[C; 3]; 3]) -> i32 {
    (0..3).map(|axis| turn::<Exact<C>>(t, axis).unwrap_or(0)).find(|&sign| sign != 0).unwrap_or(0)
}

/// The sides of the plane of a triangle on which points lie that are shifted against it, one way or the other.
fn shifted_sides<C: Scalar, const N: usize>(
    t: &[[C; 3]; 3],
    points: &[[C; 3]; N],
    shift: i32,
) -> [i32; N] {
    let mut found = sides(t.each_ref(), points.each_ref());
    if found.contains(&0) {
        let side = shift * first_of_normal(t);
        found.iter_mut().filter(|found| **found == 0).for_each(|found| *found = side);
    }
    found
}

/// The edges of a triangle that lead to the front of the other, and behind it, by the sides of its corners.
fn cut_by<C: Scalar>(mesh: usize, t: &[[C; 3]; 3], sides: &[i32; 3]) -> Option<[End<C>; 2]> {
    let cut = |is_up: bool| {
        let from = if is_up { -1 } else { 1 };
        let edge = (0..3).find(|&k| sides[k] == from && sides[(k + 1) % 3] == -from)?;
        let [p, q] = [t[edge], t[(edge + 1) % 3]];
        Some(End { mesh, edge, is_up, ends: if is_up { [p, q] } else { [q, p] } })
    };
    Some([cut(true)?, cut(false)?])
}

/// Whether, on the line common to both planes, the edge of the second triangle comes after that of the first.
fn is_after<C: Scalar>([p, q]: &[[C; 3]; 2], [r, s]: &[[C; 3]; 2]) -> bool {
    let [side] = sides([p, q, r], [s]);
    if side != 0 {
        return side > 0;
    }
    // Both edges have a point in common, so that p and q are on different sides of rs in every projection, or on it.
    let turned = (0..3).map(|axis| {
        let [p, q, r, s] = flat(&[*p, *q, *r, *s], axis);
        orient2d(&r, &s, &q) - orient2d(&r, &s, &p)
    });
    turned.into_iter().find(|&turned| turned != 0).is_some_and(|turned| turned > 0)
}

/// The fraction of the segment from p to q at which it cuts the plane of a triangle.
fn fraction<C: Scalar>(t: &[[C; 3]; 3], p: &[C; 3], q: &[C; 3]) -> Ball {
    let [u, v, to_p, to_q] = [&t[1], &t[2], p, q].map(|x| difference(x, &t[0]));
    let normal = u.cross(v);
    let extent = larger(larger(u.abs(), v.abs()), larger(to_p.abs(), to_q.abs()));
    let error = extent.x * extent.y * extent.z * ERROR_3D + UNDERFLOW_3D;
    let (before, after) = (normal.dot(to_p), normal.dot(to_q));
    // They are of different signs, or 0.
    let whole = before.abs() + after.abs();
    let radius = error / (whole - 2.0 * error);
    if whole > 4.0 * error && radius < 5e-14 {
        return Ball::new(before / (before - after), radius + 4.0 * f64::EPSILON);
    }
    Ball::new(orient3d_ratio(t.each_ref(), p, q).clamp(0.0, 1.0), 1e-14)
}
