//! The suite, its judge, and the textbook's tests on it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront_lab::judge::{FAST, OURS, Tally, Test, judge};
use pfront_lab::suite::{BLOCK, Block, Case, Suite};
use pfront_lab::textbook;
use pfront_testkit::{checksum, families::Family};

fn blocks(suite: &Suite, pairs: u64) -> Vec<Block> {
    suite.waves(pairs).flatten().collect()
}

/// A checksum of all coordinates and truths.
fn hash<'c>(cases: impl IntoIterator<Item = &'c Case>) -> u64 {
    checksum(cases.into_iter().flat_map(|case| {
        let coordinates = case.a.into_iter().chain(case.b).flatten();
        coordinates.flat_map(f32::to_le_bytes).chain([u8::from(case.meets)])
    }))
}

#[test]
fn the_suite_is_the_same_on_every_machine() {
    let suite = Suite::generated(5, Some(8_000)).unwrap();
    let names: Vec<_> = suite.sets.iter().map(|set| set.name()).collect();
    assert_eq!(names[Family::ALL.len()..], ["worm-gear", "swarm", "torus-knots", "sheet"]);
    let all = blocks(&suite, 3_300);
    assert_eq!(all.len(), 33);
    assert_eq!(hash(all.iter().flat_map(|block| &block.cases)), 0xf4d9_36ec_71d3_bc64);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(alone.install(|| blocks(&suite, 3_300)) == all);
    assert!(blocks(&Suite::of_families(6), 290) != blocks(&Suite::of_families(5), 290));
}

#[test]
fn shares_are_even_and_blocks_are_prefixes() {
    let suite = Suite::of_families(1);
    let shares = suite.shares(1_000_003);
    assert_eq!(shares.iter().sum::<u64>(), 1_000_003);
    assert!(shares.iter().all(|share| share.abs_diff(shares[0]) <= 1));
    let sizes: Vec<_> = blocks(&suite, 29 * 5_000).iter().map(|block| block.cases.len()).collect();
    assert_eq!(sizes[..3], [BLOCK, 5_000 - BLOCK, BLOCK]);
    assert_eq!(suite.block(3, 7, 5), suite.block(3, 7, 50)[..5]);
}

#[test]
fn harvested_pairs_are_candidates_and_some_of_them_meet() {
    let suite = Suite::generated(2, Some(8_000)).unwrap();
    for (set, of) in suite.sets.iter().enumerate().skip(Family::ALL.len()) {
        for block in [0, 1] {
            let cases = suite.block(set, block, 1_500);
            let hits = cases.iter().filter(|case| case.meets).count();
            assert_eq!(cases.len(), 1_500, "{}", of.name());
            assert!((15..1_200).contains(&hits), "{}: {hits}", of.name());
        }
    }
}

#[test]
fn ours_keep_their_promises_and_a_liar_is_caught() {
    let suite = Suite::generated(3, Some(8_000)).unwrap();
    let mut tests = [&OURS[..], &[FAST]].concat();
    tests.push(Test { name: "always", meets: |_, _| true });
    tests.push(Test { name: "never", meets: |_, _| false });
    let scores = judge(&suite, 33_000, &tests, |_| Ok(())).unwrap();
    for (set, [exact, query, _, always, never]) in
        scores.iter().map(|score| score.as_chunks::<5>().0[0]).enumerate()
    {
        let name = suite.sets[set].name();
        assert_eq!([exact.wrong(), query.wrong()], [0; 2], "{name}");
        assert_eq!((always.missed, always.false_hits), (0, 1_000 - always.hits), "{name}");
        assert_eq!((never.missed, never.false_hits), (never.hits, 0), "{name}");
        assert_eq!((exact.pairs, exact.hits), (1_000, always.hits), "{name}");
    }
}

/// Wrong answers of a textbook's test on a family, missed and false hits, in per cent.
fn wrong(test: &str, family: Family) -> [f64; 2] {
    let test = textbook::tests().into_iter().find(|t| t.name == test).unwrap();
    let suite = Suite::of_families(4);
    let set = Family::ALL.iter().position(|f| *f == family).unwrap();
    let cases = suite.block(set, 0, 4_000);
    let tally = Tally::of(&cases, cases.iter().map(|c| (test.meets)(&c.a, &c.b)));
    [tally.missed, tally.false_hits].map(|count| 100.0 * count as f64 / tally.pairs as f64)
}

#[test]
fn the_textbook_is_right_in_general_position() {
    for test in textbook::tests().iter().filter(|test| !test.name.starts_with("parry3d")) {
        for family in [Family::Random, Family::VertexFaceGap3, Family::EdgeEdgeGap3] {
            assert_eq!(wrong(test.name, family), [0.0; 2], "{}, {family:?}", test.name);
        }
    }
    let parry =
        textbook::tests().into_iter().find(|test| test.name.starts_with("parry3d")).unwrap();
    assert!(wrong(parry.name, Family::Random).iter().sum::<f64>() < 0.2);
    // Where it panics, that is an answer.
    let far = |x: f32| [[x, 0.0, 0.0], [-x, x, 0.0], [0.0, -x, x]];
    for x in [1e10, 1e20, 1e30, 3e38] {
        (parry.meets)(&far(x), &far(-x));
    }
}

#[cfg(feature = "gpu")]
#[test]
fn a_gpu_is_right() {
    let mut gpu = pfront_lab::judge::OnGpu::new().unwrap();
    let suite = Suite::generated(8, Some(8_000)).unwrap();
    for Block { set, cases } in blocks(&suite, 33 * 300) {
        let tally = Tally::of(&cases, gpu.answers(&cases).unwrap());
        assert_eq!((tally.pairs, tally.wrong()), (300, 0), "{}", suite.sets[set].name());
    }
    for count in [0, 1, 2, 3] {
        let cases = suite.block(0, 0, count);
        assert_eq!(Tally::of(&cases, gpu.answers(&cases).unwrap()).wrong(), 0);
    }
    assert!(gpu.left_to_cpu() < 33 * 100, "{}", gpu.left_to_cpu());
}
