//! Recorded truths on real meshes: `oracle/cases.json`, on which two independent programs agreed,
//! and the meshes of `nasty/`, which have broken other libraries.
//!
//! The data may not be redistributed. It is looked for in `$PFRONT_DATA`, else in `../shared/data`
//! beside the checkout; without it these tests fail. They run with `--features recorded`.

#![cfg(feature = "recorded")]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use pfront::core::query::{self, Query};
use pfront::{Model, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_oracle::generate::soup::{Soup, posed};
use pfront_oracle::{intersect, pairs, self_pairs};
use serde_json::Value;
use std::path::PathBuf;

#[test]
fn every_recorded_case() {
    let text = String::from_utf8(bytes("oracle/cases.json")).unwrap();
    let cases: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(cases.len(), 9);
    for case in &cases {
        let string = |key: &str| case[key].as_str().unwrap();
        let (name, a, b) = (string("name"), mesh(string("a")), mesh(string("b")));
        let truth: Vec<_> = words(&format!("oracle/{name}.pairs.u32le"))
            .chunks_exact(2)
            .map(|pair| TrianglePair { a: pair[0], b: pair[1] })
            .collect();
        assert_eq!(case["pairs"], truth.len(), "{name}");
        let pose = recorded_pose(case);
        let posed = posed(&b.positions, &pose.rows);
        let file = format!("oracle/{name}.b_world.f32le");
        let world = if data().join(&file).exists() { vectors(&file) } else { posed.clone() };
        let in_world = |positions| Soup { positions, triangles: b.triangles.clone() };
        assert_eq!(found(&a, &in_world(world.clone()), &Pose::IDENTITY), truth, "{name}");
        if world == posed {
            assert_eq!(found(&a, &b, &pose), truth, "{name} posed");
        } else {
            // Recorded in f64 and rounded once, where the contract rounds every step: the truth is
            // another, and the oracle has to say which.
            let far = |(p, q): (&[f32; 3], &[f32; 3])| (0..3).any(|k| (p[k] - q[k]).abs() > 1e-7);
            assert!(!world.iter().zip(&posed).any(far), "{name} is posed elsewhere");
            let truth = pairs(&a.positions, &a.triangles, &posed, &b.triangles);
            assert_eq!(found(&a, &b, &pose), as_pairs(&truth), "{name} posed");
        }
    }
}

/// Counts from `README.md` of the data where they are of f32 coordinates. Rounding those of the file
/// from f64 leaves 27 of 29 pairs for `Offset3` and makes 95 of 89 for `Havocglass8`.
#[test]
fn nasty_pairs() {
    for (a, b, count) in [
        ("ballA.off", "ballB.off", Some(276)),
        ("self_intersectA.obj", "self_intersectB.obj", Some(600)),
        ("Offset3.obj", "Offset4.obj", Some(27)),
        ("Havocglass8_left.obj", "Havocglass8_right.obj", Some(95)),
        ("center_cylinder.obj", "offset_cylinder.obj", Some(72)),
        ("elephant.off", "elephant-with-holes.off", None),
        ("patch-20.off", "patch-21.off", None),
        ("stairs.obj", "wallhole.obj", None),
        ("degtri_sliding.off", "degtri_sliding.off", None),
    ] {
        let [s, t] = [a, b].map(|file| mesh(&format!("nasty/{file}")));
        let truth = pairs(&s.positions, &s.triangles, &t.positions, &t.triangles);
        assert_eq!(count.unwrap_or(truth.len()), truth.len(), "{a} and {b}");
        assert_eq!(found(&s, &t, &Pose::IDENTITY), as_pairs(&truth), "{a} and {b}");
    }
}

#[test]
fn nasty_meshes_with_themselves() {
    for file in [
        "ballA.off",
        "cylinder_locally_refined.off",
        "degtri_sliding.off",
        "elephant-with-holes.off",
        "issue289_1.obj",
        "patch-20.off",
        "same_mesh_far_from_origin.obj",
        "self_intersectA.obj",
        "self_intersectB.obj",
        "soup.stl",
        "stairs.obj",
        "wallhole.obj",
    ] {
        let soup = mesh(&format!("nasty/{file}"));
        let truth = as_pairs(&self_pairs(&soup.positions, &soup.triangles));
        let model = Model::new(soup.positions, soup.triangles).unwrap();
        assert_eq!(SelfQuery::new().all(&model), truth, "{file}");
    }
}

/// 48,184,455 pairs of overlapping boxes for 1,239 pairs that meet, in pages of 64.
#[test]
fn twin_in_bounded_memory() {
    let [a, b] = ["left", "right"].map(|side| {
        let soup = mesh(&format!("nasty/Generic_Twin_7081.1.t0_{side}.obj"));
        Model::new(soup.positions, soup.triangles).unwrap()
    });
    let query = query::PairQuery::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
    let (mut cursor, mut page) = (query.start(), [TrianglePair::default(); 64]);
    let mut paged = Vec::new();
    while !cursor.is_done() {
        let n = query.page(&mut cursor, &mut page);
        paged.extend_from_slice(&page[..n]);
    }
    paged.sort_unstable();
    assert_eq!(paged.len(), 1239);
    assert_eq!(cursor.work().triangle_tests, 48_184_455);
    let meet = |p: &TrianglePair| intersect(&a.mesh().triangle(p.a), &b.mesh().triangle(p.b));
    assert!(paged.iter().all(meet));
    assert_eq!(PairQuery::new().all(&a, &b, &Pose::IDENTITY).unwrap(), paged);
}

#[test]
fn broken_files() {
    let read = |file: &str| pfront_cli::mesh::read(&data().join("nasty").join(file));
    assert!(read("notenoughindices.obj").is_err());
    // Only its colours are NaN.
    assert_eq!(read("nancolor.obj").unwrap().triangles.len(), 12);
}

fn found(a: &Soup, b: &Soup, a_from_b: &Pose) -> Vec<TrianglePair> {
    let [a, b] =
        [a, b].map(|soup| Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap());
    PairQuery::new().all(&a, &b, a_from_b).unwrap().to_vec()
}

fn recorded_pose(case: &Value) -> Pose {
    let number = |key: &str, i: usize| case[key][i].as_f64().unwrap() as f32;
    Pose::new([0, 1, 2].map(|row| {
        let [x, y, z] = [0, 1, 2].map(|k| number("rotation_row_major", 3 * row + k));
        [x, y, z, number("translation", row)]
    }))
}

fn as_pairs(truth: &[(u32, u32)]) -> Vec<TrianglePair> {
    truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect()
}

fn mesh(file: &str) -> Soup {
    let read = pfront_cli::mesh::read(&data().join(file)).unwrap();
    Soup { positions: read.positions, triangles: read.triangles }
}

fn vectors(file: &str) -> Vec<[f32; 3]> {
    words(file).chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(f32::from_bits)).collect()
}

fn words(file: &str) -> Vec<u32> {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    bytes(file).chunks_exact(4).map(word).collect()
}

fn bytes(file: &str) -> Vec<u8> {
    let path = data().join(file);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn data() -> PathBuf {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data");
    let folder = std::env::var_os("PFRONT_DATA").map_or_else(|| beside.into(), PathBuf::from);
    assert!(
        folder.join("oracle/cases.json").exists(),
        "no test data in {}: set PFRONT_DATA to the folder with oracle/cases.json and nasty/, or \
         run without --features recorded",
        folder.display()
    );
    folder
}
