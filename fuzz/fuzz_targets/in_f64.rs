//! Two small meshes of any numbers that f64 has, up to 2^125, in any pose that is taken: queries about them and about one of
//! them, through models, against the oracle about every two triangles.
//!
//! Coordinates are picked from a short list in the input, since independent ones never coincide.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use pfront::{Model, PairQuery, Pose64, SelfQuery, TrianglePair};
use pfront_testkit::oracle::{intersect, self_hit};

const POINTS: usize = 6;
const TRIANGLES: usize = 4;

#[derive(Arbitrary, Debug)]
struct Input {
    values: [u64; 24],
    /// The number of the value that each coordinate takes.
    picks: [[[u8; 3]; POINTS]; 2],
    triangles: [[[u8; 3]; TRIANGLES]; 2],
    pose: Option<[[u8; 4]; 3]>,
}

fuzz_target!(|input: Input| {
    let value = |pick: u8| f64::from_bits(input.values[pick as usize % 24]);
    let points = input.picks.map(|points| points.map(|p| p.map(value)));
    let triangles = input.triangles.map(|all| all.map(|t| t.map(|v| u32::from(v) % POINTS as u32)));
    let rows = input.pose.map(|rows| rows.map(|row| row.map(value)));
    let pose = rows.map_or(Pose64::IDENTITY, Pose64::new);
    let model = |i: usize| Model::from_f64(points[i].to_vec(), triangles[i].to_vec());
    let (Ok(a), Ok(b)) = (model(0), model(1)) else {
        let largest = 4.253529586511731e37;
        assert!(points.as_flattened().as_flattened().iter().any(|x| !(x.abs() <= largest)));
        return;
    };
    for (i, model) in [&a, &b].into_iter().enumerate() {
        let own = triangles[i];
        let hit = |x: u32, y: u32| self_hit(own[x as usize], own[y as usize], &points[i]);
        let n = TRIANGLES as u32;
        let two = (0..n).flat_map(|x| (x + 1..n).map(move |y| TrianglePair { a: x, b: y }));
        let truth: Vec<_> = two.filter(|pair| hit(pair.a, pair.b)).collect();
        assert_eq!(SelfQuery::new().all(model).unwrap(), truth);
    }
    let mut query = PairQuery::new();
    // A pose may be refused, with an error.
    let Ok(found) = query.all(&a, &b, pose) else { return };
    let corners = |i: usize, t: [u32; 3]| t.map(|v| points[i][v as usize]);
    let mut truth = Vec::new();
    for (x, s) in (0..).zip(triangles[0]) {
        for (y, t) in (0..).zip(triangles[1]) {
            if intersect(&corners(0, s), &corners(1, t).map(|p| pose.apply(p))) {
                truth.push(TrianglePair { a: x, b: y });
            }
        }
    }
    assert_eq!(found, truth);
    let contacts = query.contacts_f64(&a, &b, pose).unwrap();
    assert!(contacts.iter().map(|contact| contact.0).eq(truth));
    let ends = contacts.iter().flat_map(|contact| contact.1.segment).flatten();
    assert!(ends.into_iter().all(f64::is_finite));
});
