//! Two triangles whose corners move in straight lines, in a frame that suits f64.

use crate::exact::difference;
use glam::DVec3;

/// The corners of a triangle at the start of a motion and at its end.
pub type MovingTriangle = [[[f64; 3]; 3]; 2];

/// The unit roundoff of f64: 2^-53.
pub(super) const UNIT: f64 = f64::EPSILON * 0.5;

/// A bound of what underflow takes from any height, determinant or turn of coordinates up to 1: each is a sum of less than 2^8 products,
/// of which each loses less than 2^-1070.
pub(super) const UNDERFLOWN: f64 = 1e-300;

/// Two moving triangles in the frame that moves with the first corner of the first one, scaled by a power of two so that no coordinate is
/// greater than 1, and the greatest not less than 1/2.
///
/// A motion common to all corners is so taken out before anything is rounded again: each coordinate of `ends` is a difference of two
/// given ones, off by at most u times itself, u = 2^-53, and by 2^-1075 where scaling underflows.
pub(super) struct MovingPair {
    /// The corners at the start and at the end: 0 to 2 are those of the first triangle, 3 to 5 those of the second.
    pub(super) ends: [[DVec3; 6]; 2],
    /// How many corners each has: a segment has its first two and a point its first. The others repeat the last of these.
    pub(super) corners: [usize; 2],
    /// The largest range of the corners along each axis at one of the ends, and so at any time, but for two roundings.
    pub(super) ranges: DVec3,
    /// The largest coordinate: R in the bounds.
    pub(super) radius: f64,
    /// The distance at which the triangles count as meeting, in the same scale; 0 if they have to meet.
    pub(super) distance: f64,
}

impl MovingPair {
    pub(super) fn new(a: &MovingTriangle, b: &MovingTriangle, distance: f32) -> Self {
        let corner = |end: usize, k: usize| if k < 3 { &a[end][k] } else { &b[end][k - 3] };
        let mut ends = [[DVec3::ZERO; 6]; 2];
        let (mut radius, mut ranges) = (DVec3::ZERO, DVec3::ZERO);
        for (end, corners) in ends.iter_mut().enumerate() {
            let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
            for (k, p) in corners.iter_mut().enumerate().skip(1) {
                *p = difference(corner(end, k), corner(end, 0));
                (low, high) = (low.min(*p), high.max(*p));
            }
            radius = radius.max(high.max(-low));
            ranges = ranges.max(high - low);
        }
        let radius = radius.max_element().abs();
        // A number of the exponent e is below 2^(e - 1022).
        let scale = f64::from_bits((2045 - (radius.to_bits() >> 52)) << 52);
        for p in ends.as_flattened_mut() {
            *p *= scale;
        }
        let corners = [count(a), count(b)];
        let (ranges, distance) = (ranges * scale, f64::from(distance) * scale);
        Self { ends, corners, ranges, radius: radius * scale, distance }
    }

    /// The same motion backwards is the same pair with its ends swapped; if they are equal, no corner moves against another.
    pub(super) fn is_still(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// The corners at a time between 0 and 1. Each coordinate is off by at most 4 u times the largest that it has at an end: with its own
    /// error, that of 1 − t, a product and a sum.
    #[inline(always)]
    pub(super) fn at(&self, time: f64) -> [DVec3; 6] {
        let mut corners = self.ends[0];
        for (p, q) in corners.iter_mut().zip(&self.ends[1]) {
            *p = *p * (1.0 - time) + *q * time;
        }
        corners
    }

    /// The largest determinant, within a factor of 6, of three differences of corners at one time.
    pub(super) fn volume(&self) -> f64 {
        self.ranges.x * self.ranges.y * self.ranges.z
    }
}

/// How many different corners a triangle has that is given as a segment, with its second corner again, or as a point.
fn count([start, end]: &MovingTriangle) -> usize {
    let repeats = |k: usize| start[k] == start[k - 1] && end[k] == end[k - 1];
    match (repeats(1), repeats(2)) {
        (true, true) => 1,
        (false, true) => 2,
        _ => 3,
    }
}
