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

use super::ball::{Ball, cross, determinant, dot};
use super::cones::Sum;
use super::ray::{Posed, side_of_shifted, surrounds};
use super::{NotSolid, RelationQuery};
use crate::bvtt::TrianglePair;
use crate::exact::Exact;
use crate::exact::orientation::{orient2d, sides};
use crate::scalar::Scalar;
use crate::triangle::{flat, fraction, turn};
use core::ops::ControlFlow;
use glam::DVec3;

/// The common volume of two solids, from the pairs that are added to it.
#[derive(Debug)]
pub struct Overlap<'s, 'a> {
    query: &'s RelationQuery<'a>,
    /// Six times the volume, so far.
    sum: Ball,
    origin: DVec3,
    /// Cones over the triangles of each mesh whose last corner is inside the other solid.
    inside: [Sum; 2],
    /// Whether a pair has been added.
    has_met: bool,
    /// 1, or −1 if the pose of the second mirrors it.
    turn: i32,
    /// Whether a marked triangle of each mesh meets the other mesh.
    has_marked: [bool; 2],
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
    #[must_use]
    pub fn new(query: &'s RelationQuery<'a>) -> Self {
        let turn = if scale_of(query) < 0.0 { -1 } else { 1 };
        let origin = query.middle();
        let (inside, has_met, has_marked) = (Default::default(), false, [false; 2]);
        Self { query, sum: Ball::default(), origin, inside, has_met, turn, has_marked }
    }

    /// Adds a pair of triangles that intersect.
    pub fn add(&mut self, pair: TrianglePair) {
        self.has_met = true;
        match self.query.query.is_f64() {
            false => self.add_posed::<f32>(pair),
            true => self.add_posed::<f64>(pair),
        }
    }

    /// The volume, when all pairs have been added: an interval that holds it.
    ///
    /// # Errors
    /// [`NotSolid::MeetsItself`] if triangles of one of the two meet their own mesh inside the other solid or on its surface.
    ///
    /// # Complexity
    /// A ray for each part of a surface.
    pub fn conclude(mut self) -> Result<[f64; 2], NotSolid> {
        for mesh in 0..2 {
            self.add_trees(mesh);
            let has_marked = self.has_marked[mesh] || self.inside[mesh].has_marked();
            if let Some(pair) = self.query.solids[mesh].marked_pair().filter(|_| has_marked) {
                return Err(NotSolid::MeetsItself { pair });
            }
            self.sum = self.sum + self.cones_inside(mesh);
        }
        self.sum.radius += self.rounding();
        let volume = self.sum * Ball::new(1.0 / 6.0, f64::EPSILON);
        // Rounded outward once more.
        let [low, high] = [volume.middle - volume.radius, volume.middle + volume.radius];
        Ok([low.next_down().max(0.0), high.next_up().max(0.0)])
    }

    fn facing(&self, mesh: usize, triangle: u32) -> i32 {
        let facing = self.query.solids[mesh].facing(triangle);
        if mesh == 0 { facing } else { self.turn * facing }
    }

    fn point<C: Scalar>(&self, p: &[C; 3]) -> [Ball; 3] {
        let own = DVec3::new(p[0].into(), p[1].into(), p[2].into());
        let moved = (own - self.origin).to_array();
        moved.map(|x| Ball::new(x, x.abs() * f64::EPSILON))
    }

    /// The determinant of the corners of a triangle.
    fn cone<C: Scalar>(&self, t: &[[C; 3]; 3]) -> Ball {
        determinant(&t.each_ref().map(|p| self.point(p)))
    }

    fn add_posed<C: Posed>(&mut self, pair: TrianglePair) {
        let faces = [pair.a, pair.b];
        for (mesh, &face) in faces.iter().enumerate() {
            self.has_marked[mesh] |= self.query.solids[mesh].is_marked(face);
        }
        let facing = [0, 1].map(|mesh| self.facing(mesh, faces[mesh]));
        if facing == [0; 2] {
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
            let [middle, radius] = fraction(&t[other], p, q);
            let fraction = Ball::new(middle, radius);
            let ([from, to], mut cut) = ([self.point(p), self.point(q)], [Ball::default(); 3]);
            for k in 0..3 {
                cut[k] = from[k] + (to[k] - from[k]) * fraction;
            }
            *point = cut;
            // Along the edge it leaves the other solid if it leads to a front that is outside.
            let leaves = if end.is_up { facing[other] } else { -facing[other] };
            if leaves == 0 {
                continue;
            }
            if end.edge == 1 {
                let sign = Ball::new(f64::from(leaves * facing[own]), 0.0);
                self.sum = self.sum + sign * fraction * self.cone(&t[own]);
            }
            let half_edge = 3 * faces[own] + end.edge as u32;
            if self.query.is_lowest(own, half_edge) {
                let solid = &self.query.solids[own];
                let ends = solid.corners()[faces[own] as usize];
                let [from, to] = [end.edge, (end.edge + 1) % 3].map(|k| ends[k]);
                solid.cones().step(from, to, -leaves, &mut self.inside[own]);
            }
        }
        if both == 0 {
            return;
        }
        let [c, d] = [&t[0][0], &t[1][0]].map(|p| self.point(p));
        let apart = [0, 1, 2].map(|k| c[k] - d[k]);
        let sign = Ball::new(f64::from(both), 0.0);
        self.sum = self.sum + sign * determinant(&[apart, points[0], points[1]]);
    }

