//! Pairs that come within a distance while they move, against rationals at many times.

extern crate std;

use super::rounds;
use crate::motion::impact::impact_within;
use crate::motion::{Impact, MovingTriangle};
use crate::triangle::{nearest, within_in_f64};
use pfront_testkit::families::MotionFamily;
use pfront_testkit::oracle::{meet_while_moving, within_at};
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};
use std::vec::Vec;

/// Triangles at a time, in f64.
fn at(t: &MovingTriangle, time: f64) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|k| [0, 1, 2].map(|axis| t[0][k][axis] * (1.0 - time) + t[1][k][axis] * time))
}

/// How far near features of both are apart at a time, roughly.
fn roughly([a, b]: &[MovingTriangle; 2], time: f64) -> f64 {
    nearest(&at(a, time), &at(b, time)).length
}

/// Some times, and one at which the triangles are about as near as ever.
fn times(pair: &[MovingTriangle; 2], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let length = |time: &f64| roughly(pair, *time);
    let least = |times: &[f64]| {
        times.iter().copied().min_by(|s, t| length(s).total_cmp(&length(t))).unwrap_or(0.0)
    };
    let steps: Vec<f64> = (0..=32).map(|k| f64::from(k) / 32.0).collect();
    let (mut best, mut width) = (least(&steps), 1.0 / 32.0);
    for _ in 0..30 {
        let around = [best - width, best, best + width].map(|t| t.clamp(0.0, 1.0));
        (best, width) = (least(&around), width * 0.6);
    }
    [best, 0.0, 1.0, 0.5, rng.random(), rng.random()].into()
}

/// A distance at which the question is not plain: about the least at a time, less than that, or more.
fn distance(pair: &[MovingTriangle; 2], rng: &mut ChaCha8Rng) -> f32 {
    let near = roughly(pair, [0.0, 0.5, rng.random(), 1.0][rng.random_range(0..4)]) as f32;
    let factor = [1.0, 0.9, 0.5, 1e-3, 2.0, 1.0 - 1e-6, 1.0 + 1e-6][rng.random_range(0..7)];
    let whole = rng.random_range(1..4_u8);
    [near * factor, f32::from(whole)][usize::from(rng.random_range(0..4) == 0)]
}

#[test]
fn what_comes_within_a_distance_as_the_oracle() {
    let (mut rng, mut counts) = (seeded(74), [0; 3]);
    for family in MotionFamily::ALL {
        let mut of_family = [0; 3];
        for _ in 0..rounds() {
            let pair = family.pair(&mut rng);
            let distance = distance(&pair, &mut rng);
            if !(distance > 0.0 && distance.is_finite()) {
                continue;
            }
            let [a, b] = &pair;
            let is_within = |time| within_at(a, b, time, f64::from(distance));
            let found = impact_within(a, b, distance);
            let place = std::format!("{family:?} {a:?} {b:?} {distance:e} {found:?}");
            let times = times(&pair, &mut rng);
            let Some(Impact { from, to }) = found else {
                assert!(!times.iter().any(|&time| is_within(time)), "missed: {place}");
                of_family[0] += 1;
                continue;
            };
            if from > 0.0 {
                let before = [from.next_down(), from * 0.999, from * rng.random::<f64>()];
                let before = times.into_iter().filter(|&time| time < from).chain(before);
                assert!(!before.into_iter().any(is_within), "not so early: {place}");
            }
            if to.is_infinite() {
                of_family[2] += 1;
                continue;
            }
            assert!(from <= to && to <= 1.0, "{place}");
            assert!(is_within(to) || meet_while_moving(a, b, [from, to]), "proven: {place}");
            of_family[1] += 1;
        }
        std::println!("{family:?}: apart, proven, open: {of_family:?}");
        (0..3).for_each(|k| counts[k] += of_family[k]);
    }
    std::println!("within a distance: apart, proven, open: {counts:?}");
    let [apart, proven, open] = counts;
    assert!(cfg!(miri) || apart.min(proven) > 200 && open * 10 < proven);
}

