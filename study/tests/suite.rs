//! The suite, its file, its judge, and the textbook's tests on it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront_oracle::generate::Family;
use pfront_study::judge::{Judge, OURS, Tally};
use pfront_study::suite::{Answers, Block, Case, FileError, Reader, Suite, Writer};
use pfront_study::textbook;

/// Small scenes, and few pairs of each set.
fn suite() -> Suite {
    Suite::generated(5, Some(8_000)).unwrap()
}

fn blocks(suite: &Suite, pairs: u64) -> Vec<Block> {
    suite.waves(pairs).flatten().collect()
}

fn hash(blocks: &[Block]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for case in blocks.iter().flat_map(|block| &block.cases) {
        let coordinates = case.a.iter().chain(&case.b).flatten().flat_map(|x| x.to_le_bytes());
        for byte in coordinates.chain([u8::from(case.meets)]) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[test]
fn time() {
    let t = std::time::Instant::now();
    let suite = suite();
    println!("suite {:?}", t.elapsed());
    for s in 0..suite.sets().len() {
        let t = std::time::Instant::now();
        let cases = suite.block(s, 1, 1000);
        let hits = cases.iter().filter(|c| c.meets).count();
        println!("{:20} {:?} {hits}", suite.sets()[s].name(), t.elapsed() / 1000);
    }
    let all = blocks(&suite, 330_000);
    let mut tests = OURS.to_vec();
    tests.extend(textbook::tests());
    let mut judge = Judge::new(&tests, suite.sets().len());
    judge.add(&all);
    for (s, row) in suite.sets().iter().zip(judge.scores()) {
        print!("{:18}{:6}", s.name(), row[0].hits);
        for t in row {
            print!(
                "| {:5.2} {:5.2}",
                t.per_million(t.missed) / 1e4,
                t.per_million(t.false_hits) / 1e4
            );
        }
        println!();
    }
}
