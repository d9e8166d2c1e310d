//! Whether two closed triangles intersect, and where.
//!
//! # How a pair is decided
//! Only signs of orientation determinants decide, so that exact signs make exact answers and touching needs
//! no tolerance. Two triangles in general position take up to eight, those of Devillers and Guigue (*Faster
//! Triangle-Triangle Intersection Tests*, INRIA RR-4488, 2002), in `triangles_intersect`:
//!
//! 1. the sides of the plane of b on which the corners of a lie. All strictly on one side: disjoint;
//! 2. the same for the corners of b and the plane of a;
//! 3. otherwise each triangle cuts the line common to both planes in an interval. The two intervals overlap
//!    if the end of each is not before the start of the other, which is two more signs (`intervals_overlap`).
//!
//! If all three signs of a step are zero, the planes coincide or a triangle is degenerate: see `coplanar`.
//!
//! # Where signs come from
//! The test is written once over `Orientation` and run with signs that f32 certifies; if one is uncertain, the whole test
//! anew with exact signs, those of f64 for corners on a grid.
//!
//! # Where we depart
//! The paper permutes corners case by case. Here one rule finds the corner that is alone on its side
//! (`apex`), for every pattern with zeros too; and degenerate triangles are tested as the segments or
//! points that they are. `in_mesh` has the rule for triangles that share vertices, `contact` the segment in
//! which two intersect.

mod contact;
mod coplanar;
mod in_mesh;
mod meet;
#[cfg(any(feature = "within", feature = "motion"))]
mod nearest;
mod ratio;
mod within;

use coplanar::coplanar_triangles_intersect;
#[cfg(feature = "relation")]
pub(crate) use coplanar::{Projection, flat, projection, turn};

pub use contact::{Contact, contact};
pub(crate) use contact::{contact_of, posed_contact};
#[cfg(feature = "relation")]
pub(crate) use in_mesh::intersects_as_in_mesh;
#[cfg(feature = "motion")]
pub(crate) use in_mesh::neighbours;
pub use in_mesh::{Adjacency, intersects_in_mesh};
pub(crate) use meet::meet_of;
pub use meet::{Meet, Region, meet, meet_f64};
#[cfg(feature = "motion")]
pub(crate) use nearest::{Feature, features, near_points};
#[cfg(feature = "within")]
pub(crate) use nearest::{Nearest, UNDERFLOW, nearest};
#[cfg(feature = "relation")]
pub(crate) use ratio::fraction;
pub use within::within;
pub(crate) use within::within_in_f64;

use crate::Triangle;
use crate::exact::{CertifiedF32, Exact, ExactF64, HAS_F64, Orientation, Point, are_exact_in_f64};
use crate::mesh::{MeshError, check_position};
use glam::Vec3A;