/// Triangles that do not move are within a distance as they are at rest; others in both orders, and within larger ones.
#[test]
fn at_rest_and_in_larger_distances() {
    let mut rng = seeded(75);
    for family in MotionFamily::ALL {
        for _ in 0..rounds() {
            let pair = family.pair(&mut rng);
            let distance = distance(&pair, &mut rng);
            if !(distance > 0.0 && distance < 1e30) {
                continue;
            }
            let [a, b] = pair;
            let now = within_in_f64(&a[0], &b[0], distance);
            let rest = impact_within(&[a[0]; 2], &[b[0]; 2], distance);
            assert_eq!(
                rest,
                now.then_some(Impact { from: 0.0, to: 0.0 }),
                "{a:?} {b:?} {distance}"
            );
            let found = |a, b, distance| impact_within(a, b, distance);
            let place = std::format!("{family:?} {a:?} {b:?} {distance:e}");
            let (here, swapped) = (found(&a, &b, distance), found(&b, &a, distance));
            let is_proven = |found: Option<Impact>| found.is_some_and(Impact::is_proven);
            assert!(!is_proven(here) || swapped.is_some(), "{place}");
            assert!(!is_proven(swapped) || here.is_some(), "{place}");
            assert!(!is_proven(here) || found(&a, &b, distance * 1.5).is_some(), "{place}");
            // Triangles that meet are within every distance.
            let meets = crate::motion::impact(&a, &b).unwrap();
            assert!(!is_proven(meets) || here.is_some(), "{place}");
        }
    }
}

/// A corner that comes down to a floor is within 0.1 of it when it is 0.1 above.
#[test]
fn the_time_is_that_of_the_distance() {
    let floor = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]];
    let tip = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z + 1.0], [0.0, 1.0, z + 1.0]];
    let near = f64::from(0.1_f32);
    for low in [-3.0, 0.0, 0.05] {
        let found = impact_within(&[floor; 2], &[tip(1.0), tip(low)], 0.1).unwrap();
        let time = (1.0 - near) / (1.0 - low);
        assert!(found.from <= time && time <= found.to && found.to < time + 1e-6, "{found:?}");
    }
    assert_eq!(impact_within(&[floor; 2], &[tip(1.0), tip(0.101)], 0.1), None);
    // It comes as near as that at the end, which integers decide.
    let found = impact_within(&[floor; 2], &[tip(1.0), tip(near)], 0.1).unwrap();
    assert!(found.to == 1.0, "{found:?}");
}

/// Rigid motions with a screw between their poses: within the bound of their straight lines, no contact is missed.
#[test]
fn a_screw_motion_is_within_its_bound() {
    let mut rng = seeded(76);
    let mut met = 0;
    for _ in 0..rounds() {
        // Both turn about axes through their origins, along which they move.
        let mut body = || {
            let corners = [0; 3].map(|_| [0; 3].map(|_| rng.random_range(-1.0..1.0_f64)));
            let (turn, along) = (rng.random_range(-1.0..1.0_f64), rng.random_range(-1.0..1.0));
            let offset = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0_f64), 0.0];
            (corners, turn, along, offset)
        };
        let (p, q) = (body(), body());
        let at = |(corners, turn, along, offset): ([[f64; 3]; 3], f64, f64, [f64; 3]), t: f64| {
            let (sin, cos) = (turn * t).sin_cos();
            corners.map(|[x, y, z]| {
                [cos * x - sin * y + offset[0], sin * x + cos * y + offset[1], z + along * t]
            })
        };
        let bound = |(corners, turn, ..): ([[f64; 3]; 3], f64, f64, [f64; 3])| {
            let radius = corners.map(|[x, y, _]| x.hypot(y)).into_iter().fold(0.0, f64::max);
            radius * turn * turn / 8.0
        };
        let distance = ((bound(p) + bound(q)) as f32).next_up();
        let [a, b] = [p, q].map(|body| [at(body, 0.0), at(body, 1.0)]);
        let found = impact_within(&a, &b, distance);
        for step in 0..=64 {
            let time = f64::from(step) / 64.0;
            if within_in_f64(&at(p, time), &at(q, time), 0.0) {
                met += 1;
                assert!(found.is_some_and(|found| found.from <= time), "{a:?} {b:?} {time}");
            }
        }
    }
    assert!(cfg!(miri) || met > 100, "{met}");
}
