//! When two moving triangles meet first: steps from proof to proof that they are apart, until they are near.

use super::pair::{MovingPair, MovingTriangle};
use crate::exact::motion::{Question, Verdict};
use crate::mesh::{MeshError, check_position};
use crate::scalar::WITHIN;
use crate::triangle::{Feature, intersects_in_f64, near_points, within_in_f64};
use glam::DVec3;

/// When two triangles meet first, as far as it is proven; 0 is the start of the motion and 1 its end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impact {
    /// They do not meet before this time.
    pub from: f64,
    /// They certainly meet between `from` and this time. If it is infinite, they come near at `from`, and whether they meet is open.
    pub to: f64,
}

impl Impact {
    /// Whether the triangles certainly meet.
    #[must_use]
    pub fn is_proven(self) -> bool {
        self.to.is_finite()
    }

    /// Both, as what happens to one pair of meshes or triangles: the first of both times, and the first proof.
    pub(super) fn first(self, other: Self) -> Self {
        Self { from: self.from.min(other.from), to: self.to.min(other.to) }
    }
}

/// The part of their radius within which triangles are near: 2^-30. Where they meet, that is near enough to prove it.
pub(super) const NEAR: f64 = 1.0 / 1_073_741_824.0;

/// The same for those of which that is not proven: 2^-44. Nearer ones are nothing but rounding errors apart.
const NEAREST: f64 = 1.0 / 17_592_186_044_416.0;

/// Steps after which a pair is left open, far more than any takes that comes from a real motion.
const STEPS: usize = 200;

/// How far the steps lead.
pub(super) enum Progress {
    /// To the end: the triangles never meet from the first time on.
    Apart,
    /// Up to a time until which they are apart, with the features that are near each other then.
    Near(f64, Feature),
}

impl MovingPair {
    /// Until when they are certainly apart that are so until a time; 1 if to the end.
    fn apart_until(&self, time: f64) -> f64 {
        match self.part_of_few(time, NEAREST) {
            Progress::Apart => 1.0,
            Progress::Near(time, _) => time,
        }
    }

    /// [`MovingPair::part`], in one place for all but those pairs about which most questions are.
    #[inline(never)]
    fn part_of_few(&self, time: f64, near: f64) -> Progress {
        self.part(time, near)
    }

    /// Whether the normal of one triangle half way, or the line between the middles of both, certainly separates them all the time: most pairs
    /// whose boxes overlap at a time end here.
    #[inline(always)]
    pub(super) fn is_separated(&self) -> bool {
        let corners = self.at(0.5);
        let [p, q, r, s, t, u] = corners;
        let along = (s + t + u) - (p + q + r);
        let upwards = |n: DVec3| if n.dot(along) < 0.0 { -n } else { n };
        let separates = |n: DVec3| self.advance(0.0, n) >= 1.0;
        separates(upwards((q - p).cross(r - p)))
            || separates(upwards((t - s).cross(u - s)))
            || separates(along)
    }

    /// Goes from `time`, at which the triangles do not meet, from one certificate that they are apart to the next, until they are as near as a
    /// part of their radius; or are not within the distance, until they nearly are.
    #[inline(always)]
    pub(super) fn part(&self, mut time: f64, near: f64) -> Progress {
        let reach = near * (self.radius + self.distance) + self.distance;
        let mut feature = Feature::Edges([0; 2]);
        for _ in 0..STEPS {
            let corners = self.at(time);
            let [[a, b, c, d, e, f]] = [corners];
            let ([x, y], features) = near_points([&[a, b, c], &[d, e, f]], self.corners);
            feature = features;
            let along = y - x;
            if along.length_squared() <= reach * reach {
                break;
            }
            let n = normal(&corners, feature);
            let n = if n.dot(along) < 0.0 { -n } else { n };
            let mut next = self.advance(time, n);
            if next < 1.0 {
                next = next.max(self.advance(time, along));
            }
            if next < 1.0 {
                next = next.max(self.advance_with(time, &corners, feature));
            }
            if next >= 1.0 {
                return Progress::Apart;
            }
            if next <= time {
                break;
            }
            time = next;
        }
        Progress::Near(time, feature)
    }
}

/// The normal of two features.
#[inline(always)]
fn normal(corners: &[DVec3; 6], feature: Feature) -> DVec3 {
    match feature {
        Feature::Face { of, .. } => {
            let [p, q, r] = [0, 1, 2].map(|k| corners[3 * of + k]);
            (q - p).cross(r - p)
        }
        Feature::Edges([k, l]) => {
            let next = |k: usize| if k == 2 { 0 } else { k + 1 };
            let [g, h] = [(next(k), k), (next(l) + 3, l + 3)].map(|(q, p)| corners[q] - corners[p]);
            g.cross(h)
        }
    }
}

