//! Near points of two triangles, in f64, and what they prove.

use core::ops::{Add, Div, Mul, Sub};
use glam::DVec3;

/// 2^-500, above lengths whose squares underflow in f64, or nearly do.
#[cfg(feature = "within")]
pub(crate) const UNDERFLOW: f64 = 3.054_936_363_499_605e-151;

/// Near points of two triangles. They are found by a fixed sequence of operations, so that equal corners have equal points.
///
/// With R the largest absolute coordinate of a corner relative to the first of `a`, both lengths are off by less than
/// 64 · 2^-53 · R, and by [`UNDERFLOW`]: the bounds of `bvtt::nearest`, where u is that of f64.
#[cfg(feature = "within")]
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

/// All pairs of a corner and a face, and of two edges, of two triangles of which so many corners differ.
#[cfg(feature = "motion")]
pub(crate) fn features(corners: [usize; 2]) -> impl Iterator<Item = Feature> {
    let [a, b] = corners.map(|corners| if corners == 3 { 3 } else { corners - 1 });
    let faces = (0..2_usize)
        .filter(move |&of| corners[of] == 3)
        .flat_map(move |of| (0..corners[1 - of]).map(move |corner| Feature::Face { of, corner }));
    faces.chain((0..a).flat_map(move |k| (0..b).map(move |l| Feature::Edges([k, l]))))
}

/// Near points of two triangles whose corners are in range: those of an edge of each, or of a corner and the other triangle.
#[cfg(feature = "within")]
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
    let mut least = (b[0] - a[0]).length_squared();
    let mut best = None;
    let mut of_edges = [Near::NONE; 3];
    let (starts, ends) = (side_by_side(b), side_by_side(&[b[1], b[2], b[0]]));
    for k in 0..edges[0] {
        of_edges[k] = near_edges([a[k], a[if k == 2 { 0 } else { k + 1 }]], &starts, &ends);
        for l in 0..edges[1] {
            if of_edges[k].square[l] < least {
                (least, best) = (of_edges[k].square[l], Some(Feature::Edges([k, l])));
            }
        }
    }
    let on_faces = [
        if corners[0] == 3 { on_face(a, &starts) } else { Near::NONE },
        if corners[1] == 3 { on_face(b, &side_by_side(a)) } else { Near::NONE },
    ];
    for corner in 0..3 {
        for of in [1, 0] {
            let square = on_faces[of].square[corner];
            if corners[of] == 3 && corner < corners[1 - of] && square < least {
                (least, best) = (square, Some(Feature::Face { of, corner }));
            }
        }
    }
    let points = match best {
        None => [a[0], b[0]],
        Some(Feature::Edges([k, l])) => {
            let ([p, q], next) = ([a[k], b[l]], |k: usize| if k == 2 { 0 } else { k + 1 });
            let [s, t] = of_edges[k].at[l];
            [p + (a[next(k)] - p) * s, q + (b[next(l)] - q) * t]
        }
        Some(Feature::Face { of, corner }) => {
            let (face, y) = if of == 0 { (a, b[corner]) } else { (b, a[corner]) };
            let [s, t] = on_faces[of].at[corner];
            let point = face[0] + (face[1] - face[0]) * s + (face[2] - face[0]) * t;
            if of == 0 { [point, y] } else { [y, point] }
        }
    };
    (points, best.unwrap_or(Feature::Edges([0; 2])))
}

/// Near points of one feature and three others, by their parameters, and their squared distances.
#[derive(Clone, Copy)]
struct Near {
    at: [[f64; 2]; 3],
    square: [f64; 3],
}

impl Near {
    const NONE: Self = Self { at: [[0.0; 2]; 3], square: [f64::INFINITY; 3] };

