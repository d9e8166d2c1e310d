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

/// A length times this is no less than it is, after its six roundings.
const LENGTH: f64 = 1.0 + 16.0 * UNIT;

/// The square of a length loses less than 2^-1070 by underflow, and so the length less than 2^-500.
const SHORTEST: f64 = 3.054_936_363_499_605e-151;

/// How often the time up to which a direction that moves with a feature separates is improved, at most.
const IMPROVEMENTS: usize = 12;

/// A cubic of time by its Bernstein coefficients.
pub(super) type Cubic = [f64; 4];

impl MovingPair {
    /// The time up to which the direction `n` certainly separates the triangles, the second above the first, from `time` on: all through the
    /// interval, with both of its ends. `time` itself if the direction does not even separate there, or not for long.
    ///
    /// The height of each corner of the second above each of the first is linear in time: it is positive between two times if it is at both.
    /// This holds for any `n`, however it was found. Triangles are farther apart than a distance d where heights exceed d |n|. The
    /// root is rounded no more than without it: a height less d |n| is no greater than the height.
    #[inline]
    pub(super) fn advance(&self, time: f64, n: DVec3) -> f64 {
        let mut margin = (n.x.abs() + n.y.abs() + n.z.abs()) * HEIGHT + UNDERFLOWN;
        if self.distance > 0.0 {
            margin += self.distance * (n.length() * LENGTH + SHORTEST);
        }
        let (mut of_start, mut of_end) = ([0.0; 6], [0.0; 6]);
        for k in 0..6 {
            (of_start[k], of_end[k]) = (n.dot(self.ends[0][k]), n.dot(self.ends[1][k]));
        }
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
    /// those of every shorter part. The time is found by false position, and what is found is tested.
    #[inline]
    pub(super) fn advance_with(&self, time: f64, corners: &[DVec3; 6], feature: Feature) -> f64 {
        let certain = self.volume() * CUBIC + UNDERFLOWN;
        let (normal, mut cubics) = self.heights(corners, feature);
        let margin = if self.distance > 0.0 { certain + self.height_of(&normal) } else { certain };
        // The second is above the first along the normal or against it.
        if cubics[0][0] < 0.0 {
            cubics.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        }
        let lowest = |part: f64| lowest(&cubics, part, margin);
        let (at_end, is_above) = lowest(1.0);
        if is_above {
            return 1.0;
        }
        // False position towards a height that is certain, but only just; the end that stays counts half.
        let aim = margin + certain;
        let (mut low, mut high) = ([0.0, least(&cubics[0]) - aim], [1.0, at_end - aim]);
        let mut before = None;
        for _ in 0..IMPROVEMENTS {
            let part = low[0] + (high[0] - low[0]) * (low[1] / (low[1] - high[1]));
            if low[1] < aim || !(low[0] < part && part < high[0]) {
                break;
            }
            let (height, is_above) = lowest(part);
            let (end, other) = if is_above { (&mut low, &mut high) } else { (&mut high, &mut low) };
            *end = [part, height - aim];
            if before == Some(is_above) {
                other[1] *= 0.5;
            }
            before = Some(is_above);
        }
        let low = low[0];
        // Three roundings may have made it later by 4 u; or it is earlier than `time`.
        let until = (time + (1.0 - time) * low) * (1.0 - 8.0 * UNIT);
        if until > time { until } else { time }
    }

    /// A bound of the height along a moving normal of a point at the distance in its direction, all the time: the normal is never longer than
    /// the longest of its Bernstein coefficients, as it is a mean of these. Each has coordinates of two products, or four over 2, of two differences,
    /// off by 18 u for these and by 4 u for multiplications and sums, of the product of two ranges: 44 u.
    fn height_of(&self, [first, middle, last]: &[DVec3; 3]) -> f64 {
        let longest = first.length().max(middle.length() * 0.5).max(last.length());
        let [x, y, z] = self.ranges.to_array();
        let error = (x * y + y * z + z * x) * (64.0 * UNIT);
        self.distance * (longest * LENGTH + error + SHORTEST)
    }

    /// The normal of a feature, and the heights of the corners of the second triangle above those of the first along it, from the time of `corners`
    /// to the end: four cubics side by side, of which some may be the same.
    #[inline]
    fn heights(&self, corners: &[DVec3; 6], feature: Feature) -> ([DVec3; 3], [[f64; 4]; 4]) {
        let ends = [corners, &self.ends[1]];
        let edge =
            |from: usize, to: usize| [ends[0][to] - ends[0][from], ends[1][to] - ends[1][from]];
        let (normal, edges) = match feature {
            Feature::Face { of, .. } => {
                let (own, other) = (3 * of, 3 - 3 * of);
                // Corners that a segment or a point has not are its last one again.
                let edges = [0, 1, 2, 0].map(|k| [own, other + k]);
                (normal(edge(own, own + 1), edge(own, own + 2)), edges)
            }
            Feature::Edges([k, l]) => {
                let [[a, a_end, a_third], [b, b_end, b_third]] = edges([k, l]);
                let edges = [[a, b], [a, b_third], [a_third, b], [a_third, b_third]];
                (normal(edge(a, a_end), edge(b, b_end)), edges)
            }
        };
        let mut cubics = [[0.0; 4]; 4];
        for (lane, [from, to]) in edges.into_iter().enumerate() {
            let cubic = height(&normal, edge(from, to));
            for k in 0..4 {
                cubics[k][lane] = cubic[k];
            }
        }
        (normal, cubics)
    }
}

/// The lowest coefficient of the first parts of four cubics side by side, up to a time, by de Casteljau's algorithm; and whether all are above
/// `margin`.
#[inline(always)]
fn lowest([c0, c1, c2, c3]: &[[f64; 4]; 4], part: f64, margin: f64) -> (f64, bool) {
    let rest = 1.0 - part;
    let (mut low, mut are_above) = ([0.0; 4], [false; 4]);
    for lane in 0..4 {
        let between = |x: f64, y: f64| x * rest + y * part;
        let p = between(c0[lane], c1[lane]);
        let (q, r) = (between(c1[lane], c2[lane]), between(c2[lane], c3[lane]));
        let (s, t) = (between(p, q), between(q, r));
        let last = between(s, t);
        low[lane] = less(less(c0[lane], p), less(s, last));
        // A coefficient that is not a number is not above.
        are_above[lane] = (c0[lane] > margin) & (p > margin) & (s > margin) & (last > margin);
    }
    (least(&low), are_above == [true; 4])
}

#[inline(always)]
fn less(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}

#[inline(always)]
fn least([p, q, r, s]: &[f64; 4]) -> f64 {
    less(less(*p, *q), less(*r, *s))
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
