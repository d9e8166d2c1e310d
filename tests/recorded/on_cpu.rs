//! Recorded truths on real meshes: `oracle/cases.json`, on which two independent programs agreed,
//! and the meshes of `nasty/`, which have broken other libraries.
//!
//! They run with `--features recorded`; `data.rs` says where the data is looked for.

use super::data::{self, Case, NASTY_PAIRS, NASTY_SELVES, cases, mesh};
use pfront::{Model, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_core::bvtt::{self, Query};
use pfront_testkit::MeshData;
use pfront_testkit::oracle::{intersect, pairs, self_pairs};
use pfront_testkit::shapes::posed;

#[test]
fn every_recorded_case() {
    for Case { name, a, b, a_from_b, b_world, pairs: truth } in cases() {
        let posed = MeshData { positions: posed(&b.positions, &a_from_b.rows), ..b.clone() };
        let world = b_world.unwrap_or_else(|| posed.clone());
        assert_eq!(found(&a, &world, &Pose::IDENTITY), truth, "{name}");
        if world.positions == posed.positions {
            assert_eq!(found(&a, &b, &a_from_b), truth, "{name} posed");
        } else {
            // Recorded in f64 and rounded once, where the contract rounds every step: the truth is
            // another, and the oracle has to say which.
            let far = |(p, q): (&[f32; 3], &[f32; 3])| (0..3).any(|k| (p[k] - q[k]).abs() > 1e-7);
            let mut both = world.positions.iter().zip(&posed.positions);
            assert!(!both.any(far), "{name} is posed elsewhere");
            let truth = pairs(&a.positions, &a.triangles, &posed.positions, &b.triangles);
            assert_eq!(found(&a, &b, &a_from_b), as_pairs(&truth), "{name} posed");
        }
    }
}

#[test]
fn nasty_pairs() {
    for (a, b, count) in NASTY_PAIRS {
        let [s, t] = [a, b].map(|file| mesh(&format!("nasty/{file}")));
        let truth = pairs(&s.positions, &s.triangles, &t.positions, &t.triangles);
        assert_eq!(count.unwrap_or(truth.len()), truth.len(), "{a} and {b}");
        assert_eq!(found(&s, &t, &Pose::IDENTITY), as_pairs(&truth), "{a} and {b}");
    }
}

/// The counts are those of the coordinates in the files: rounded to f32, there are 27 and 95 pairs.
#[test]
fn nasty_pairs_in_f64() {
    for (a, b, count) in data::NASTY_PAIRS_IN_F64 {
        let [s, t] = [a, b].map(data::model_in_f64);
        let mut query = PairQuery::new();
        assert_eq!(query.count(&s, &t, Pose::IDENTITY).unwrap(), count, "{a} and {b}");
        assert_eq!(query.contacts(&s, &t, Pose::IDENTITY).unwrap().len() as u64, count);
    }
}

#[test]
fn nasty_meshes_with_themselves() {
    for file in NASTY_SELVES {
        let soup = mesh(&format!("nasty/{file}"));
        let truth = as_pairs(&self_pairs(&soup.positions, &soup.triangles));
        let model = Model::new(soup.positions, soup.triangles).unwrap();
        assert_eq!(SelfQuery::new().all(&model).unwrap(), truth, "{file}");
    }
}

/// 48,184,455 pairs of overlapping boxes for 1,239 pairs that meet, in pages of 64.
#[test]
fn twin_in_bounded_memory() {
    let [a, b] = ["left", "right"].map(|side| {
        let soup = mesh(&format!("nasty/Generic_Twin_7081.1.t0_{side}.obj"));
        Model::new(soup.positions, soup.triangles).unwrap()
    });
    let query = bvtt::PairBvtt::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
    let (mut cursor, mut page) = (query.start(), [TrianglePair::default(); 64]);
    let mut paged = Vec::new();
    while !cursor.is_done() {
        let n = query.page(&mut cursor, &mut page);
        paged.extend_from_slice(&page[..n]);
    }
    paged.sort_unstable();
    assert_eq!(paged.len(), 1239);
    assert_eq!(cursor.work.triangle_tests, 48_184_455);
    let meet = |p: &TrianglePair| {
        intersect(&a.mesh().shadow_triangle(p.a), &b.mesh().shadow_triangle(p.b))
    };
    assert!(paged.iter().all(meet));
    assert_eq!(PairQuery::new().all(&a, &b, Pose::IDENTITY).unwrap(), paged);
}

#[test]
fn broken_files() {
    let read = |file: &str| pfront_files::read_f32(&data::data().join("nasty").join(file));
    // A face of two corners has no triangle to lose, and is passed over with a note.
    assert_eq!(read("notenoughindices.obj").unwrap().triangles, [[0, 1, 2]]);
    // Only its colours are NaN.
    assert_eq!(read("nancolor.obj").unwrap().triangles.len(), 12);
}

fn found(a: &MeshData, b: &MeshData, a_from_b: &Pose) -> Vec<TrianglePair> {
    let [a, b] =
        [a, b].map(|soup| Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap());
    PairQuery::new().all(&a, &b, a_from_b).unwrap().to_vec()
}

fn as_pairs(truth: &[(u32, u32)]) -> Vec<TrianglePair> {
    truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect()
}
