//! Asks continuous queries of a file: `motion FILE` prints how many it missed and how many it reported in vain.
//!
//! Records are of 208 bytes, little-endian: u32 kind (0 a corner against a face, 1 an edge against an edge), u32 family, u32 truth, u32 0,
//! and 24 f64, the points 0 to 3 at the start and at the end.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "it says what is wrong with a file by panicking"
)]

use pfront_core::motion::{MovingTriangle, impact};
use std::time::{Duration, Instant};

/// Each query is timed as often, and the shortest time counts: the others are those of a machine that did other things too.
const REPEATS: usize = 5;

fn main() {
    let path = std::env::args().nth(1).expect("usage: motion FILE");
    let bytes = std::fs::read(path).unwrap();
    let (records, rest) = bytes.as_chunks::<208>();
    assert!(rest.is_empty(), "records have 208 bytes");
    let (mut missed, mut falsely, mut proven, mut wrong, mut hits) = (0, 0, 0, 0, 0);
    let (mut total, mut most) = (Duration::ZERO, Duration::ZERO);
    for record in records {
        let (truth, a, b) = read(record);
        let found = impact(&a, &b).unwrap();
        let is_proven = found.is_some_and(|impact| impact.is_proven());
        hits += usize::from(truth);
        missed += usize::from(truth && found.is_none());
        falsely += usize::from(!truth && found.is_some());
        proven += usize::from(truth && is_proven);
        wrong += usize::from(!truth && is_proven);
        let once = || {
            let begin = Instant::now();
            std::hint::black_box(impact(&a, &b)).unwrap();
            begin.elapsed()
        };
        let time = (0..REPEATS).map(|_| once()).min().unwrap_or_default();
        (total, most) = (total + time, most.max(time));
    }
    println!("{} queries, {hits} of them meet", records.len());
    println!("{missed} missed, {falsely} false; {proven} proven, {wrong} of them wrongly");
    let mean = total / u32::try_from(records.len().max(1)).unwrap();
    println!("{mean:?} a query, {most:?} at most");
    if missed + falsely + wrong > 0 {
        std::process::exit(1);
    }
}

fn read(record: &[u8; 208]) -> (bool, MovingTriangle, MovingTriangle) {
    let word = |k: usize| u32::from_le_bytes(record[4 * k..][..4].try_into().unwrap());
    let number = |k: usize| f64::from_le_bytes(record[16 + 8 * k..][..8].try_into().unwrap());
    let point = |end: usize, k: usize| [0, 1, 2].map(|axis| number(12 * end + 3 * k + axis));
    let moving = |corners: [usize; 3]| [0, 1].map(|end| corners.map(|k| point(end, k)));
    let (a, b) = match word(0) {
        0 => ([0, 0, 0], [1, 2, 3]),
        _ => ([0, 1, 1], [2, 3, 3]),
    };
    (word(2) == 1, moving(a), moving(b))
}
