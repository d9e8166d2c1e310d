//! Pairs of moving triangles against rationals, and what has to be consistent.

extern crate std;

mod bvtt;
#[cfg(feature = "within")]
mod within;

use super::{Impact, MovingTriangle, impact, impact_in_mesh};
use crate::triangle::{Adjacency, intersects_in_mesh};
use crate::{Mesh, MeshError};
use pfront_testkit::families::{Family, MotionFamily};
use pfront_testkit::oracle::{meet_while_moving, self_hit_while_moving};
use pfront_testkit::rng::seeded;

/// How many pairs of each family are asked: `PFRONT_ROUNDS`, 77000 for a million pairs.
fn rounds() -> usize {
    let asked = std::env::var("PFRONT_ROUNDS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(if cfg!(miri) { 1 } else { 150 })
}

/// Pairs by the answer about them; `false_open` are those that are open and do not meet.
#[derive(Debug, Default)]
struct Counts {
    apart: usize,
    proven: usize,
    open: usize,
    false_open: usize,
}

/// Checks what is said of a pair: whether it meets, and when.
fn check(a: &MovingTriangle, b: &MovingTriangle, found: Option<Impact>, counts: &mut Counts) {
    let meet = |from, to| meet_while_moving(a, b, [from, to]);
    let Some(Impact { from, to }) = found else {
        assert!(!meet(0.0, 1.0), "missed: {a:?} {b:?}");
        counts.apart += 1;
        return;
    };
    assert!(from == 0.0 || !meet(0.0, from), "they meet before {from}: {a:?} {b:?}");
    if to.is_finite() {
        assert!(meet(from, to), "proven wrongly to meet in {from} to {to}: {a:?} {b:?}");
        counts.proven += 1;
    } else if meet(from, 1.0) {
        counts.open += 1;
    } else {
        counts.false_open += 1;
    }
}

#[test]
fn families_as_the_oracle() {
    let (mut rng, mut all) = (seeded(47), Counts::default());
    for family in MotionFamily::ALL {
        let mut counts = Counts::default();
        for _ in 0..rounds() {
            let [a, b] = family.pair(&mut rng);
            check(&a, &b, impact(&a, &b).unwrap(), &mut counts);
        }
        let Counts { apart, proven, open, false_open } = counts;
        std::println!(
            "{family:?}: {apart} apart, {proven} proven, {open} open; {false_open} in vain"
        );
        assert_eq!(false_open, 0, "{family:?}");
        // They touch without passing, or meet only in between while in one plane.
        assert!(open * 8 <= apart + proven, "{family:?}");
        all.apart += apart;
        all.proven += proven;
        all.open += open;
        all.false_open += false_open;
    }
    std::println!("{} pairs: {all:?}", MotionFamily::ALL.len() * rounds());
    assert!(cfg!(miri) || all.apart.min(all.proven) > 400);
}

/// The time reversed, sides swapped, corners permuted, and a common motion added: the same pairs are found.
#[test]
fn what_changes_nothing() {
    let mut rng = seeded(48);
    for family in MotionFamily::ALL {
        for _ in 0..rounds() {
            let [a, b] = family.pair(&mut rng);
            let found = impact(&a, &b).unwrap();
            let is_found = found.is_some();
            let reversed = |[start, end]: MovingTriangle| [end, start];
            let turned = |t: MovingTriangle| t.map(|[p, q, r]| [q, r, p]);
            let flipped = |t: MovingTriangle| t.map(|[p, q, r]| [q, p, r]);
            for (a, b) in [(b, a), (reversed(a), reversed(b)), (turned(a), flipped(b))] {
                let other = impact(&a, &b).unwrap();
                assert_eq!(other.is_some(), is_found, "{family:?} {a:?} {b:?}");
            }
            // Exact for integers, of which no coordinate is rounded.
            let is_whole = |t: &MovingTriangle| {
                t.as_flattened().as_flattened().iter().all(|x| x.fract() == 0.0 && x.abs() < 1e6)
            };
            if is_whole(&a) && is_whole(&b) {
                let moved = |[start, end]: MovingTriangle| {
                    [start, end.map(|[x, y, z]| [x + 64.0, y - 7.0, z + 1024.0])]
                };
                assert_eq!(impact(&moved(a), &moved(b)).unwrap(), found, "{family:?} {a:?} {b:?}");
            }
        }
    }
}

/// [0, 1] split at 1/2: what meets in the whole meets in one half, if the middle is a number.
#[test]
fn halves_are_the_whole() {
    let mut rng = seeded(49);
    for family in [
        MotionFamily::Lattice2,
        MotionFamily::Lattice9,
        MotionFamily::Degenerate,
        MotionFamily::Landing,
    ] {
        for _ in 0..rounds() {
            let [a, b] = family.pair(&mut rng);
            let middle = |[start, end]: &MovingTriangle| {
                [0, 1, 2].map(|k| [0, 1, 2].map(|axis| 0.5 * (start[k][axis] + end[k][axis])))
            };
            let first = impact(&[a[0], middle(&a)], &[b[0], middle(&b)]).unwrap();
            let second = impact(&[middle(&a), a[1]], &[middle(&b), b[1]]).unwrap();
            let whole = impact(&a, &b).unwrap();
            assert_eq!(
                whole.is_some(),
                first.is_some() || second.is_some(),
                "{family:?} {a:?} {b:?}"
            );
            if let (Some(whole), Some(first)) = (whole, first) {
                assert!(whole.from <= 0.5 * first.to + 1e-9, "{family:?} {a:?} {b:?}");
            }
        }
    }
}

/// Without a motion, what is proven to meet intersects, and the rest is not reported.
#[test]
fn at_rest_as_without_motion() {
    let mut rng = seeded(50);
    for family in pfront_testkit::families::Family::ALL {
        for _ in 0..rounds() {
            let (p, q) = family.pair(&mut rng);
            let [a, b] = [p, q].map(|t| t.map(|p| p.map(f64::from)));
            if a.iter().chain(&b).flatten().any(|x| x.abs() > 4e37) {
                continue;
            }
            let now =
                Some(Impact { from: 0.0, to: 0.0 }).filter(|_| crate::triangle::intersects(&p, &q));
            assert_eq!(impact(&[a; 2], &[b; 2]).unwrap(), now, "{family:?} {a:?} {b:?}");
        }
    }
}

/// A wall 1 mm thick, shot through between two poses 1 m apart.
#[test]
fn a_wall_shot_through() {
    let wall = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 2.0]];
    let bullet = |y: f64| [[0.0, y, 0.0], [1e-3, y, 0.0], [0.0, y - 1e-3, 1e-3]];
    for time in [0.123_456, 0.5, 0.999] {
        let found =
            impact(&[wall; 2], &[bullet(time + 1e-3), bullet(time + 1e-3 - 1.0)]).unwrap().unwrap();
        assert!(found.to - found.from < 1e-6 && (found.from - time).abs() < 1e-6, "{found:?}");
    }
}

