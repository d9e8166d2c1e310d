//! The suite, its file, its judge, and the textbook's tests on it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront_lab::judge::{INEXACT, Judge, OURS, Tally, Test};
use pfront_lab::suite::{BLOCK, Block, Case, Reader, Suite, Writer, answers};
use pfront_lab::textbook;
use pfront_lab::workload::FormatError;
use pfront_testkit::{checksum, families::Family};
use std::io::Cursor;

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
    let names: Vec<_> = suite.sets().iter().map(|set| set.name()).collect();
    assert_eq!(names[Family::ALL.len()..], ["worm-gear", "epicyclic", "torus-knots", "sheet"]);
    let all = blocks(&suite, 3_300);
    assert_eq!(all.len(), 33);
    assert_eq!(hash(all.iter().flat_map(|block| &block.cases)), 0xb001_f3be_5733_e703);
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
    for (set, contacts) in suite.sets().iter().enumerate().filter(|(_, s)| s.contacts().is_some()) {
        for block in [0, 1] {
            let cases = suite.block(set, block, 1_500);
            let hits = cases.iter().filter(|case| case.meets).count();
            assert_eq!(cases.len(), 1_500, "{}", contacts.name());
            assert!((15..1_200).contains(&hits), "{}: {hits}", contacts.name());
        }
    }
}

/// A file of two sets.
fn file() -> (Vec<u8>, Vec<Block>) {
    let suite = Suite::of_families(9);
    let blocks: Vec<_> =
        [3, 0].iter().map(|&set| Block { set, cases: suite.block(set, 0, 5) }).collect();
    let sets = [("vertex".to_owned(), 5), ("random ±".to_owned(), 5)];
    let mut writer = Writer::new(Vec::new(), 9, &sets).unwrap();
    blocks.iter().for_each(|block| writer.add(&block.cases).unwrap());
    (writer.finish(), blocks)
}

/// All cases of a file, by sets.
fn read(bytes: &[u8]) -> Result<Vec<Block>, FormatError> {
    let mut reader = Reader::new(Cursor::new(bytes))?;
    let mut blocks = Vec::new();
    while let Some(block) = reader.next_block()? {
        blocks.push(block);
    }
    Ok(blocks)
}

/// Where the pairs of [`file`] begin.
const FIRST: usize = 24 + (12 + 6) + (12 + 9);

#[test]
fn a_file_is_read_as_it_was_written() {
    let (bytes, written) = file();
    assert_eq!(bytes.len(), FIRST + 10 * 73);
    let found = read(&bytes).unwrap();
    assert_eq!([found[0].set, found[1].set], [0, 1]);
    assert!(found.iter().zip(&written).all(|(found, written)| found.cases == written.cases));
    let reader = Reader::new(Cursor::new(bytes)).unwrap();
    assert_eq!((reader.seed(), reader.sets()[1].0.as_str()), (9, "random ±"));
}

#[test]
fn a_damaged_file_is_refused_where_it_is_wrong() {
    let damaged = |at: usize, with: &[u8]| {
        let mut bytes = file().0;
        bytes[at..at + with.len()].copy_from_slice(with);
        read(&bytes).unwrap_err().to_string()
    };
    let coordinate = FIRST + 2 * 73;
    for (error, part) in [
        (damaged(0, b"X"), "at byte 0: this is not a file of triangle pairs".to_owned()),
        (damaged(8, &[2]), "at byte 8: version 2 is unknown".to_owned()),
        (damaged(15, &[9]), "too few for the sets".to_owned()),
        (damaged(25, &[1]), "at byte 24: the name of set 0 is longer".to_owned()),
        (damaged(28, &[0xff]), "at byte 28: the name of set 0 is longer".to_owned()),
        (
            damaged(coordinate + 8, &f32::NAN.to_le_bytes()),
            format!(
                "at byte {coordinate}: pair 2 of set 'vertex' has a coordinate that is not finite"
            ),
        ),
        (damaged(FIRST + 6 * 73 + 72, &[7]), "pair 1 of set 'random ±' has the truth 7".to_owned()),
    ] {
        assert!(error.contains(&part), "no '{part}' in: {error}");
    }
    let (bytes, _) = file();
    for end in 0..bytes.len() {
        let error = read(&bytes[..end]).unwrap_err();
        assert!(matches!(error, FormatError::Truncated { .. }), "{end}: {error}");
    }
    assert!(matches!(read(&[&bytes[..], b"!"].concat()), Err(FormatError::Invalid { .. })));
}

