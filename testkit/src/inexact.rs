//! Triangle tests in floating point that may be wrong, to compare with an exact one.
//!
//! Both are the test of Devillers and Guigue (*Faster Triangle-Triangle Intersection Tests*, INRIA RR-4488, 2002), as
//! `pfront_core::triangle` writes it, by other signs of orientation determinants: those that a bound of rounding errors
//! certifies, or those of plain f32.

use crate::{Point, Triangle};
use glam::{DVec3, Vec3, Vec3A, Vec4};

/// Whether two closed triangles intersect by signs that f32 or else f64 certifies. No hit is missed: a pair with an uncertain
/// sign counts as one.
#[inline]
#[must_use]
pub fn conservative(a: &Triangle, b: &Triangle) -> bool {
    let certified = intersect::<CertifiedF32>(a, b);
    certified.or_else(|| intersect::<CertifiedF64>(a, b)).unwrap_or(true)
}

/// Whether two closed triangles intersect by signs of plain f32, any of which may be wrong.
#[inline]
#[must_use]
pub fn fast(a: &Triangle, b: &Triangle) -> bool {
    // No sign is uncertain here.
    intersect::<Plain>(a, b) == Some(true)
}

/// A way to decide the sides of a plane through three points on which others lie; `None` if one of them is uncertain.
trait Signs {
    fn sides<const N: usize>(plane: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]>;
}

enum Plain {}
enum CertifiedF32 {}
enum CertifiedF64 {}

impl Signs for Plain {
    #[inline]
    fn sides<const N: usize>(plane: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]> {
        Some(plain_sides(plane, points))
    }
}

impl Signs for CertifiedF32 {
    /// Up to four points side by side.
    #[inline]
    fn sides<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]> {
        const ERROR: f32 = 2.9e-6;
        const UNDERFLOW: f32 = 7.888_609e-31;
        const MAX_EXTENT: f32 = 1.099_511_6e12;
        let base = Vec3A::from_array(*a);
        let (u, v) = (Vec3A::from_array(*b) - base, Vec3A::from_array(*c) - base);
        let (normal, edges) = (u.cross(v), u.abs().max(v.abs()));
        if let [p] = points.as_slice() {
            let w = Vec3A::from_array(**p) - base;
            let (determinant, extent) = (normal.dot(w), edges.max(w.abs()));
            let bound = extent.x * extent.y * extent.z * ERROR + UNDERFLOW;
            let certified = determinant.abs() > bound && extent.max_element() <= MAX_EXTENT;
            return certified.then_some([if determinant > 0.0 { 1 } else { -1 }; N]);
        }
        let [p, q, r, s] = [0, 1, 2, 3].map(|lane: usize| points[lane.min(N - 1)]);
        let w = |k: usize| Vec4::new(p[k], q[k], r[k], s[k]) - Vec4::splat(a[k]);
        let (x, y, z) = (w(0), w(1), w(2));
        let determinant = normal.x * x + normal.y * y + normal.z * z;
        let extent = |edges: f32, w: Vec4| Vec4::splat(edges).max(w.abs());
        let (x, y, z) = (extent(edges.x, x), extent(edges.y, y), extent(edges.z, z));
        let bound = x * y * z * ERROR + Vec4::splat(UNDERFLOW);
        let holds = x.max(y).max(z).cmple(Vec4::splat(MAX_EXTENT));
        let positive = (determinant.cmpgt(bound) & holds).bitmask();
        let negative = (determinant.cmplt(-bound) & holds).bitmask();
        let sign = |lane: usize| 2 * (positive >> lane & 1) as i32 - 1;
        (positive | negative == 0xf).then(|| std::array::from_fn(sign))
    }
}

impl Signs for CertifiedF64 {
    #[inline]
    fn sides<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> Option<[i32; N]> {
        let (u, v, w) = (difference(b, a), difference(c, a), points.map(|p| difference(p, a)));
        let normal = u.cross(v);
        let extent = w.iter().fold(u.abs().max(v.abs()), |extent, w| extent.max(w.abs()));
        let bound = 5.4e-15 * extent.element_product();
        let signs = w.map(|w| {
            let determinant = normal.dot(w);
            i32::from(determinant > bound) - i32::from(determinant < -bound)
        });
        (!signs.contains(&0)).then_some(signs)
    }
}

#[inline]
fn plain_sides<const N: usize>([a, b, c]: [&Point; 3], points: [&Point; N]) -> [i32; N] {
    let edge = |p: &Point| Vec3::from_array(*p) - Vec3::from_array(*a);
    let normal = edge(b).cross(edge(c));
    points.map(|p| sign(normal.dot(edge(p))))
}

/// Zero for zero and for NaN.
fn sign(x: f32) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

fn difference(p: &Point, q: &Point) -> DVec3 {
    Vec3::from_array(*p).as_dvec3() - Vec3::from_array(*q).as_dvec3()
}

#[inline]
fn intersect<K: Signs>(a: &Triangle, b: &Triangle) -> Option<bool> {
    let a_sides = K::sides(b.each_ref(), a.each_ref());
    if a_sides.is_some_and(one_sided) {
        return Some(false);
    }
    let b_sides = K::sides(a.each_ref(), b.each_ref());
    if b_sides.is_some_and(one_sided) {
        return Some(false);
    }
    let (a_sides, b_sides) = (a_sides?, b_sides?);
    if a_sides == [0; 3] || b_sides == [0; 3] {
        // No bound certifies a zero, so that the signs are those of plain f32.
        return Some(coplanar_intersect(a, b));
    }
    let ((i, delta), (j, side)) = (apex(a_sides), apex(b_sides));
    let ([a0, a1, a2], [b0, b1, b2]) = (rotated(a, i), rotated(b, j));
    let [b1, b2] = if delta == side { [b1, b2] } else { [b2, b1] };
    let (first, second) = (K::sides([a0, a1, b0], [b1])?, K::sides([a0, a2, b0], [b2])?);
    Some((first != [side]) & (second != [-side]))
}

