//! Whether two closed triangles meet.
//!
//! Two triangles in general position are decided by the signs of Devillers & Guigue (*Faster
//! Triangle-Triangle Intersection Tests*, INRIA RR-4488, 2002): three to see that one triangle
//! crosses the plane of the other, three the other way, two for the order of the four points in
//! which they cut the line common to both planes. Where every sign is exact the answer is exact,
//! and touching needs no tolerance. Our two additions:
//!
//! - the case analysis (their permutations) is a table over the signs and covers every pattern with
//!   zeros, see `LONE`;
//! - planes that coincide and triangles without area go to `flat`, which treats a triangle as what
//!   it is, a segment or a point where it has no area, and is complete.
//!
//! The logic is written once over `Kernel`; an [`Accuracy`] only chooses how signs are decided.

mod contact;
mod coplanar;
mod in_mesh;

pub use contact::{Contact, ContactKind, contact, unit_normal};
pub use in_mesh::{Adjacency, intersects_in_mesh};

use crate::Triangle;
use crate::exact::filter32::Sure;
use crate::exact::{Exact, Fast, Filtered, Kernel, Undecided};
use core::convert::Infallible;
use glam::Vec3A;

/// What an answer promises (`accuracy.md`, contract 5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accuracy {
    /// The true answer for the f32 positions given.
    #[default]
    Exact,
    /// Never misses; a pair that the f64 filter leaves open counts as a hit.
    Conservative,
    /// Plain f32: no promise.
    Fast,
}

