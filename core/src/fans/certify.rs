//! Bringing fans up to date: all of them, or those about which something has moved.
//!
//! That all are seen from the same side takes the sign of one coordinate of each normal, in f32 beyond its
//! bound: each of two products of two differences carries a relative error below (1+u)^4 − 1 with
//! u = 2^-24, so 8.02u · mi·mj of the largest differences along the two axes, and underflow costs
//! less than the smallest normal number. That the fan goes round once is counted without any rounding:
//! a sector is below half a turn, so a fan that goes round passes from one half-plane into the other, by a
//! comparison of coordinates, once a turn each way.

use super::{DOUBTS, Fan, LINK};
use crate::build::moved::{holds, mark, number, vertices};
use crate::build::survey::leaves_near;
use crate::build::{Below, Moved, moved_bound, survey_bound};
use crate::{Bvh, CapacityError, Mesh};
use glam::Vec3A;

/// Brings the fans of a mesh up to date with its positions. `fans` are those of [`link`] for the same
/// triangles; others may make a query miss pairs.
///
/// # Errors
/// [`CapacityError`] if `fans` has not one entry a vertex.
///
/// # Complexity
/// O(vertices + triangles), about 15 ns a triangle.
pub fn certify(mesh: Mesh<'_>, fans: &mut [Fan]) -> Result<(), CapacityError> {
    let positions = mesh.positions();
    CapacityError::check("fans", positions.len(), fans.len())?;
    for fan in fans.iter_mut() {
        fan.0 &= LINK;
    }
    for t in mesh.triangles() {
        count(positions, t, fans, |_| true);
    }
    for fan in fans.iter_mut() {
        *fan = fan.settled();
    }
    Ok(())
}

/// [`certify`] after some vertices of a mesh have moved: brings up to date the fans of these and of their
/// neighbours, on which alone that has a bearing.
///
/// `bvh` and `table` are as [`refit_moved`](crate::build::refit_moved) or
/// [`survey`](crate::build::survey()) left them, `moved` is what has moved since the fans were up to date.
/// `scratch` may hold anything.
///
/// # Errors
/// [`CapacityError`] if `fans` has not one entry a vertex, `table` fewer rows than [`survey_bound`], or
/// `moved` or `scratch` fewer words than [`moved_bound`].
///
/// # Complexity
/// As [`refit_moved`](crate::build::refit_moved).
pub fn certify_moved(
    bvh: &Bvh<'_>,
    table: &[Below],
    moved: &[Moved],
    scratch: &mut [Moved],
    fans: &mut [Fan],
) -> Result<(), CapacityError> {
    let (positions, triangles) = (bvh.mesh().positions(), bvh.mesh().triangles());
    CapacityError::check("fans", positions.len(), fans.len())?;
    CapacityError::check("table", survey_bound(bvh.nodes().len()), table.len())?;
    CapacityError::check("moved", moved_bound(positions.len()), moved.len())?;
    CapacityError::check("scratch", moved_bound(positions.len()), scratch.len())?;
    // Whatever shares a triangle with a vertex that has moved.
    let near = scratch;
    near.fill(Moved::default());
    leaves_near(bvh, table, moved, |leaf| {
        for t in leaf.iter().map(|&t| triangles[t as usize]) {
            if t.iter().any(|&vertex| holds(moved, vertex)) {
                t.iter().for_each(|&vertex| mark(near, vertex));
            }
        }
    });
    number(near);
    vertices(near).for_each(|vertex| fans[vertex].0 &= LINK);
    leaves_near(bvh, table, near, |leaf| {
        for t in leaf.iter().map(|&t| &triangles[t as usize]) {
            if t.iter().any(|&vertex| holds(near, vertex)) {
                count(positions, t, fans, |vertex| holds(near, vertex));
            }
        }
    });
    vertices(near).for_each(|vertex| fans[vertex] = fans[vertex].settled());
    Ok(())
}

/// Counts a triangle in those fans of its corners that are `due`.
#[inline(always)]
fn count(positions: &[[f32; 3]], t: &[u32; 3], fans: &mut [Fan], due: impl Fn(u32) -> bool) {
    let at = |k: usize| Vec3A::from_array(positions[t[k] as usize]);
    let [p, q, r] = [at(0), at(1), at(2)];
    let doubts = sides_in_doubt(q - p, r - p) << DOUBTS;
    // Seen from a corner, a fan goes from the next one to the one after.
    let above = |x: Vec3A, y: Vec3A| x.cmpge(y).bitmask();
    let passes =
        [[above(q, p), above(r, p)], [above(r, q), above(p, q)], [above(p, r), above(q, r)]];
    for (&vertex, [next, after]) in t.iter().zip(passes) {
        let word = &mut fans[vertex as usize].0;
        if *word & LINK != 0 && due(vertex) {
            let passed =
                SPREAD[(!next & after) as usize & 7] + (SPREAD[(next & !after) as usize & 7] << 4);
            *word = word.wrapping_add(passed) | doubts;
        }
    }
}

/// One in the byte of each bit.
const SPREAD: [u32; 8] = [0, 1, 0x100, 0x101, 0x1_0000, 0x1_0001, 0x1_0100, 0x1_0101];

/// A bit for each axis along which the triangle with these two edges is not surely seen counter-clockwise,
/// and three bits on for clockwise.
#[inline]
fn sides_in_doubt(u: Vec3A, v: Vec3A) -> u32 {
    const BOUND: f32 = 4.9e-7;
    /// 2^60: products of two overflow nowhere near.
    const MOST: f32 = 1.152_921_5e18;
    let extent = u.abs().max(v.abs());
    if extent.max_element() > MOST {
        return 0x3f;
    }
    let normal = u.cross(v);
    let bound = Vec3A::new(extent.y * extent.z, extent.z * extent.x, extent.x * extent.y) * BOUND
        + Vec3A::splat(f32::MIN_POSITIVE);
    let (seen, unseen) = (normal.cmpgt(bound).bitmask(), normal.cmplt(-bound).bitmask());
    !(seen | unseen << 3) & 0x3f
}