#[test]
fn answers_are_as_many_as_pairs() {
    assert_eq!(answers(&[1, 0, 1], 3).unwrap(), [true, false, true]);
    let said = |bytes, pairs| answers(bytes, pairs).unwrap_err().to_string();
    assert!(said(&[1, 0], 3).contains("2 answers to 3 pairs"));
    assert!(said(&[1, 0], 1).contains("2 answers to 1 pairs"));
    assert!(said(&[1, 2], 2).contains("answer 1 is neither 0 nor 1"));
}

#[test]
fn ours_keep_their_promises_and_a_liar_is_caught() {
    let suite = Suite::generated(3, Some(8_000)).unwrap();
    let all = blocks(&suite, 33_000);
    let mut tests = [OURS, INEXACT].concat();
    tests.push(Test { name: "always", meets: |_, _| true });
    tests.push(Test { name: "never", meets: |_, _| false });
    let mut judge = Judge::new(&tests, suite.sets().len());
    judge.add(&all[..20]);
    judge.add(&all[20..]);
    for (set, [exact, query, conservative, _, always, never]) in
        judge.scores().iter().map(|score| score.as_chunks::<6>().0[0]).enumerate()
    {
        let name = suite.sets()[set].name();
        assert_eq!([exact.wrong(), query.wrong(), conservative.missed], [0; 3], "{name}");
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
    [tally.missed, tally.false_hits].map(|count| 1e-4 * tally.per_million(count))
}

#[test]
fn the_textbook_is_right_in_general_position() {
    for test in textbook::tests().iter().filter(|test| !test.name.starts_with("parry3d")) {
        for family in [Family::Random, Family::VertexFaceGap3, Family::EdgeEdgeGap3] {
            assert_eq!(wrong(test.name, family), [0.0; 2], "{}, {family:?}", test.name);
        }
    }
    assert!(wrong("parry3d's own (GJK), f32", Family::Random).iter().sum::<f64>() < 0.2);
}

/// The percentages of `accuracy.md`, as far as they do not depend on how a family is made in detail.
#[test]
fn the_textbook_is_wrong_where_it_is_known_to_be() {
    let near = |found: f64, known: f64| assert!((found - known).abs() < 0.15 * known, "{found}");
    let [epsilon, none] = ["Möller 1997, ε = 1e-6", "Möller 1997, ε = 0"];
    let [f32, f64] = ["Guigue-Devillers, f32", "Guigue-Devillers, f64"];
    let axes = "17 separating axes, f32";
    near(wrong(epsilon, Family::VertexFaceGap7)[1], 50.0);
    near(wrong(none, Family::VertexFaceGap8)[1], 27.0);
    near(wrong(none, Family::SharedVertex)[0], 36.0);
    near(wrong(f32, Family::SharedVertex)[0], 28.0);
    near(wrong(f64, Family::SharedVertex)[0], 20.0);
    for (test, family) in
        [(none, Family::MeshLike), (f32, Family::MeshLike), (f64, Family::VertexFaceGap8)]
    {
        assert!(wrong(test, family).iter().sum::<f64>() < 0.1, "{test}");
    }
    assert_eq!(wrong(axes, Family::SharedVertex), [0.0; 2]);
    assert!(wrong(axes, Family::VertexFaceGap8)[1] > 25.0);
    near(wrong("parry3d's own (GJK), f32", Family::VertexFaceGap8)[1], 50.0);
}

#[cfg(feature = "gpu")]
#[test]
fn a_gpu_is_right() {
    let mut gpu = pfront_lab::judge::OnGpu::new().unwrap();
    let suite = Suite::generated(8, Some(8_000)).unwrap();
    for Block { set, cases } in blocks(&suite, 33 * 300) {
        let tally = Tally::of(&cases, gpu.answers(&cases).unwrap());
        assert_eq!((tally.pairs, tally.wrong()), (300, 0), "{}", suite.sets()[set].name());
    }
    for count in [0, 1, 2, 3] {
        let cases = suite.block(0, 0, count);
        assert_eq!(Tally::of(&cases, gpu.answers(&cases).unwrap()).wrong(), 0);
    }
    assert!(gpu.left_to_cpu() < 33 * 100, "{}", gpu.left_to_cpu());
}