/// Whether two closed triangles share a point. Touching counts; a triangle without area is its
/// segment or point. Swapping the triangles or permuting corners changes no `Exact` answer.
///
/// Coordinates must be finite.
///
/// # Complexity
/// O(1), no allocation, below 8 KiB of stack.
///
/// # Examples
/// ```
/// use pfront_core::triangle::{Accuracy, intersects};
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let tip = |z| [[1.0, 1.0, z], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
/// assert!(intersects(&floor, &tip(0.0), Accuracy::Exact));
/// assert!(!intersects(&floor, &tip(1e-45), Accuracy::Exact));
/// ```
#[inline]
#[must_use]
pub fn intersects(a: &Triangle, b: &Triangle, accuracy: Accuracy) -> bool {
    match accuracy {
        Accuracy::Exact => exactly(a, b),
        Accuracy::Conservative => conservatively(a, b),
        Accuracy::Fast => certain(meet::<Fast>(a, b)),
    }
}

/// [`intersects`] at another accuracy than `Exact`. A query holds it, if any, so that a program which asks for
/// none does not link them.
pub(crate) type Inexact = fn(&Triangle, &Triangle) -> bool;

impl Accuracy {
    pub(crate) fn inexact(self) -> Option<Inexact> {
        match self {
            Self::Exact => None,
            Self::Conservative => Some(conservatively),
            Self::Fast => Some(|a, b| certain(meet::<Fast>(a, b))),
        }
    }
}

#[inline]
pub(crate) fn exactly(a: &Triangle, b: &Triangle) -> bool {
    meet::<Sure>(a, b).unwrap_or_else(|Undecided| settle(a, b))
}

#[inline]
fn conservatively(a: &Triangle, b: &Triangle) -> bool {
    meet::<Sure>(a, b).or_else(|Undecided| meet::<Filtered>(a, b)).unwrap_or(true)
}

/// What f32 left open. Bodies that lie flush often do so across an axis, which needs no sign to be seen.
#[inline]
fn settle(a: &Triangle, b: &Triangle) -> bool {
    let level = |p: &[f32; 3]| Vec3A::from_array(*p).cmpeq(Vec3A::from_array(a[0]));
    let flush = level(&b[0]) & level(&a[1]) & level(&a[2]) & level(&b[1]) & level(&b[2]);
    certain(if flush.any() { coplanar::meet::<Exact>(a, b) } else { meet::<Exact>(a, b) })
}

/// [`intersects`], for any way to decide signs.
#[inline]
pub(crate) fn meet<K: Kernel>(a: &Triangle, b: &Triangle) -> Result<bool, K::Undecided> {
    let a_sides = K::sides(b, [&a[0], &a[1], &a[2]]);
    if matches!(&a_sides, Ok(s) if one_sided(s)) {
        return Ok(false);
    }
    let b_sides = K::sides(a, [&b[0], &b[1], &b[2]]);
    if matches!(&b_sides, Ok(s) if one_sided(s)) {
        return Ok(false);
    }
    let (a_sides, b_sides) = (a_sides?, b_sides?);
    if a_sides == [0; 3] || b_sides == [0; 3] {
        return coplanar::meet::<K>(a, b);
    }
    cross::<K>(a, &a_sides, b, &b_sides)
}

/// All three strictly on one side.
pub(crate) fn one_sided(sides: &[i32; 3]) -> bool {
    sides[0] != 0 && sides[0] == sides[1] && sides[0] == sides[2]
}

/// Both triangles have area, their planes differ, and each reaches the plane of the other.
///
/// Let a0 be the lone corner of `a` with side δ, and b0, ε those of `b`. On the line common to both
/// planes, `a` covers the interval between its edges a0a1 and a0a2, and `b` likewise. In
/// coordinates along that line and within the two planes, det(a1 − a0, b0 − a0, b1 − a0) is the
/// position on b0b1 minus the position on a0a1, times a factor with the sign of −ε. The two
/// intervals run the same way if δε = −1 and opposite ways if δε = 1, so that two such signs compare
/// the ends that matter. The factor is never zero since a lone corner is not on the side of the
/// other two, which is why touching needs no case of its own.
#[inline]
fn cross<K: Kernel>(
    a: &Triangle,
    a_sides: &[i32; 3],
    b: &Triangle,
    b_sides: &[i32; 3],
) -> Result<bool, K::Undecided> {
    let (i, delta) = lone_corner(a_sides);
    let (j, epsilon) = lone_corner(b_sides);
    let ([a0, a1, a2], [b0, mut b1, mut b2]) = (from_corner(a, i), from_corner(b, j));
    if delta != epsilon {
        core::mem::swap(&mut b1, &mut b2);
    }
    K::neither([a0, b0], [(a1, b1, epsilon), (a2, b2, -epsilon)])
}

/// The corner with no other strictly on its side of the plane nor, if it lies in the plane, in the
/// plane with it; and its side, which for a corner in the plane is the one the others are not on.
#[inline]
pub(crate) fn lone_corner(sides: &[i32; 3]) -> (usize, i32) {
    let pattern = (sides[0] + 1) * 9 + (sides[1] + 1) * 3 + (sides[2] + 1);
    let (corner, side) = LONE.get(pattern as usize).copied().unwrap_or_default();
    (corner as usize, i32::from(side))
}

/// The corners, beginning with one.
#[inline]
pub(crate) fn from_corner([p, q, r]: &Triangle, corner: usize) -> [&[f32; 3]; 3] {
    match corner {
        0 => [p, q, r],
        1 => [q, r, p],
        _ => [r, p, q],
    }
}

/// [`lone_corner`] for each of the 27 patterns of signs.
const LONE: [(u8, i8); 27] = {
    let mut table = [(0, 0); 27];
    let mut pattern = 0;
    while pattern < 27 {
        let sides = [pattern / 9 - 1, pattern / 3 % 3 - 1, pattern % 3 - 1];
        let mut corner = 0;
        while corner < 3 {
            let (own, p, q) = (sides[corner], sides[(corner + 1) % 3], sides[(corner + 2) % 3]);
            if own != 0 && own != p && own != q {
                table[pattern as usize] = (corner as u8, own as i8);
            } else if own == 0 && p != 0 && p == q {
                table[pattern as usize] = (corner as u8, -p as i8);
            }
            corner += 1;
        }
        pattern += 1;
    }
    table
};

/// Unwraps a result that cannot fail.
#[inline]
pub(crate) fn certain<T>(result: Result<T, Infallible>) -> T {
    match result {
        Ok(value) => value,
        Err(never) => match never {},
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn check(b: Triangle, expected: bool) {
        // Miri is slow and gets one of the six: as given for one triangle, odd for the other.
        let some = if cfg!(miri) { 6 } else { 1 };
        for (first, second) in [(&FLOOR, &b), (&b, &FLOOR)] {
            for p in permutations(first).into_iter().step_by(some) {
                for q in permutations(second).into_iter().rev().step_by(some) {
                    assert_eq!(intersects(&p, &q, Accuracy::Exact), expected, "{p:?} {q:?}");
                    assert!(!expected || intersects(&p, &q, Accuracy::Conservative));
                }
            }
        }
    }

    fn permutations(t: &Triangle) -> [Triangle; 6] {
        [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]].map(|o| o.map(|i| t[i]))
    }

    #[test]
    fn crossing_and_apart() {
        check([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]], true);
        check([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [9.0, 9.0, 1.0]], false);
        check([[1.0, 1.0, 1.0], [2.0, 1.0, 1.0], [1.0, 2.0, 1.0]], false);
    }

    #[test]
    fn touching_counts() {
        check([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 1.0]], true);
        check([[2.0, 2.0, 0.0], [3.0, 3.0, 1.0], [3.0, 3.0, 2.0]], true);
        check([[4.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 3.0]], true);
        check([[0.0, -1.0, -1.0], [0.0, 1.0, 1.0], [-1.0, 0.0, 0.0]], true);
    }

    #[test]
    fn coplanar() {
        check([[1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [1.0, 9.0, 0.0]], true);
        check([[0.5, 0.5, 0.0], [0.6, 0.5, 0.0], [0.5, 0.6, 0.0]], true);
        check([[-9.0, -9.0, 0.0], [99.0, -9.0, 0.0], [-9.0, 99.0, 0.0]], true);
        check([[4.0, 0.0, 0.0], [8.0, 0.0, 0.0], [8.0, 8.0, 0.0]], true);
        check([[3.0, 3.0, 0.0], [9.0, 3.0, 0.0], [3.0, 9.0, 0.0]], false);
    }

    #[test]
    fn segments_and_points() {
        check([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.5]], true);
        check([[5.0, 5.0, -1.0], [5.0, 5.0, 1.0], [5.0, 5.0, 0.5]], false);
        check([[1.0, 1.0, 0.0], [9.0, 9.0, 0.0], [5.0, 5.0, 0.0]], true);
        check([[-1.0, 2.0, 0.0], [0.0, 2.0, 0.0], [-1.0, 2.0, 0.0]], true);
        check([[1.0, 1.0, 0.0]; 3], true);
        check([[1.0, 1.0, 1e-45]; 3], false);
        check([[-1.0, 1.0, 0.0]; 3], false);
    }

    #[test]
    fn every_pattern_of_signs_has_a_lone_corner() {
        for (pattern, &(corner, side)) in LONE.iter().enumerate() {
            let sides = [pattern / 9, pattern / 3 % 3, pattern % 3].map(|s| s as i32 - 1);
            if sides == [0; 3] || one_sided(&sides) {
                continue;
            }
            let others = [1, 2].map(|k| sides[(corner as usize + k) % 3]);
            assert!(side != 0 && others.iter().all(|&o| o * i32::from(side) <= 0));
            assert!(others.iter().all(|&o| o != sides[corner as usize]));
        }
    }
}
