//! Certificates that two moving triangles stay apart: a separating direction that stands still, and one that moves with a feature.

use super::pair::{MovingPair, UNDERFLOWN, UNIT};
use crate::triangle::Feature;
use glam::DVec3;

/// A height has to exceed so much of |n|₁, where coordinates are at most 1. Each of the two heights along n is off by 4 u |n|₁: of a coordinate
/// 1 u, of a product 1 u, of the sum 2 u; and their difference, at most 2 |n|₁, by 2 u |n|₁ more. This is 10 u at each end, and so at
/// each time. The line between two ends as it is evaluated at a time is off by 3 u of 2 |n|₁, and its root, with three roundings, is so
/// late that the line has lost 3 u of 2 |n|₁ there. In all 22 u |n|₁.
pub(super) const HEIGHT: f64 = 32.0 * UNIT;

/// A coefficient of a cubic has to exceed so much of the product of the ranges, m. A difference of two corners at a time is off by 9 u of the
/// range along each axis: each corner by 4 u, and the difference by 1 u. A coefficient has six products of three differences, or twelve to
/// eighteen over 3: each is off by 27 u for its factors and by at most 8 u for its multiplications and sums. These are 210 u m. Subdivision
/// rounds three times, by 2 u of at most 6 m: 36 u m more.
pub(super) const CUBIC: f64 = 512.0 * UNIT;

/// How often the time up to which a direction that moves with a feature separates is halved.
const BISECTIONS: usize = 8;

/// A cubic of time by its Bernstein coefficients.
pub(super) type Cubic = [f64; 4];

impl MovingPair {
    /// The time up to which the direction `n` certainly separates the triangles, the second above the first, from `time` on: all through the
    /// interval, with both of its ends. `time` itself if the direction does not even separate there, or not for long.
    ///
    /// The height of each corner of the second above each of the first is linear in time: it is positive between two times if it is at both.
    /// This holds for any `n`, however it was found.
    #[inline]
    pub(super) fn advance(&self, time: f64, n: DVec3) -> f64 {
        let margin = (n.x.abs() + n.y.abs() + n.z.abs()) * HEIGHT + UNDERFLOWN;
        let [of_start, of_end] = self.ends.each_ref().map(|corners| corners.map(|p| n.dot(p)));
        let mut until = 1.0;
        for i in 0..self.corners[0] {
            for j in 3..3 + self.corners[1] {
                let (start, end) = (of_start[j] - of_start[i], of_end[j] - of_end[i]);
                if end > margin {
                    if start > margin || start * (1.0 - time) + end * time > margin {
                        continue;
                    }
                    return time;
                }
                // NaN is no height above the margin.
                if start > margin && end <= margin {
                    let root = (start - margin) / (start - end);
                    if root < until {
                        until = root;
                    }
                } else {
                    return time;
                }
            }
        }
        if until > time { until } else { time }
    }

    /// The same along the normal of a feature, which moves with it: the cross product of two edges, quadratic in time, so that heights along
    /// it are cubics. `corners` are those at `time`.
    ///
    /// The corners of a face are at one height along its normal, and the ends of an edge along a normal of it: what is left are three corners
    /// above a face, or two above two. A cubic is positive where its coefficients are; and if those of the part up to a time are, so are
    /// those of every shorter part, so that the time is found by bisection.
    #[inline]
    pub(super) fn advance_with(&self, time: f64, corners: &[DVec3; 6], feature: Feature) -> f64 {
        let margin = self.volume() * CUBIC + UNDERFLOWN;
        let (cubics, len) = self.heights(corners, feature);
        let cubics = &cubics[..len];
        // The second is above the first along the normal or against it.
        let sign = if cubics[0][0] > 0.0 { 1.0 } else { -1.0 };
        let is_above = |part: f64| {
            cubics.iter().all(|c| first_part(c, part).iter().all(|x| sign * x > margin))
        };
        if is_above(1.0) {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if is_above(middle) { low = middle } else { high = middle }
        }
        // Three roundings may have made it later by 4 u; or it is earlier than `time`.
        let until = (time + (1.0 - time) * low) * (1.0 - 8.0 * UNIT);
        if until > time { until } else { time }
    }

    /// The heights of the corners of the second triangle above those of the first along the normal of a feature, from the time of `corners`
    /// to the end.
    #[inline]
    fn heights(&self, corners: &[DVec3; 6], feature: Feature) -> ([Cubic; 4], usize) {
        let ends = [corners, &self.ends[1]];
        let edge = |from: usize, to: usize| ends.map(|p| p[to] - p[from]);
        let (mut cubics, mut len) = ([[0.0; 4]; 4], 0);
        match feature {
            Feature::Face { of, .. } => {
                let (own, other) = (3 * of, 3 - 3 * of);
                let normal = normal(edge(own, own + 1), edge(own, own + 2));
                for corner in other..other + self.corners[1 - of] {
                    cubics[len] = height(&normal, edge(own, corner));
                    len += 1;
                }
            }
            Feature::Edges([k, l]) => {
                let [[a, a_end, a_third], [b, b_end, b_third]] = edges([k, l]);
                let normal = normal(edge(a, a_end), edge(b, b_end));
                for below in [a, a_third] {
                    for above in [b, b_third] {
                        cubics[len] = height(&normal, edge(below, above));
                        len += 1;
                    }
                }
            }
        }
        (cubics, len)
    }
}

/// The ends of an edge of each triangle, and the corners beside them.
#[inline(always)]
pub(super) fn edges([k, l]: [usize; 2]) -> [[usize; 3]; 2] {
    let next = |k: usize| if k == 2 { 0 } else { k + 1 };
    [[k, next(k), next(next(k))], [l, next(l), next(next(l))].map(|corner| corner + 3)]
}

/// The Bernstein coefficients of the cross product of two moving vectors, the second of them twice.
#[inline(always)]
pub(super) fn normal(u: [DVec3; 2], v: [DVec3; 2]) -> [DVec3; 3] {
    [u[0].cross(v[0]), u[0].cross(v[1]) + u[1].cross(v[0]), u[1].cross(v[1])]
}

/// The Bernstein coefficients of the product of such a normal and a moving vector.
#[inline(always)]
pub(super) fn height(n: &[DVec3; 3], w: [DVec3; 2]) -> Cubic {
    const THIRD: f64 = 1.0 / 3.0;
    let inner = [n[1].dot(w[0]) + n[0].dot(w[1]), n[2].dot(w[0]) + n[1].dot(w[1])];
    [n[0].dot(w[0]), inner[0] * THIRD, inner[1] * THIRD, n[2].dot(w[1])]
}

/// The coefficients of a cubic on the first part of its interval, by de Casteljau's algorithm.
#[inline(always)]
fn first_part([c0, c1, c2, c3]: &Cubic, part: f64) -> Cubic {
    let between = |x: f64, y: f64| x * (1.0 - part) + y * part;
    let (p, q, r) = (between(*c0, *c1), between(*c1, *c2), between(*c2, *c3));
    let (s, t) = (between(p, q), between(q, r));
    [*c0, p, s, between(s, t)]
}
