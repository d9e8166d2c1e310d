//! Guigue & Devillers 2003: nothing but signs of orientation determinants.
//!
//! Corners are renamed so that the first of each triangle is alone on its side of the other's plane, or in
//! it; two determinants then compare the ends of the intervals on the common line. Coplanar triangles
//! are decided by signs in projection, by separating edges and not by the paper's decision tree, which
//! asks for fewer of them.

use std::ops::{Mul, Sub};

/// The arithmetic.
pub(super) trait Real:
    Copy + PartialOrd + Default + Sub<Output = Self> + Mul<Output = Self> + std::ops::Add<Output = Self>
{
}

impl Real for f32 {}
impl Real for f64 {}

type Point<T> = [T; 3];

pub(super) fn meet<T: Real + From<C>, C: Copy>(a: &[Point<C>; 3], b: &[Point<C>; 3]) -> bool {
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(T::from)));
    let sides = |t: &[Point<T>; 3], points: &[Point<T>; 3]| {
        let normal = cross(&minus(&t[1], &t[0]), &minus(&t[2], &t[0]));
        points.map(|p| sign(dot(&normal, &minus(&p, &t[0]))))
    };
    let one_sided = |s: &[i8; 3]| s[0] * s[1] > 0 && s[0] * s[2] > 0;
    let a_sides = sides(&b, &a);
    if one_sided(&a_sides) {
        return false;
    }
    let b_sides = sides(&a, &b);
    if one_sided(&b_sides) {
        return false;
    }
    let (Some((i, a_up)), Some((j, b_up))) = (alone(&a_sides), alone(&b_sides)) else {
        return coplanar(&a, &b);
    };
    let turned = |t: &[Point<T>; 3], i: usize, swap: bool| {
        let [p, q, r] = [t[i], t[(i + 1) % 3], t[(i + 2) % 3]];
        if swap { [p, r, q] } else { [p, q, r] }
    };
    // With p above the other's plane, where q and r are turned as their triangle's orientation asks.
    let [p1, q1, r1] = turned(&a, i, !b_up);
    let [p2, q2, r2] = turned(&b, j, !a_up);
    orientation(&p1, &q1, &p2, &q2) <= 0 && orientation(&p1, &r1, &r2, &p2) <= 0
}

/// The corner that is alone on its side of a plane, and whether it counts as above it; `None` if all are
/// in it.
fn alone(sides: &[i8; 3]) -> Option<(usize, bool)> {
    let others = |i: usize| [sides[(i + 1) % 3], sides[(i + 2) % 3]];
    let above = |&i: &usize| sides[i] > 0 && others(i).iter().all(|s| *s <= 0);
    let below = |&i: &usize| sides[i] < 0 && others(i).iter().all(|s| *s >= 0);
    let between = |&i: &usize| sides[i] == 0 && others(i)[0] * others(i)[1] > 0;
    let first = |is: &dyn Fn(&usize) -> bool| (0..3).find(|i| is(i));
    first(&above)
        .map(|i| (i, true))
        .or_else(|| first(&below).map(|i| (i, false)))
        .or_else(|| first(&between).map(|i| (i, others(i)[0] < 0)))
}

fn coplanar<T: Real>(a: &[Point<T>; 3], b: &[Point<T>; 3]) -> bool {
    let normal = cross(&minus(&a[1], &a[0]), &minus(&a[2], &a[0]));
    let size = normal.map(|x| if x < T::default() { T::default() - x } else { x });
    let axis = (1..3).fold(0, |most, k| if size[k] > size[most] { k } else { most });
    let turn = |p: &Point<T>, q: &Point<T>, r: &Point<T>| {
        let (u, v) = (minus(q, p), minus(r, p));
        sign(cross(&u, &v)[axis])
    };
    let counter_clockwise = |t: &[Point<T>; 3]| {
        if turn(&t[0], &t[1], &t[2]) < 0 { [t[0], t[2], t[1]] } else { *t }
    };
    let [a, b] = [counter_clockwise(a), counter_clockwise(b)];
    let separates = |t: &[Point<T>; 3], others: &[Point<T>; 3]| {
        (0..3).any(|i| others.iter().all(|p| turn(&t[i], &t[(i + 1) % 3], p) < 0))
    };
    !separates(&a, &b) && !separates(&b, &a)
}

/// On which side of the plane through a, b, c the point d lies.
fn orientation<T: Real>(a: &Point<T>, b: &Point<T>, c: &Point<T>, d: &Point<T>) -> i8 {
    sign(dot(&cross(&minus(b, a), &minus(c, a)), &minus(d, a)))
}

fn minus<T: Real>(p: &Point<T>, q: &Point<T>) -> Point<T> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn cross<T: Real>(u: &Point<T>, v: &Point<T>) -> Point<T> {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot<T: Real>(u: &Point<T>, v: &Point<T>) -> T {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn sign<T: Real>(x: T) -> i8 {
    i8::from(x > T::default()) - i8::from(x < T::default())
}
