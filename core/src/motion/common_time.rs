//! Boxes that move: when two of them have a point in common.
//!
//! The box of a node at a time between both ends is its box at the start and at the end, interpolated: it contains every corner below the
//! node, as each moves in a straight line. On each axis the gap on either side is linear in time, so that each of six conditions leaves an
//! interval of time. Two boxes are compared at a common time, which their union over all times would not: two bodies that fall side by side
//! never come near each other.

use crate::aabb::Bounds;
use glam::{DVec3, Vec3A};

/// A time is off by less than four roundings, relatively.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// The first time at which two boxes overlap, or a little earlier; `None` if they never do. Touching counts.
#[inline]
pub(super) fn first_overlap(start: &[Bounds; 2], end: &[Bounds; 2]) -> Option<f64> {
    // The sign of a difference is exact.
    let gaps = |[a, b]: &[Bounds; 2]| [b.min - a.max, a.min - b.max];
    let ([p, q], [p_end, q_end]) = (gaps(start), gaps(end));
    let apart = |gap: Vec3A| gap.cmpgt(Vec3A::ZERO);
    let always = (apart(p) & apart(p_end)) | (apart(q) & apart(q_end));
    if always.any() {
        return None;
    }
    if !(apart(p) | apart(q)).any() {
        return Some(0.0);
    }
    first_of_gaps(&gaps_in_f64(start), &gaps_in_f64(end))
}

/// The gaps on either side, which f64 has without overflow.
fn gaps_in_f64(boxes: &[Bounds; 2]) -> [DVec3; 2] {
    let [[a, a_max], [b, b_max]] = boxes.map(|of| [of.min.as_dvec3(), of.max.as_dvec3()]);
    [b - a_max, a - b_max]
}

/// The first time at which no gap is above 0.
fn first_of_gaps(start: &[DVec3; 2], end: &[DVec3; 2]) -> Option<f64> {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (start, end) in start.iter().zip(end) {
        for axis in 0..3 {
            let (start, end) = (start[axis], end[axis]);
            if start <= 0.0 && end <= 0.0 {
                continue;
            }
            if start > 0.0 && end > 0.0 {
                return None;
            }
            let time = start / (start - end);
            if start > 0.0 {
                first = first.max(time * (1.0 - ROUNDED));
            } else {
                last = last.min(time * (1.0 + ROUNDED));
            }
        }
    }
    (first <= last).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::{RngExt, seeded};

    fn cube(min: [f32; 3], edge: f32) -> Bounds {
        let min = Vec3A::from_array(min);
        Bounds { min, max: min + edge }
    }

    #[test]
    fn boxes_meet_at_a_common_time() {
        let [rest, beside] = [cube([0.0; 3], 1.0), cube([3.0, 0.0, 0.0], 1.0)];
        // Each passes the place of the other, at another time.
        let (a, b) = (cube([0.0, 9.0, 0.0], 1.0), cube([0.0, -9.0, 0.0], 1.0));
        assert_eq!(first_overlap(&[rest, a], &[b, a]), None);
        let found = first_overlap(&[rest, beside], &[rest, cube([-1.0, 0.0, 0.0], 1.0)]).unwrap();
        assert!(found <= 0.5 && found > 0.4999);
        assert_eq!(first_overlap(&[rest, beside], &[rest, cube([1.5, 0.0, 0.0], 1.0)]), None);
        // Touching at the end.
        let found = first_overlap(&[rest, beside], &[rest, cube([1.0, 0.0, 0.0], 1.0)]).unwrap();
        assert!(found > 0.9999 && found <= 1.0);
    }

    #[test]
    fn no_time_of_overlap_is_missed() {
        let mut rng = seeded(52);
        for _ in 0..if cfg!(miri) { 20 } else { 20_000 } {
            let mut random = || {
                let min = [0; 3].map(|_| rng.random_range(-4..=4_i8));
                cube(min.map(f32::from), f32::from(rng.random_range(0..=2_u8)))
            };
            let (start, end) = ([random(), random()], [random(), random()]);
            let found = first_overlap(&start, &end);
            for step in 0..=64_u8 {
                let t = f32::from(step) / 64.0;
                let at = |k: usize| Bounds {
                    min: start[k].min * (1.0 - t) + end[k].min * t,
                    max: start[k].max * (1.0 - t) + end[k].max * t,
                };
                // Integers over 64, which f32 has exactly.
                if at(0).overlaps(&at(1)) {
                    assert!(found.is_some_and(|first| first <= f64::from(t)), "{start:?} {end:?}");
                }
            }
        }
    }
}
