//! Pairs of moving triangles against rationals, and what has to be consistent.

extern crate std;

use super::{Impact, MovingTriangle, impact};
use pfront_testkit::families::MotionFamily;
use pfront_testkit::oracle::meet_while_moving;
use pfront_testkit::rng::{RngExt, seeded};

/// How many pairs of each family are asked: `PFRONT_ROUNDS`, 100000 for a long run.
fn rounds() -> usize {
    let asked = std::env::var("PFRONT_ROUNDS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(if cfg!(miri) { 1 } else { 150 })
}

#[derive(Default, Debug)]
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
    let mut rng = seeded(47);
    for family in MotionFamily::ALL {
        let mut counts = Counts::default();
        for _ in 0..rounds() {
            let [a, b] = family.pair(&mut rng);
            check(&a, &b, impact(&a, &b).unwrap(), &mut counts);
        }
        std::println!("{family:?} {counts:?}");
    }
}