#[test]
fn coordinates_out_of_range_are_named() {
    let t = [[[0.0; 3]; 3]; 2];
    let mut other = t;
    other[1][2][1] = f64::NAN;
    assert_eq!(impact(&t, &other), Err(MeshError::NonFinite { vertex: 11 }));
    other[1][2][1] = 1e38;
    assert_eq!(impact(&other, &t), Err(MeshError::Range { vertex: 5 }));
}

/// Triangles of one mesh that share vertices in every way, and moving positions of every family.
#[test]
fn neighbours_as_the_oracle() {
    let mut rng = seeded(51);
    let (mut apart, mut proven, mut open) = (0, 0, 0);
    for family in MotionFamily::ALL {
        for _ in 0..rounds() {
            let [a, b] = family.pair(&mut rng);
            let [start, end] = [0, 1].map(|end| [a[end], b[end]].as_flattened().to_vec());
            let (_, i, j) = Family::Random.indexed(&mut rng);
            let triangles = [i, j];
            let mut memory = [[[0.0; 3]; 6]; 2];
            let [of_start, of_end] = &mut memory;
            let start_mesh = Mesh::from_f64(&start, &triangles, of_start).unwrap();
            let end_mesh = Mesh::from_f64(&end, &triangles, of_end).unwrap();
            let found = impact_in_mesh(start_mesh, end_mesh, 0, 1, Adjacency::SharedIndexRule);
            let meet = |from, to| self_hit_while_moving(i, j, [&start, &end], [from, to]);
            let place = std::format!("{family:?} {start:?} {end:?} {triangles:?} {found:?}");
            match found {
                // Without a motion the other rule holds.
                None if start == end => {
                    assert!(!intersects_in_mesh(start_mesh, 0, 1, Adjacency::SharedIndexRule));
                }
                None => assert!(!meet(0.0, 1.0), "{place}"),
                Some(Impact { from, to }) => {
                    assert!(from == 0.0 || !meet(0.0, from), "{place}");
                    assert!(to.is_infinite() || meet(from, to), "{place}");
                    (proven, open) = (
                        proven + usize::from(to.is_finite()),
                        open + usize::from(to.is_infinite()),
                    );
                    continue;
                }
            }
            apart += 1;
        }
    }
    std::println!("neighbours: {apart} apart, {proven} proven, {open} open");
    assert!(cfg!(miri) || apart.min(proven) > 300 && open * 10 < proven);
}