/// When two triangles meet first whose corners move in straight lines from the start to the end, at the times 0 to 1; `None` if they never
/// do. A triangle without area is its segment or point.
///
/// # Errors
/// [`MeshError`] names the first of the twelve positions that has a coordinate which is NaN or beyond ±2^125: the corners of `a` at the start
/// and at the end, then those of `b`.
///
/// # Complexity
/// O(1), no allocation, bounded stack: a bounded number of steps.
///
/// # Examples
/// ```
/// use pfront_core::motion::impact;
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let tip = |z| [[1.0, 1.0, z], [1.0, 2.0, z + 3.0], [2.0, 1.0, z + 3.0]];
/// let found = impact(&[floor; 2], &[tip(1.0), tip(-9.0)])?.expect("it passes the floor");
/// assert!(found.from <= 0.1 && 0.1 <= found.to && found.to - found.from < 1e-6);
/// assert_eq!(impact(&[floor; 2], &[tip(1.0), tip(0.5)])?, None);
/// # Ok::<(), pfront_core::MeshError>(())
/// ```
pub fn impact(a: &MovingTriangle, b: &MovingTriangle) -> Result<Option<Impact>, MeshError> {
    let corners = [a, b].into_iter().flat_map(|t| t.as_flattened());
    for (corner, p) in corners.enumerate() {
        check_position(corner, *p)?;
    }
    Ok(impact_of(a, b))
}

/// [`impact`] of coordinates that are in range.
#[inline(always)]
pub(super) fn impact_of(a: &MovingTriangle, b: &MovingTriangle) -> Option<Impact> {
    let pair = MovingPair::new(a, b, 0.0);
    if pair.is_separated() { None } else { impact_in_steps(a, b, &pair) }
}

/// The same of a pair that no direction which is soon found separates.
#[inline]
pub(super) fn impact_in_steps(
    a: &MovingTriangle,
    b: &MovingTriangle,
    pair: &MovingPair,
) -> Option<Impact> {
    match pair.part(0.0, NEAR) {
        Progress::Apart => None,
        Progress::Near(time, feature) => impact_after(a, b, pair, time, feature),
    }
}

/// The impact of two triangles that are apart before `time`, and near then.
#[inline(never)]
fn impact_after(
    a: &MovingTriangle,
    b: &MovingTriangle,
    pair: &MovingPair,
    from: f64,
    feature: Feature,
) -> Option<Impact> {
    // Not even the first certificate held: apart or not at the start, only exact signs tell.
    if from == 0.0 && intersects_in_f64(&a[0], &b[0]) {
        return Some(Impact { from, to: 0.0 });
    }
    if pair.is_still() && a == &[a[0]; 2] && b == &[b[0]; 2] {
        return None;
    }
    if let Some(to) = pair.certain_meeting(from, feature) {
        return Some(Impact { from, to });
    }
    let resume = |time: f64| pair.apart_until(time);
    let from = resume(from);
    if from >= 1.0 {
        return None;
    }
    let corners = [&a[0], &a[1], &b[0], &b[1]];
    let meet_at_end = || intersects_in_f64(&a[1], &b[1]);
    let (resume, meet_at_end): (&dyn Fn(f64) -> f64, &dyn Fn() -> bool) = (&resume, &meet_at_end);
    let question = Question { corners, count: pair.corners, from, resume, meet_at_end };
    let Verdict::Near { from, to } = question.answer() else { return None };
    Some(Impact { from, to: if to.is_infinite() && meet_at_end() { 1.0 } else { to } })
}

/// When two triangles come within a distance above 0 first, as [`impact_of`] tells when they meet.
#[inline(never)]
pub(super) fn impact_within(
    a: &MovingTriangle,
    b: &MovingTriangle,
    distance: f32,
) -> Option<Impact> {
    if !WITHIN {
        return None;
    }
    let pair = MovingPair::new(a, b, distance);
    let Progress::Near(from, feature) = pair.part_of_few(0.0, NEAR) else { return None };
    // Not even the first certificate held.
    if from == 0.0 && within_in_f64(&a[0], &b[0], distance) {
        return Some(Impact { from, to: 0.0 });
    }
    if pair.is_still() && a == &[a[0]; 2] && b == &[b[0]; 2] {
        return None;
    }
    let certain =
        |from: f64| pair.certainly_within(from).or_else(|| pair.certain_meeting(from, feature));
    if let Some(to) = certain(from) {
        return Some(Impact { from, to });
    }
    let from = pair.apart_until(from);
    if from >= 1.0 {
        return None;
    }
    let at_end = || within_in_f64(&a[1], &b[1], distance).then_some(1.0);
    Some(Impact { from, to: certain(from).or_else(at_end).unwrap_or(f64::INFINITY) })
}
