//! Certificates that two moving triangles meet in an interval of time.

use super::apart::edges;
use super::pair::{MovingPair, UNDERFLOWN, UNIT};
use crate::triangle::{Feature, features, near_points};
use glam::{DVec2, DVec3};

/// A determinant of three differences of corners at one time has to exceed so much of the product of the ranges: six products, each off by 27 u
/// for its factors (see `apart`) and by 5 u for its multiplications and sums, are 192 u.
const DETERMINANT: f64 = 256.0 * UNIT;

/// A coefficient of a turn has to exceed so much of the product of two ranges: two products, or four over 2, each off by 18 u for its factors and
/// by 4 u, are 44 u.
const TURN: f64 = 64.0 * UNIT;

/// Half of the widths of intervals that are tried around the first time of nearness. Wider ones show more, and tell less of when.
const WIDTHS: [f64; 3] = [1.0 / 16_777_216.0, 1.0 / 4_294_967_296.0, 1.0 / 65_536.0];

/// The roundings of two points of the triangles and of their difference. A coordinate of a point is off by 4 u for the corners at a time, by 4 u for
/// two edges and their products with parameters of the sum 1, by 2 u for two sums, and by 2 u as that sum may be 1 + u: 12 u. Both points and their
/// difference, at most 2, are off by 26 u, and in three coordinates by 46 u.
const POINTS: f64 = 128.0 * UNIT;

/// Parts of the time that is left after which the triangles are looked at whether they are within the distance: 2^-28 first.
const PARTS: core::ops::RangeInclusive<u32> = 0..=7;

impl MovingPair {
    /// A time from `time` on at which the triangles are certainly within the distance: two points of them are, which need not be the nearest.
    #[inline(never)]
    pub(super) fn certainly_within(&self, time: f64) -> Option<f64> {
        let after = |part: u32| (time + (1.0 - time) / f64::from(1_u32 << (4 * part))).min(1.0);
        PARTS.rev().map(after).find(|&time| {
            let [a, b, c, d, e, f] = self.at(time);
            let ([x, y], _) = near_points([&[a, b, c], &[d, e, f]], self.corners);
            (y - x).length() * (1.0 + 16.0 * UNIT) + POINTS <= self.distance
        })
    }

    /// The end of an interval around `time` in which the triangles certainly meet. Until `time` they are apart.
    ///
    /// A corner passes a face if their determinant has different signs at both ends of an interval, and if all through it the corner is
    /// inside the face, seen along one axis. For where the determinant is zero the corner is in the plane of the face, which is not seen
    /// edge-on, and so in the face. An edge passes an edge likewise. No root is computed.
    #[inline(never)]
    pub(super) fn certain_meeting(&self, time: f64, hint: Feature) -> Option<f64> {
        for width in WIDTHS {
            let ends = [(time - width).max(0.0), (time + width).min(1.0)];
            let corners = ends.map(|end| self.at(end));
            let passes = |feature: Feature| self.passes(&corners, feature);
            if passes(hint) || features(self.corners).any(passes) {
                return Some(ends[1]);
            }
        }
        None
    }

    /// Whether the two features certainly have a point in common at a time between those of `corners`.
    fn passes(&self, corners: &[[DVec3; 6]; 2], feature: Feature) -> bool {
        let (turns, [p, q, r, s]) = match feature {
            Feature::Face { of, corner } => {
                let ([p, q, r], s) = ([0, 1, 2].map(|k| 3 * of + k), 3 - 3 * of + corner);
                // On the same side of all edges.
                ([[p, q, s], [q, r, s], [r, p, s], [r, p, s]], [p, q, r, s])
            }
            Feature::Edges([k, l]) => {
                let [[a, a_end, _], [b, b_end, _]] = edges([k, l]);
                // The ends of each on different sides of the other.
                (
                    [[a, a_end, b], [a_end, a, b_end], [b_end, b, a], [b, b_end, a_end]],
                    [a, a_end, b, b_end],
                )
            }
        };
        let margin = self.volume() * DETERMINANT + UNDERFLOWN;
        let [before, after] = corners.each_ref().map(|c| determinant(c, [p, q, r, s]));
        let changes_sign = before > margin && after < -margin || before < -margin && after > margin;
        if !changes_sign {
            return false;
        }
        let [u, v, w] = [q, r, s].map(|to| corners[0][to] - corners[0][p]);
        let normal = match feature {
            Feature::Face { .. } => u.cross(v),
            Feature::Edges(_) => u.cross(w - v),
        };
        let axis = normal.abs().max_position();
        let sign = |turn| self.turn(corners, turn, axis);
        let first = sign(turns[0]);
        first != 0 && turns[1..].iter().all(|&turn| sign(turn) == first)
    }

    /// The sign of the turn of three corners, seen along an axis, if it is certainly the same at each time between those of `corners`.
    fn turn(&self, corners: &[[DVec3; 6]; 2], [p, q, r]: [usize; 3], axis: usize) -> i32 {
        let seen = |v: DVec3| match axis {
            0 => DVec2::new(v.y, v.z),
            1 => DVec2::new(v.z, v.x),
            _ => DVec2::new(v.x, v.y),
        };
        let ranges = seen(self.ranges);
        let margin = ranges.x * ranges.y * TURN + UNDERFLOWN;
        let [u, v] = [q, r].map(|to| corners.each_ref().map(|c| seen(c[to] - c[p])));
        let middle = (u[0].perp_dot(v[1]) + u[1].perp_dot(v[0])) * 0.5;
        let coefficients = [u[0].perp_dot(v[0]), middle, u[1].perp_dot(v[1])];
        i32::from(coefficients.iter().all(|x| *x > margin))
            - i32::from(coefficients.iter().all(|x| *x < -margin))
    }
}

/// det(q − p, r − p, s − p).
#[inline(always)]
fn determinant(corners: &[DVec3; 6], [p, q, r, s]: [usize; 4]) -> f64 {
    let [u, v, w] = [q, r, s].map(|to| corners[to] - corners[p]);
    u.cross(v).dot(w)
}