    /// Adds the trees of a mesh that begin inside the other solid.
    fn add_trees(&mut self, mesh: usize) {
        let solid = self.query.solids[mesh];
        for patch in 0..solid.patches() as u32 {
            let triangle = solid.patch(patch).0;
            let Some(tree) = solid.cones().of_tree(solid.corners()[triangle as usize][0], patch)
            else {
                continue;
            };
            let is_inside = match self.query.query.is_f64() {
                false => self.is_first_corner_inside::<f32>(mesh, triangle),
                true => self.is_first_corner_inside::<f64>(mesh, triangle),
            };
            if is_inside {
                self.inside[mesh].add(&tree, 1);
            }
        }
    }

    /// The cones inside from the origin, posed. With x = M y + s for a point y of the mesh seen from its apex,
    /// det(x, x′, x″) = det(M) det(y, y′, y″) + s · adj(M)ᵀ n, where n is the normal.
    fn cones_inside(&self, mesh: usize) -> Ball {
        let (solid, sum) = (&self.query.solids[mesh], &self.inside[mesh]);
        if sum.triangles() == 0 {
            return Ball::default();
        }
        let frame = solid.cones().frame();
        let (all, normal) = frame.balls(sum);
        let exact = |x: f64| Ball::new(x, 0.0);
        let side = self.query.query.sides()[mesh];
        let pose = side.as_pose64();
        let rows = pose.rows.map(|[x, y, z, _]| [x, y, z].map(exact));
        let apex = frame.apex.to_array();
        let mut from = [Ball::default(); 3];
        for k in 0..3 {
            let moved = exact(pose.rows[k][3]) - exact(self.origin.to_array()[k]);
            from[k] = dot(&rows[k], &apex.map(exact)) + moved;
        }
        let [x, y, z] = [0, 1, 2].map(|k| cross(&rows[(k + 1) % 3], &rows[(k + 2) % 3]));
        let turned = [dot(&x, &normal), dot(&y, &normal), dot(&z, &normal)];
        let found = determinant(&rows) * all + dot(&from, &turned);
        if mesh == 1 { exact(f64::from(self.turn)) * found } else { found }
    }

    /// By how much the sum may be off since each posed coordinate is rounded, by d at most. The cone of a triangle changes by 2 d times
    /// the largest coordinate and the sum of its edges, and by terms of higher order. And where the rounded mesh meets itself, the sum
    /// is that of no solid, but differs from it by no more than what the triangles sweep over when they are rounded, twice.
    fn rounding(&self) -> f64 {
        let (side, inside) = (self.query.query.sides()[1], self.inside[1].triangles());
        if !self.has_met && inside == 0 || self.query.is_exact() {
            return 0.0;
        }
        let (frame, rows) = (self.query.solids[1].cones().frame(), side.as_pose64().rows);
        let unit = if self.query.query.is_f64() { f64::EPSILON } else { f32::EPSILON.into() };
        let (mut d, mut largest, mut columns) = (0.0_f64, 0.0_f64, DVec3::ZERO);
        for ([x, y, z, t], origin) in rows.into_iter().zip(self.origin.to_array()) {
            let row = DVec3::new(x, y, z).abs();
            let reach = row.element_sum() * frame.farthest + t.abs();
            d = d.max(4.0 * unit * reach);
            largest = largest.max(1.01 * (reach + origin.abs()));
            columns += row;
        }
        let (edges, stretch) = (columns.max_element() * frame.edges, columns.element_sum());
        let cones = d * largest * (2.0 * edges + 24.0 * d * f64::from(inside));
        let all = side.bvh.mesh().triangles().len() as f64;
        let swept =
            1.74 * d * (stretch * stretch * frame.area() + 4.0 * d * (edges + 4.0 * d * all));
        1.01 * (cones + 12.0 * swept)
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
            let (below, at) = (flat(&corners, 0), [point[1], point[2]]);
            if !surrounds(&below, &at) {
                return ControlFlow::Continue(());
            }
            let turned = turn::<Exact<C>>(&corners, 0).unwrap_or(0);
            let is_within = [(0, 1), (1, 2), (2, 0)].iter().all(|&(p, q)| {
                // The shift is larger along the first of both axes.
                side_of_shifted([&below[p], &below[q]], &at, shift) == turned
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

/// The determinant of the pose of the second mesh.
fn scale_of(query: &RelationQuery<'_>) -> f64 {
    let [x, y, z] = query.query.sides()[1].as_pose64().rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
    x.dot(y.cross(z))
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
