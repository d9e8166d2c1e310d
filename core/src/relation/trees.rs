//! How the cones of a solid are added up along trees of its edges.

use super::Solid;
use super::ball::{Ball, cross, dot};
use super::cones::{Frame, HEADER, ROOT, SUM, Sum, WORDS, unit_of};
use super::fans::{Bits, fan};
use super::solid::DEGENERATE;
use glam::DVec3;

/// The determinant of the corners of a triangle seen from an apex, and its normal.
fn cone([p, q, r]: [DVec3; 3], apex: DVec3) -> (Ball, [Ball; 3]) {
    let ball = |x: f64| Ball::new(x, x.abs() * f64::EPSILON);
    let [from, u, v] = [p - apex, q - p, r - p].map(|x| x.to_array().map(ball));
    let normal = cross(&u, &v);
    (dot(&from, &normal), normal)
}

impl Frame {
    /// The sum of one triangle.
    fn sum_of(&self, solid: &Solid<'_>, triangle: u32) -> Sum {
        if solid.is_marked(triangle) {
            return Sum { counts: [0, 1], ..Sum::default() };
        }
        let facing = solid.facing(triangle);
        let (determinant, normal) = cone(corners_of(solid, triangle), self.apex);
        let cut = |ball: Ball, i: usize| (ball.middle / self.units[i]) as i64 * i64::from(facing);
        let [x, y, z] = normal.map(|component| cut(component, 1));
        Sum { cones: [cut(determinant, 0), x, y, z], counts: [u32::from(facing != 0), 0] }
    }
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

fn corners_of(solid: &Solid<'_>, triangle: u32) -> [DVec3; 3] {
    solid.bvh().mesh().triangle_f64(triangle).map(DVec3::from_array)
}

/// Triangles with an area.
fn triangles_of(solid: &Solid<'_>) -> impl Iterator<Item = u32> {
    let solid = *solid;
    (0..solid.corners().len() as u32).filter(move |&t| solid.patch_of(t) != DEGENERATE)
}

/// The frame in which the cones of a solid are taken.
fn measured(solid: &Solid<'_>) -> Frame {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in triangles_of(solid).flat_map(|triangle| corners_of(solid, triangle)) {
        (low, high) = (low.min(p), high.max(p));
    }
    let apex = low * 0.5 + high * 0.5;
    let farthest = low.abs().max(high.abs()).max_element();
    let (mut totals, mut errors, mut edges) = ([0.0; 2], [0.0; 2], 0.0);
    for triangle in 0..solid.corners().len() as u32 {
        let corners @ [p, q, r] = corners_of(solid, triangle);
        let around = [q - p, r - q, p - r].iter().map(|edge| edge.abs().element_sum()).sum::<f64>();
        if solid.patch_of(triangle) == DEGENERATE {
            edges += 5.0 * around;
            continue;
        }
        edges += around;
        let (determinant, normals) = cone(corners, apex);
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