    #[inline(always)]
    fn new(s: Lanes, t: Lanes, x: Vectors, y: Vectors) -> Self {
        let square = length_squared(difference(y, x)).0;
        let at = |lane: usize| [s.0[lane], t.0[lane]];
        Self { at: [at(0), at(1), at(2)], square: [square[0], square[1], square[2]] }
    }
}

/// Near points of a segment and three others (Ericson, *Real-Time Collision Detection*, 5.1.9).
#[inline(always)]
fn near_edges([p, p_end]: [DVec3; 2], q: &Vectors, q_end: &Vectors) -> Near {
    let (p, g, h) = (splat(p), splat(p_end - p), difference(*q_end, *q));
    let w = difference(p, *q);
    let (n, gh) = (cross(g, h), dot(g, h));
    // As products of normals: of dots, those of edges nearly in parallel would cancel.
    let s = (dot(cross(h, w), n) / dot(n, n)).clamped();
    let t = ((gh * s + dot(h, w)) / dot(h, h)).clamped();
    let s = ((gh * t - dot(g, w)) / dot(g, g)).clamped();
    Near::new(s, t, along(p, g, s), along(*q, h, t))
}

/// Points of a face that are near three others: the nearest if they are inside.
#[inline(always)]
fn on_face(&[p, q, r]: &[DVec3; 3], y: &Vectors) -> Near {
    let (g, h) = (q - p, r - p);
    let n = g.cross(h);
    let inverse = Lanes([1.0 / n.dot(n); 4]);
    let (p, g, h, n) = (splat(p), splat(g), splat(h), splat(n));
    let w = difference(*y, p);
    let s = (dot(cross(w, h), n) * inverse).clamped();
    let t = (dot(cross(g, w), n) * inverse).clamped().least(Lanes([1.0; 4]) - s);
    Near::new(s, t, along(along(p, g, s), h, t), *y)
}

/// Four numbers side by side, of which three are used: compilers put them into vector registers.
#[derive(Clone, Copy)]
struct Lanes([f64; 4]);

/// Vectors side by side.
type Vectors = [Lanes; 3];

impl Lanes {
    #[inline(always)]
    fn each(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let ([p, q, r, s], [t, u, v, w]) = (self.0, other.0);
        Self([of(p, t), of(q, u), of(r, v), of(s, w)])
    }

    /// The less of both; the other if one is not a number.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.each(other, |x, y| if x < y { x } else { y })
    }

    /// Between 0 and 1; 0 if it is not a number.
    #[inline(always)]
    fn clamped(self) -> Self {
        self.each(Self([0.0; 4]), |x, y| if x > y { x } else { y }).least(Self([1.0; 4]))
    }
}

macro_rules! each {
    ($($trait:ident $method:ident),*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.each(other, f64::$method)
            }
        }
    )*};
}

each!(Add add, Sub sub, Mul mul, Div div);

#[inline(always)]
fn side_by_side([p, q, r]: &[DVec3; 3]) -> Vectors {
    [Lanes([p.x, q.x, r.x, r.x]), Lanes([p.y, q.y, r.y, r.y]), Lanes([p.z, q.z, r.z, r.z])]
}

#[inline(always)]
fn splat(p: DVec3) -> Vectors {
    [Lanes([p.x; 4]), Lanes([p.y; 4]), Lanes([p.z; 4])]
}

#[inline(always)]
fn difference(p: Vectors, q: Vectors) -> Vectors {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// The points p + s g.
#[inline(always)]
fn along(p: Vectors, g: Vectors, s: Lanes) -> Vectors {
    [p[0] + g[0] * s, p[1] + g[1] * s, p[2] + g[2] * s]
}

#[inline(always)]
fn dot(p: Vectors, q: Vectors) -> Lanes {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline(always)]
fn length_squared(p: Vectors) -> Lanes {
    dot(p, p)
}

#[inline(always)]
fn cross(p: Vectors, q: Vectors) -> Vectors {
    let minor = |j: usize, k: usize| p[j] * q[k] - q[j] * p[k];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}