/// Whether two closed triangles share a point, exactly. Touching counts; a triangle without area is its
/// segment or point.
///
/// Coordinates must be finite.
///
/// # Complexity
/// O(1), no allocation, below 8 KiB of stack.
///
/// # Examples
/// ```
/// use pfront_core::triangle::intersects;
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let tip = |z| [[1.0, 1.0, z], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
/// assert!(intersects(&floor, &tip(0.0)));
/// assert!(!intersects(&floor, &tip(1e-45)));
/// ```
#[inline]
#[must_use]
pub fn intersects(a: &Triangle, b: &Triangle) -> bool {
    // Six corners with the same x, y or z are coplanar, which is common where faces lie flush.
    let level = |p: &Point| Vec3A::from_array(*p).cmpeq(Vec3A::from_array(a[0]));
    let flush = level(&b[0]) & level(&a[1]) & level(&a[2]) & level(&b[1]) & level(&b[2]);
    let is_flush = flush.any();
    if !is_flush && let Some(hit) = triangles_intersect::<CertifiedF32>(a, b) {
        return hit;
    }
    let hit = match (is_flush, HAS_F64 && are_exact_in_f64(a, b)) {
        (true, true) => coplanar_triangles_intersect::<ExactF64>(a, b),
        (true, false) => coplanar_triangles_intersect::<Exact<f32>>(a, b),
        (false, true) => triangles_intersect::<ExactF64>(a, b),
        (false, false) => triangles_intersect::<Exact<f32>>(a, b),
    };
    hit == Some(true)
}

/// Whether two closed triangles with f64 coordinates share a point, exactly: what [`intersects`] says for f32.
///
/// # Errors
/// [`MeshError`] names the first of the six corners that has a coordinate which is NaN or beyond ±2^125.
///
/// # Complexity
/// O(1), no allocation, bounded stack.
///
/// # Examples
/// ```
/// use pfront_core::triangle::intersects_f64;
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let tip = |z| [[1.0, 1.0, z], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
/// assert_eq!(intersects_f64(&floor, &tip(0.0)), Ok(true));
/// assert_eq!(intersects_f64(&floor, &tip(5e-324)), Ok(false));
/// ```
pub fn intersects_f64(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> Result<bool, MeshError> {
    for (corner, p) in a.iter().chain(b).enumerate() {
        check_position(corner, *p)?;
    }
    Ok(intersects_in_f64(a, b))
}

/// [`intersects_f64`] of coordinates that are in range. A function of its own, so that a traversal does not take its stack.
#[inline(never)]
pub(crate) fn intersects_in_f64(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> bool {
    triangles_intersect::<Exact<f64>>(a, b) == Some(true)
}

/// [`intersects`] by one kind of signs; `None` if a sign that decides is not known.
#[inline]
fn triangles_intersect<K: Orientation>(a: &[[K::C; 3]; 3], b: &[[K::C; 3]; 3]) -> Option<bool> {
    // One plane with the other triangle on one side is enough, whatever is uncertain about the other plane.
    let a_sides = K::orient3d(b.each_ref(), a.each_ref());
    if a_sides.as_ref().is_some_and(one_sided) {
        return Some(false);
    }
    let b_sides = K::orient3d(a.each_ref(), b.each_ref());
    if b_sides.as_ref().is_some_and(one_sided) {
        return Some(false);
    }
    let (a_sides, b_sides) = (a_sides?, b_sides?);
    if a_sides == [0; 3] || b_sides == [0; 3] {
        return coplanar_triangles_intersect::<K>(a, b);
    }
    let (a, b, side) = arrange(a, &a_sides, b, &b_sides);
    intervals_overlap::<K>(a, b, side)
}

/// Whether all three corners are strictly on one side of a plane.
fn one_sided(sides: &[i32; 3]) -> bool {
    sides[0] != 0 && sides[0] == sides[1] && sides[0] == sides[2]
}

/// Whether two triangles intersect that have areas, lie in different planes and reach the plane of each other;
/// their corners and `side` are as [`arrange`] returns them.
///
/// On the line common to both planes each triangle covers an interval: `a` from its edge a0a1 to its edge a0a2, `b` from
/// b0b2 to b0b1. The intervals overlap unless one ends before the other begins. Each of these two comparisons is one
/// determinant: det(a1 − a0, b0 − a0, b1 − a0) is the position at which b0b1 cuts the line minus that of a0a1, times a
/// factor with the sign of −`side`; likewise for a0a2 and b0b2. The factor is never zero, since an apex is not on the
/// side of the other two corners. So touching, where a determinant is zero, needs no case of its own.
#[inline]
fn intervals_overlap<K: Orientation>(
    [a0, a1, a2]: [&[K::C; 3]; 3],
    [b0, b1, b2]: [&[K::C; 3]; 3],
    side: i32,
) -> Option<bool> {
    // Both are computed before either is looked at, so that a processor works on them side by side.
    let (first, second) = (K::orient3d([a0, a1, b0], [b1])?, K::orient3d([a0, a2, b0], [b2])?);
    Some((first != [side]) & (second != [-side]))
}

/// The corners of both triangles from their apexes on, and the side of the apex of `b`. The other two corners of `b` are in
/// the order in which the intervals of both triangles run the same way.
#[inline]
pub(crate) fn arrange<'t, T>(
    a: &'t [T; 3],
    a_sides: &[i32; 3],
    b: &'t [T; 3],
    b_sides: &[i32; 3],
) -> ([&'t T; 3], [&'t T; 3], i32) {
    let ((i, delta), (j, epsilon)) = (apex(a_sides), apex(b_sides));
    let [b0, b1, b2] = rotated(b, j);
    let b = if delta == epsilon { [b0, b1, b2] } else { [b0, b2, b1] };
    (rotated(a, i), b, epsilon)
}

/// The apex of a triangle that reaches a plane: the corner that both edges which cut the plane have in common, and its
/// side.
///
/// An apex off the plane has no other corner on its side. An apex in the plane has both others on one side, and counts as
/// on the other.
#[inline]
fn apex(&[p, q, r]: &[i32; 3]) -> (usize, i32) {
    let is_apex = |own: i32, p: i32, q: i32| own != p && own != q && (own != 0 || p == q);
    let side = |own: i32, other: i32| if own == 0 { -other } else { own };
    if is_apex(r, p, q) {
        (2, side(r, p))
    } else if is_apex(q, r, p) {
        (1, side(q, r))
    } else {
        (0, side(p, q))
    }
}

/// The corners, beginning with one.
#[inline]
fn rotated<T>([p, q, r]: &[T; 3], first: usize) -> [&T; 3] {
    match first {
        0 => [p, q, r],
        1 => [q, r, p],
        _ => [r, p, q],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    /// Widened to f64, and scaled to below the range of f32, a pair intersects as it did.
    #[test]
    fn f64_decides_the_families_of_f32_as_the_oracle() {
        let mut rng = pfront_testkit::rng::seeded(16);
        for family in pfront_testkit::families::Family::ALL {
            for _ in 0..if cfg!(miri) { 2 } else { 1_000 } {
                let (a, b) = family.pair(&mut rng);
                let truth = pfront_testkit::oracle::intersect(&a, &b);
                for scale in [1.0, f64::from_bits((1023 - 900) << 52)] {
                    let [a, b] = [a, b].map(|t| t.map(|p| p.map(|x| f64::from(x) * scale)));
                    if a.iter().chain(&b).flatten().all(|x| x.abs() <= 4e37) {
                        assert_eq!(intersects_f64(&a, &b), Ok(truth), "{family:?} {a:?} {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn f64_sees_gaps_that_f32_rounds_away() {
        let tip = |z: f64| [[1.0, 1.0, z], [1.0, 2.0, 3e6], [2.0, 1.0, 3e6]];
        let floor = [[0.0, 0.0, 1e6], [4.0, 0.0, 1e6], [0.0, 4.0, 1e6]];
        assert_eq!(intersects_f64(&floor, &tip(1e6 + 1e-9)), Ok(false));
        assert_eq!(intersects_f64(&floor, &tip(1e6)), Ok(true));
        let out = [[0.0; 3], [0.0, f64::NAN, 0.0], [0.0; 3]];
        assert_eq!(intersects_f64(&floor, &out), Err(MeshError::NonFinite { vertex: 4 }));
        assert_eq!(intersects_f64(&[[1e38; 3]; 3], &floor), Err(MeshError::Range { vertex: 0 }));
    }

    fn check(b: Triangle, expected: bool) {
        for (first, second) in [(&FLOOR, &b), (&b, &FLOOR)] {
            for p in permutations(first) {
                for q in permutations(second) {
                    assert_eq!(intersects(&p, &q), expected, "{p:?} {q:?}");
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
    fn every_pattern_of_signs_has_an_apex() {
        for pattern in 0..27 {
            let sides = [pattern / 9, pattern / 3 % 3, pattern % 3].map(|sign| sign - 1);
            if sides == [0; 3] || one_sided(&sides) {
                continue;
            }
            let (corner, side) = apex(&sides);
            let others = [1, 2].map(|k| sides[(corner + k) % 3]);
            assert!(side != 0 && others.iter().all(|&other| other * side <= 0), "{sides:?}");
            assert!(others.iter().all(|&other| other != sides[corner]), "{sides:?}");
            assert!(sides[corner] == 0 || sides[corner] == side, "{sides:?}");
        }
    }
}