fn one_sided(sides: [i32; 3]) -> bool {
    sides[0] != 0 && sides[0] == sides[1] && sides[0] == sides[2]
}

/// The corner alone on its side of the other plane, and that side.
#[inline]
fn apex([p, q, r]: [i32; 3]) -> (usize, i32) {
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

#[inline]
fn rotated([p, q, r]: &Triangle, first: usize) -> [&Point; 3] {
    match first {
        0 => [p, q, r],
        1 => [q, r, p],
        _ => [r, p, q],
    }
}

/// Whether two triangles in one plane intersect, or two of which one is degenerate.
#[cold]
fn coplanar_intersect(a: &Triangle, b: &Triangle) -> bool {
    match (projection(a), projection(b)) {
        (Some(p), Some(q)) => {
            let turn = if p.0 == q.0 { q.1 } else { turn(flat(b, p.0)) };
            polygons_intersect(&flat(a, p.0), p.1, &flat(b, p.0), turn)
        }
        (_, None) => segment_intersects(extremes(b), a),
        (None, Some(_)) => segment_intersects(extremes(a), b),
    }
}

fn segment_intersects(s: [Point; 2], t: &Triangle) -> bool {
    match plain_sides(t.each_ref(), s.each_ref()) {
        [x, y] if x * y > 0 => false,
        [0, 0] => match projection(t) {
            Some((axis, turn)) => polygons_intersect(&flat(&s, axis), 1, &flat(t, axis), turn),
            None => segments_intersect(s, extremes(t)),
        },
        _ => {
            let ([p, q], [a, b, c]) = (&s, t);
            let side = |from, to| plain_sides([p, q, from], [to])[0];
            let sides = [side(a, b), side(b, c), side(c, a)];
            !(sides.contains(&1) && sides.contains(&-1))
        }
    }
}

fn segments_intersect(s: [Point; 2], r: [Point; 2]) -> bool {
    let [[p, q], [u, v]] = [s, r].map(|[p, q]| if p < q { [p, q] } else { [q, p] });
    if q < u || v < p || plain_sides([&p, &q, &u], [&v]) != [0] {
        return false;
    }
    (0..3).all(|axis| polygons_intersect(&flat(&s, axis), 1, &flat(&r, axis), 1))
}

/// An axis along which the projection of a triangle has an area, and the turn of the corners there.
fn projection(t: &Triangle) -> Option<(usize, i32)> {
    let normal = difference(&t[1], &t[0]).cross(difference(&t[2], &t[0]));
    let largest = normal.abs().max_position();
    let turns = [0, 1, 2].map(|k| (largest + k) % 3).map(|axis| (axis, turn(flat(t, axis))));
    turns.into_iter().find(|&(_, turn)| turn != 0)
}

fn turn([a, b, c]: [[f32; 2]; 3]) -> i32 {
    sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// Points projected along an axis.
fn flat<const N: usize>(points: &[Point; N], axis: usize) -> [[f32; 2]; N] {
    points.map(|p| [p[(axis + 1) % 3], p[(axis + 2) % 3]])
}

/// The ends of a degenerate triangle.
fn extremes(t: &Triangle) -> [Point; 2] {
    t.iter().fold([t[0]; 2], |[low, high], &p| {
        [if p < low { p } else { low }, if p > high { p } else { high }]
    })
}

fn polygons_intersect(p: &[[f32; 2]], p_turn: i32, q: &[[f32; 2]], q_turn: i32) -> bool {
    let separates = |p: &[[f32; 2]], p_turn: i32, q: &[[f32; 2]]| {
        let mut edges = p.iter().zip(p.iter().skip(1).chain(p));
        edges.any(|(&from, &to)| q.iter().all(|&x| turn([from, to, x]) * p_turn < 0))
    };
    !separates(p, p_turn, q) && !separates(q, q_turn, p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families::Family;
    use crate::oracle;
    use crate::rng::{RngExt, seeded};

    #[test]
    fn conservative_misses_nothing() {
        let mut rng = seeded(17);
        for family in Family::ALL {
            for _ in 0..200 {
                let (a, b) = family.pair(&mut rng);
                let truth = oracle::intersect(&a, &b);
                assert!(conservative(&a, &b) || !truth, "{family:?} {a:?} {b:?}");
            }
        }
    }

    /// In small whole coordinates f32 makes no error.
    #[test]
    fn plain_f32_is_right_where_it_is_exact() {
        let mut rng = seeded(18);
        for size in [1, 2, 9_i8] {
            for _ in 0..4_000 {
                let mut corner = |_| [0; 3].map(|_| f32::from(rng.random_range(-size..=size)));
                let (a, b) = ([0; 3].map(&mut corner), [0; 3].map(&mut corner));
                assert_eq!(fast(&a, &b), oracle::intersect(&a, &b), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn each_is_wrong_in_its_own_way() {
        const FLOOR: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        // No bound certifies that sides are zero.
        let beside = [[3.0, 3.0, 0.0], [9.0, 3.0, 0.0], [3.0, 9.0, 0.0]];
        assert_eq!([conservative(&FLOOR, &beside), fast(&FLOOR, &beside)], [true, false]);
        // Determinants of 1e-50 are zero in f32.
        let small = |z: f32| FLOOR.map(|[x, y, _]| [1e-20 * x, 1e-20 * y, z]);
        let apart = (&small(0.0), &small(1e-10));
        assert_eq!([conservative(apart.0, apart.1), fast(apart.0, apart.1)], [false, true]);
    }
}
