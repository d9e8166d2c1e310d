//! The distance of two triangles, as a rational number.
//!
//! The nearest points of two triangles lie inside a face of each: a vertex, an edge or the whole. There they are the nearest
//! points of the affine hulls of both faces, which the normal equations give. So every pair of faces whose equations have one
//! solution, inside both faces, has two points of the triangles, and one such pair has the nearest; where equations have more
//! solutions, a pair of smaller faces has one of them.

use super::lattice::{Coordinate, Vector, dot, minus, on_one_lattice, times};
use super::motion::{MovingTriangle, dyadic};
use super::sturm::Dyadic;
use num_bigint::BigInt;
use num_traits::{One, Signed, Zero};

/// Whether two closed triangles are at most `distance` apart.
pub fn within<C: Coordinate>(a: &[[C; 3]; 3], b: &[[C; 3]; 3], distance: C) -> bool {
    within_each(a, b, &[distance])[0]
}

/// The same for some distances.
pub fn within_each<C: Coordinate>(a: &[[C; 3]; 3], b: &[[C; 3]; 3], distances: &[C]) -> Vec<bool> {
    let ([a, b], distances) = on_one_lattice(a, b, distances);
    let candidates = candidates(&a, &b);
    let is_within = |distance: &BigInt| {
        let square = distance * distance;
        candidates.iter().any(|(length, denominator)| *length <= &square * denominator)
    };
    distances.iter().map(is_within).collect()
}

/// Whether two triangles that move are at most `distance` apart at a time between 0 and 1.
pub fn within_at(a: &MovingTriangle, b: &MovingTriangle, time: f64, distance: f64) -> bool {
    let [start, end] = [0, 1].map(|end| [a[end], b[end]].concat());
    let ([start, end], distances) = on_one_lattice(&start, &end, &[distance]);
    let Dyadic { numerator, exponent } = dyadic(time);
    let one = BigInt::from(1) << exponent;
    let before = &one - &numerator;
    let corners = start.iter().zip(&end).map(|(p, q)| {
        let (p, q) = (times(&before, p), times(&numerator, q));
        [0, 1, 2].map(|k| &p[k] + &q[k])
    });
    let corners: Vec<_> = corners.collect();
    let square = (&distances[0] * &one).pow(2);
    let candidates = candidates(&corners[..3], &corners[3..]);
    candidates.iter().any(|(length, denominator)| *length <= &square * denominator)
}

/// The squared distances of two points each, one of which are the nearest: numerators and denominators, in squared steps of
/// the lattice.
fn candidates(a: &[Vector<BigInt>], b: &[Vector<BigInt>]) -> Vec<(BigInt, BigInt)> {
    let mut found = Vec::new();
    for of_a in faces() {
        for of_b in faces() {
            let (p, q) = (&a[of_a[0]], &b[of_b[0]]);
            let along_a = of_a[1..].iter().map(|&i| minus(&a[i], p));
            let along_b = of_b[1..].iter().map(|&i| minus(q, &b[i]));
            let along: Vec<_> = along_a.chain(along_b).collect();
            found.extend(nearest(&minus(p, q), &along, of_a.len() - 1));
        }
    }
    found
}

/// The shortest w + Σ xᵢ vᵢ, squared, if one solution x has it and is inside both faces, to the first of which belong `first`
/// of the vectors.
fn nearest(w: &Vector<BigInt>, along: &[Vector<BigInt>], first: usize) -> Option<(BigInt, BigInt)> {
    let gram: Vec<Vec<_>> =
        along.iter().map(|u| along.iter().map(|v| dot(u, v)).collect()).collect();
    let right: Vec<_> = along.iter().map(|v| -dot(w, v)).collect();
    let denominator = determinant(&gram);
    if denominator.is_zero() {
        return None;
    }
    let by_cramer = |column: usize| {
        let mut replaced = gram.clone();
        for (row, value) in replaced.iter_mut().zip(&right) {
            row[column] = value.clone();
        }
        determinant(&replaced)
    };
    let x: Vec<_> = (0..along.len()).map(by_cramer).collect();
    let is_inside = |part: &[BigInt]| {
        part.iter().all(|x| !x.is_negative()) && part.iter().sum::<BigInt>() <= denominator
    };
    let (of_first, of_second) = x.split_at(first);
    if !is_inside(of_first) || !is_inside(of_second) {
        return None;
    }
    let mut z = times(&denominator, w);
    for (x, v) in x.iter().zip(along) {
        let step = times(x, v);
        z = [0, 1, 2].map(|k| &z[k] + &step[k]);
    }
    Some((dot(&z, &z), &denominator * &denominator))
}

/// The determinant of a small matrix, by its first row. It is positive or zero for a matrix of products of vectors.
fn determinant(rows: &[Vec<BigInt>]) -> BigInt {
    let Some((first, rest)) = rows.split_first() else { return BigInt::one() };
    let mut sum = BigInt::zero();
    for (column, factor) in first.iter().enumerate() {
        let minor: Vec<Vec<_>> =
            rest.iter().map(|row| [&row[..column], &row[column + 1..]].concat()).collect();
        let term = factor * determinant(&minor);
        sum += if column % 2 == 0 { term } else { -term };
    }
    sum
}

/// Three vertices, three edges and the whole.
fn faces() -> [&'static [usize]; 7] {
    [&[0], &[1], &[2], &[0, 1], &[1, 2], &[2, 0], &[0, 1, 2]]
}
