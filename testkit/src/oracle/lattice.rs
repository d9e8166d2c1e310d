//! Points as integers.
//!
//! Every f32 and f64 is an integer times a power of two. Moving both sets and stretching an axis change
//! nothing about which sets meet, so each axis gets the power of two that makes its integers small,
//! and the first point is the origin.

use num_bigint::BigInt;
use num_traits::float::FloatCore;
use num_traits::{NumRef, RefNum};
use std::ops::Shl;

/// A point or vector in integers.
pub(super) type Vector<T> = [T; 3];

/// A float.
pub trait Coordinate: FloatCore {
    /// The bits of its mantissa.
    const DIGITS: i32;
}

impl Coordinate for f32 {
    const DIGITS: i32 = 24;
}

impl Coordinate for f64 {
    const DIGITS: i32 = 53;
}

/// Integers of some width. `i128` where the numbers are small, else [`BigInt`].
pub(super) trait Integer:
    NumRef + Ord + Clone + From<i64> + Shl<u32, Output = Self>
{
    fn times(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
}

impl<T> Integer for T
where
    T: NumRef + Ord + Clone + From<i64> + Shl<u32, Output = T>,
    for<'a> &'a T: RefNum<T>,
{
    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn minus(&self, other: &Self) -> Self {
        self - other
    }
}

/// The points as `i128`, if nothing computed from them can overflow.
///
/// With coordinates below 2^30, points are shorter than √3 · 2^30 and differences than √3 · 2^31.
/// The longest normal, (w·w) d − (w·d) w, is then shorter than (√3 · 2^31)³, and no sum of its
/// products with a point exceeds 9 · 2^123 < 2^127.
pub(super) fn small<C: Coordinate>(a: &[[C; 3]], b: &[[C; 3]]) -> Option<[Vec<Vector<i128>>; 2]> {
    let axes = axes(a, b);
    if axes.iter().any(|axis| axis.highest - axis.lowest + C::DIGITS > 124) {
        return None;
    }
    let sets = on_lattice::<i128, C>(&axes, a, b);
    let fits = |v: &Vector<i128>| v.iter().all(|x| x.abs() < 1 << 30);
    sets.iter().flatten().all(fits).then_some(sets)
}

/// The points in integers of any width.
pub(super) fn wide<C: Coordinate>(a: &[[C; 3]], b: &[[C; 3]]) -> [Vec<Vector<BigInt>>; 2] {
    on_lattice(&axes(a, b), a, b)
}

/// The points and distances in integers of any width, of one lattice for all axes.
pub(super) fn on_one_lattice<C: Coordinate>(
    a: &[[C; 3]],
    b: &[[C; 3]],
    distances: &[C],
) -> ([Vec<Vector<BigInt>>; 2], Vec<BigInt>) {
    let (all, mut axes) = (a.iter().chain(b).flatten().chain(distances), axes(a, b));
    let lowest = all.map(|&x| decode(x)).filter(|x| x.0 != 0).map(|x| x.1).min().unwrap_or(0);
    axes.iter_mut().for_each(|axis| axis.lowest = lowest);
    let whole = |&distance: &C| match decode(distance) {
        (0, _) => 0.into(),
        (odd, exponent) => BigInt::from(odd) << (exponent - lowest) as u32,
    };
    (on_lattice(&axes, a, b), distances.iter().map(whole).collect())
}

/// The length of one step of the lattice along each axis.
pub(super) fn units<C: Coordinate>(a: &[[C; 3]], b: &[[C; 3]]) -> [f64; 3] {
    axes(a, b).map(|axis| 2f64.powi(axis.lowest))
}

/// The range of exponents along one axis, where a coordinate is an odd integer · 2^exponent.
struct Axis {
    lowest: i32,
    highest: i32,
}

fn axes<C: Coordinate>(a: &[[C; 3]], b: &[[C; 3]]) -> [Axis; 3] {
    [0, 1, 2].map(|axis| {
        let points = a.iter().chain(b);
        let exponents = points.map(|p| decode(p[axis])).filter(|x| x.0 != 0).map(|x| x.1);
        let (lowest, highest) = (exponents.clone().min(), exponents.max());
        Axis { lowest: lowest.unwrap_or(0), highest: highest.unwrap_or(0) }
    })
}

/// The odd integer m (or 0) and the exponent e of x = m · 2^e.
pub(super) fn decode(x: impl Coordinate) -> (i64, i32) {
    let (mantissa, exponent, sign) = x.integer_decode();
    let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() };
    ((mantissa >> zeros) as i64 * i64::from(sign), i32::from(exponent) + zeros as i32)
}

fn on_lattice<T: Integer, C: Coordinate>(
    axes: &[Axis; 3],
    a: &[[C; 3]],
    b: &[[C; 3]],
) -> [Vec<Vector<T>>; 2] {
    let integer = |p: &[C; 3]| {
        [0, 1, 2].map(|axis| match decode(p[axis]) {
            (0, _) => T::zero(),
            (odd, exponent) => T::from(odd) << (exponent - axes[axis].lowest) as u32,
        })
    };
    let origin = integer(&a[0]);
    [a, b].map(|set| set.iter().map(|p| minus(&integer(p), &origin)).collect())
}

pub(super) fn dot<T: Integer>(u: &Vector<T>, v: &Vector<T>) -> T {
    u[0].times(&v[0]) + u[1].times(&v[1]) + u[2].times(&v[2])
}

pub(super) fn cross<T: Integer>(u: &Vector<T>, v: &Vector<T>) -> Vector<T> {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| u[i].times(&v[j]) - u[j].times(&v[i]))
}

pub(super) fn minus<T: Integer>(u: &Vector<T>, v: &Vector<T>) -> Vector<T> {
    [0, 1, 2].map(|i| u[i].minus(&v[i]))
}

pub(super) fn times<T: Integer>(factor: &T, v: &Vector<T>) -> Vector<T> {
    [0, 1, 2].map(|i| factor.times(&v[i]))
}
