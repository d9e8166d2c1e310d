//! Corners of what two triangles have in common: against the oracle, in every order of corners, and where coordinates are hard.

extern crate std;

use super::*;
use pfront_testkit::families::Family;
use pfront_testkit::oracle::{self, OnLattice};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use std::vec::Vec;

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// 2^-900.
const TINY: f64 = f64::from_bits((1023 - 900) << 52);

/// Triangles of a small lattice; every other pair in one plane, and every tenth with segments and points.
fn pair(rng: &mut impl Rng) -> [OnLattice; 2] {
    let (most, kind) = (rng.random_range(1..=4), rng.random_range(0..10));
    // A map of the plane z = 0 into another.
    let mut entry = || rng.random_range(-3..=3);
    let map: [[i128; 3]; 3] = [0; 3].map(|_| [0; 3].map(|_| entry()));
    [0, 1].map(|which| {
        let corner = |rng: &mut dyn Rng| [0; 3].map(|_| rng.random_range(0..=most));
        let mut t = [0; 3].map(|_| corner(rng));
        if kind % 2 == 0 {
            t = t.map(|[x, y, _]| map.map(|row| row[0] * x + row[1] * y + row[2]));
        }
        match kind {
            8 if which == 0 => t[2] = [0, 1, 2].map(|k| 2 * t[1][k] - t[0][k]),
            9 => t[rng.random_range(0..3)] = t[0],
            _ => {}
        }
        t
    })
}

fn number(region: Region) -> usize {
    Region::ALL.iter().position(|own| *own == region).unwrap()
}

/// The answer of the library as the oracle has it, but for points.
fn found(meet: Option<Meet>) -> Option<oracle::Meet> {
    meet.map(|meet| oracle::Meet {
        points: Vec::new(),
        corners: meet.corners().map(|corner| corner.map(number)).collect(),
        dimension: meet.dimension(),
        is_proper: meet.is_proper(),
    })
}

/// A region where corners are in another order.
fn reordered(region: usize, order: [usize; 3]) -> usize {
    let place = |corner: usize| order.iter().position(|own| *own == corner).unwrap();
    match region {
        0..3 => place(region),
        3..6 => {
            let ends = [place(region - 3), place((region - 2) % 3)];
            3 + (4 - ends[0] - ends[1]) % 3
        }
        face => face,
    }
}

/// Checks that each point is within its intervals, and that they are short.
fn check_points(a: &OnLattice, b: &OnLattice, points: &[([i128; 3], i128)]) {
    let [p, q] = [a, b].map(|t| t.map(|p| p.map(|x| x as f64)));
    let Ok(Some(meet)) = meet_f64(&p, &q) else { return };
    assert_eq!(meet.points(&p, &q).count(), points.len());
    for (found, (point, divisor)) in meet.points(&p, &q).zip(points) {
        for ([low, high], x) in found.into_iter().zip(point) {
            let x = *x as f64 / *divisor as f64;
            assert!(low <= x && x <= high && high - low < 1e-11, "{a:?} {b:?} {low} {x} {high}");
        }
    }
}

#[test]
fn corners_are_those_of_the_oracle_in_every_order() {
    let mut rng = seeded(44);
    let (mut dimensions, mut proper, mut apart) = ([0; 3], 0, 0);
    for i in 0..if cfg!(miri) { 20 } else { 60_000 } {
        let [a, b] = pair(&mut rng);
        let mut truth = oracle::meet(&a, &b);
        let points = truth.as_mut().map(|truth| core::mem::take(&mut truth.points));
        let [p, q] = [&a, &b].map(|t| t.map(|p| p.map(|x| x as f32)));
        assert_eq!(found(meet(&p, &q)), truth, "{a:?} {b:?}");
        let in_f64 = [&a, &b].map(|t| t.map(|p| p.map(|x| x as f64 * TINY)));
        assert_eq!(found(meet_f64(&in_f64[0], &in_f64[1]).unwrap()), truth, "{a:?} {b:?}");
        check_points(&a, &b, &points.unwrap_or_default());
        match &truth {
            Some(truth) => dimensions[truth.dimension] += 1,
            None => apart += 1,
        }
        proper += usize::from(truth.as_ref().is_some_and(|truth| truth.is_proper));
        // Swapped, and with corners in other orders.
        let (own, other) = (ORDERS[i % 6], ORDERS[i / 6 % 6]);
        let turned = truth.map(|mut truth| {
            let swapped = |[r, s]: [usize; 2]| [reordered(s, other), reordered(r, own)];
            truth.corners = truth.corners.into_iter().map(swapped).collect();
            truth.corners.sort_unstable();
            truth
        });
        assert_eq!(found(meet(&other.map(|i| q[i]), &own.map(|i| p[i]))), turned, "{a:?} {b:?}");
    }
    if !cfg!(miri) {
        let all = [dimensions[0], dimensions[1], dimensions[2], proper, apart];
        assert!(all.iter().all(|&count| count > 2_000), "{all:?}");
    }
}

/// Triangles of any coordinates meet where they intersect, in f32 and in f64 alike, and in either order.
#[test]
fn triangles_meet_where_they_intersect() {
    let mut rng = seeded(45);
    for family in Family::ALL {
        for _ in 0..if cfg!(miri) { 2 } else { 500 } {
            let (a, b) = family.pair(&mut rng);
            let own = meet(&a, &b);
            assert_eq!(own.is_some(), oracle::intersect(&a, &b), "{family:?} {a:?} {b:?}");
            let swapped = meet(&b, &a).map(|meet| {
                let mut corners: Vec<_> = meet.corners().map(|[r, s]| [s, r]).collect();
                corners.sort_unstable();
                (corners, meet.dimension(), meet.is_proper())
            });
            let expected =
                own.map(|meet| (meet.corners().collect(), meet.dimension(), meet.is_proper()));
            assert_eq!(swapped, expected, "{family:?} {a:?} {b:?}");
            if a.iter().chain(&b).flatten().all(|x| x.abs() <= 4e37) {
                let [p, q] = [&a, &b].map(|t| t.map(|p| p.map(f64::from)));
                assert_eq!(meet_f64(&p, &q), Ok(own), "{family:?} {a:?} {b:?}");
            }
        }
    }
    let out = [[0.0; 3], [0.0, f64::NAN, 0.0], [0.0; 3]];
    assert_eq!(meet_f64(&out, &out), Err(MeshError::NonFinite { vertex: 1 }));
}
