//! Exact truth: in which regions two triangles have single points in common.
//!
//! The library decides signs of orientation determinants, case by case. Here there are no cases. A point of a region is a sum of its corners
//! with positive weights that add up to 1, and the point that two regions have in common solves linear equations in the weights of both: three
//! for the coordinates and two for the sums. They are solved in integers without fractions (Bareiss 1968).

use super::lattice::{cross, minus};

/// A triangle of small integers.
pub type OnLattice = [[i128; 3]; 3];

/// The corners of each region: three corners, three edges, the face.
const REGIONS: [&[usize]; 7] = [&[0], &[1], &[2], &[0, 1], &[1, 2], &[2, 0], &[0, 1, 2]];

/// How two triangles meet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Meet {
    /// The regions of both, by their numbers, that have exactly one point in common; sorted.
    pub corners: Vec<[usize; 2]>,
    /// These points, each with its divisor.
    pub points: Vec<([i128; 3], i128)>,
    /// The dimension of what the triangles have in common.
    pub dimension: usize,
    /// Whether their faces cross.
    pub is_proper: bool,
}

/// How two closed triangles meet, or `None` if they do not.
pub fn meet(a: &OnLattice, b: &OnLattice) -> Option<Meet> {
    let (mut found, mut weights) = (Meet::default(), [[false; 3]; 2]);
    for (r, of_a) in REGIONS.iter().enumerate() {
        for (s, of_b) in REGIONS.iter().enumerate() {
            let corners =
                |of: &[usize], t: &OnLattice| -> Vec<_> { of.iter().map(|&i| t[i]).collect() };
            let Some((solution, divisor)) = common_point(&corners(of_a, a), &corners(of_b, b))
            else {
                continue;
            };
            found.corners.push([r, s]);
            let sum = |axis: usize| of_a.iter().zip(&solution).map(|(&i, w)| w * a[i][axis]).sum();
            found.points.push(([0, 1, 2].map(sum), divisor));
            of_a.iter().for_each(|&i| weights[0][i] = true);
            of_b.iter().for_each(|&i| weights[1][i] = true);
        }
    }
    found.dimension = dimension(&found.points)?;
    let [n, m] = [a, b].map(|t| cross(&minus(&t[1], &t[0]), &minus(&t[2], &t[0])));
    // The mean of all corners is in both faces.
    found.is_proper = found.dimension == 1 && cross(&n, &m) != [0; 3] && weights == [[true; 3]; 2];
    Some(found)
}

/// The weights, times a positive divisor, of the point that is the only one in the interiors of both hulls, if there is one.
fn common_point(p: &[[i128; 3]], q: &[[i128; 3]]) -> Option<(Vec<i128>, i128)> {
    let unknowns = p.len() + q.len();
    if unknowns > 5 {
        return None;
    }
    let mut rows: Vec<Vec<i128>> = (0..3)
        .map(|axis| {
            let signed = q.iter().map(|x| -x[axis]);
            p.iter().map(|x| x[axis]).chain(signed).chain([0]).collect()
        })
        .collect();
    for (of_p, of_q) in [(1, 0), (0, 1)] {
        let sums = p.iter().map(|_| of_p).chain(q.iter().map(|_| of_q)).chain([1]);
        rows.push(sums.collect());
    }
    // After each step the columns so far are those of a multiple of the identity.
    let mut divisor = 1;
    for column in 0..unknowns {
        let pivot = (column..rows.len()).find(|&row| rows[row][column] != 0)?;
        rows.swap(column, pivot);
        let own = rows[column].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(at, _)| *at != column) {
            let factor = row[column];
            for (x, y) in row.iter_mut().zip(&own) {
                *x = (*x * own[column] - factor * y) / divisor;
            }
        }
        divisor = own[column];
    }
    if rows[unknowns..].iter().any(|row| row[unknowns] != 0) {
        return None;
    }
    let solution: Vec<_> =
        rows[..unknowns].iter().map(|row| row[unknowns] * divisor.signum()).collect();
    solution.iter().all(|weight| *weight > 0).then(|| (solution, divisor.abs()))
}

/// The dimension of the hull of points, each with a divisor; `None` if there are none.
fn dimension(points: &[([i128; 3], i128)]) -> Option<usize> {
    let (first, by) = points.first()?;
    let towards =
        points.iter().map(|(p, of)| [0, 1, 2].map(|axis| p[axis] * by - first[axis] * of));
    let directions: Vec<_> = towards.filter(|d| *d != [0; 3]).collect();
    let Some(own) = directions.first() else { return Some(0) };
    let is_along = |d: &[i128; 3]| cross(own, d) == [0; 3];
    Some(if directions.iter().all(is_along) { 1 } else { 2 })
}
