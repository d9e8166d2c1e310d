//! Asks continuous queries of a file: `motion FILE` prints how many it missed and how many it reported in vain.
//!
//! Records are of 208 bytes, little-endian: u32 kind (0 a corner against a face, 1 an edge against an edge), u32 family, u32 truth, u32 0,
//! and 24 f64, the points 0 to 3 at the start and at the end.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront_core::motion::{MovingTriangle, impact};
use std::time::{Duration, Instant};

fn main() {
    let path = std::env::args().nth(1).unwrap();
    let bytes = std::fs::read(path).unwrap();
    let (records, _) = bytes.as_chunks::<208>();
    let queries: Vec<_> = records.iter().map(read).collect();
    let (mut missed, mut falsely, mut proven, mut wrong, mut hits) = (0, 0, 0, 0, 0);
    let (mut total, mut most) = (Duration::ZERO, Duration::ZERO);
    for (truth, a, b) in &queries {
        let begin = Instant::now();
        let found = impact(a, b).unwrap();
        let time = begin.elapsed();
        (total, most) = (total + time, most.max(time));
        hits += usize::from(*truth);
        missed += usize::from(*truth && found.is_none());
        falsely += usize::from(!*truth && found.is_some());
        let is_proven = found.is_some_and(|impact| impact.is_proven());
        proven += usize::from(*truth && is_proven);
        wrong += usize::from(!*truth && is_proven);
    }
    let mut times: Vec<_> = (0..5)
        .map(|_| {
            let begin = Instant::now();
            for (_, a, b) in &queries {
                std::hint::black_box(impact(a, b).unwrap());
            }
            begin.elapsed() / queries.len() as u32
        })
        .collect();
    times.sort();
    println!(
        "{} queries, {hits} hits: {missed} missed, {falsely} false, {proven} proven, {wrong} of them wrongly",
        queries.len()
    );
    println!(
        "{:?} a query, at best {:?}, at most {most:?}",
        total / queries.len() as u32,
        times[0]
    );
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
