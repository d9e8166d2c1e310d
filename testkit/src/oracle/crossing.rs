//! Where two triangles cross: the truth about contact points.

use super::lattice::{self, Vector, cross, dot, minus, times};
use crate::Triangle;
use num_bigint::BigInt;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// The points in which an edge of one triangle reaches into the other, each rounded once to f64.
///
/// Where the planes of the triangles differ, the segment they share is the hull of these points. An
/// edge in the plane of the other triangle adds none, since its ends belong to other edges too.
pub fn crossing_points(a: &Triangle, b: &Triangle) -> Vec<[f64; 3]> {
    let ([s, t], unit) = (lattice::wide(a, b), lattice::units(a, b));
    let mut found = Vec::new();
    for (edges, face) in [(&s, &t), (&t, &s)] {
        let normal = cross(&minus(&face[1], &face[0]), &minus(&face[2], &face[0]));
        for i in 0..3 {
            let (p, q) = (&edges[i], &edges[(i + 1) % 3]);
            let [d, e] = [p, q].map(|x| dot(&normal, &minus(x, &face[0])));
            // The point is x / w.
            let (x, w) = (minus(&times(&d, q), &times(&e, p)), &d - &e);
            let between = !w.is_zero() && !(&d * &e).is_positive();
            if between && within(face, &normal, &x, &w) {
                found.push([0, 1, 2].map(|k| f64::from(a[0][k]) + ratio(&x[k], &w) * unit[k]));
            }
        }
    }
    found
}

/// Whether the point x / w in the plane of a triangle lies in the triangle.
fn within(
    face: &[Vector<BigInt>],
    normal: &Vector<BigInt>,
    x: &Vector<BigInt>,
    w: &BigInt,
) -> bool {
    (0..3).all(|i| {
        let (p, q) = (&face[i], &face[(i + 1) % 3]);
        let inward = cross(normal, &minus(q, p));
        !(dot(&inward, &minus(x, &times(w, p))) * w).is_negative()
    })
}

/// x / w within 2^-80, and then within f64.
fn ratio(x: &BigInt, w: &BigInt) -> f64 {
    (x * (BigInt::one() << 80_u32) / w).to_f64().unwrap_or(f64::NAN) * 2f64.powi(-80)
}
