//! Near points of two triangles, in f64, and what they prove.

use glam::DVec3;

/// 2^-500, above lengths whose squares underflow in f64, or nearly do.
pub(crate) const UNDERFLOW: f64 = 3.054_936_363_499_605e-151;

/// Near points of two triangles. They are found by a fixed sequence of operations, so that equal corners have equal points.
///
/// With R the largest absolute coordinate of a corner relative to the first of `a`, both lengths are off by less than
/// 64 · 2^-53 · R, and by [`UNDERFLOW`]: the bounds of `bvtt::nearest`, where u is that of f64.
pub(crate) struct Nearest {
    /// One of each: the nearest but for rounding, unless the triangles intersect.
    pub(crate) points: [DVec3; 2],
    /// How far they are apart: no less than the triangles, but for the error.
    pub(crate) length: f64,
    /// How far the triangles are apart along the line through both, and so no more than they are, but for the error. Less than
    /// 0 if that line proves nothing.
    pub(crate) apart: f64,
}

/// Two features of two triangles: those that have points near each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// An edge of each, by its first corner.
    Edges([usize; 2]),
    /// The face of the first triangle (0) or the second (1), and a corner of the other.
    Face { of: usize, corner: usize },
}

/// Near points of two triangles whose corners are in range: those of an edge of each, or of a corner and the other triangle.
pub(crate) fn nearest(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> Nearest {
    let origin = DVec3::from_array(a[0]);
    let [a, b] = [a, b].map(|t| t.map(|p| DVec3::from_array(p) - origin));
    let (best, _) = near_points([&a, &b], [3; 2]);
    let along = best[1] - best[0];
    let length = along.length();
    let (of_a, of_b) = (a.map(|p| p.dot(along)), b.map(|p| p.dot(along)));
    let begin = of_b[0].min(of_b[1]).min(of_b[2]);
    let gap = begin - of_a[0].max(of_a[1]).max(of_a[2]);
    let apart = if length > UNDERFLOW { gap / length } else { -1.0 };
    Nearest { points: best.map(|p| p + origin), length, apart }
}

/// Near points of two triangles, and the features that have them. A segment has its first two corners, and a point the first: they are
/// one edge, from the first corner to the second.
#[inline(always)]
pub(crate) fn near_points([a, b]: [&[DVec3; 3]; 2], corners: [usize; 2]) -> ([DVec3; 2], Feature) {
    let edges = corners.map(|corners| if corners == 3 { 3 } else { 1 });
    let (mut best, mut feature) = ([a[0], b[0]], Feature::Edges([0; 2]));
    let mut least = (best[1] - best[0]).length_squared();
    let mut take = |points: [DVec3; 2], of: Feature| {
        let square = (points[1] - points[0]).length_squared();
        if square < least {
            (least, best, feature) = (square, points, of);
        }
    };
    for k in 0..edges[0] {
        for l in 0..edges[1] {
            let points = of_edges([a[k], a[(k + 1) % 3]], [b[l], b[(l + 1) % 3]]);
            take(points, Feature::Edges([k, l]));
        }
    }
    for corner in 0..3 {
        if corners[1] == 3 && corner < corners[0] {
            take([a[corner], in_face(b, a[corner])], Feature::Face { of: 1, corner });
        }
        if corners[0] == 3 && corner < corners[1] {
            take([in_face(a, b[corner]), b[corner]], Feature::Face { of: 0, corner });
        }
    }
    (best, feature)
}

/// Near points of two segments (Ericson, *Real-Time Collision Detection*, 5.1.9).
fn of_edges([p, p_end]: [DVec3; 2], [q, q_end]: [DVec3; 2]) -> [DVec3; 2] {
    let (g, h, w) = (p_end - p, q_end - q, p - q);
    let (n, gh) = (g.cross(h), g.dot(h));
    // As products of normals: of dots, those of edges nearly in parallel would cancel.
    let s = clamped(h.cross(w).dot(n) / n.dot(n));
    let t = clamped((gh * s + h.dot(w)) / h.dot(h));
    let s = clamped((gh * t - g.dot(w)) / g.dot(g));
    [p + g * s, q + h * t]
}

/// A point of a face that is near `y`: the nearest if that is inside.
fn in_face([p, q, r]: &[DVec3; 3], y: DVec3) -> DVec3 {
    let (g, h, w) = (*q - *p, *r - *p, y - *p);
    let n = g.cross(h);
    let inverse = 1.0 / n.dot(n);
    let s = clamped(w.cross(h).dot(n) * inverse);
    let t = clamped(g.cross(w).dot(n) * inverse).min(1.0 - s);
    *p + g * s + h * t
}

/// Between 0 and 1; 0 if it is not a number.
fn clamped(x: f64) -> f64 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}
