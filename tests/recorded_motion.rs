//! Recorded truths of moving features: the public queries of Wang et al., and the cloth that falls on a ball.
//!
//! They run with `--features recorded`; `data/mod.rs` says where the data is looked for.

#![cfg(feature = "recorded")]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

#[expect(dead_code, reason = "it has more than this test asks for")]
mod data;

use pfront_core::motion::{Impact, MovingTriangle, impact};
use pfront_testkit::oracle::meet_while_moving;

/// 5,779 queries: a point against a triangle, or two segments. Recorded and rational truths agree.
#[test]
fn public_queries() {
    let bytes = std::fs::read(data::data().join("motion/queries.bin")).unwrap();
    let (records, rest) = bytes.as_chunks::<208>();
    assert!(rest.is_empty() && records.len() == 5779);
    let (mut hits, mut proven) = (0, 0);
    for (number, record) in records.iter().enumerate() {
        let word = |k: usize| u32::from_le_bytes(record[4 * k..][..4].try_into().unwrap());
        let x = |k: usize| f64::from_le_bytes(record[16 + 8 * k..][..8].try_into().unwrap());
        let point = |end: usize, k: usize| [0, 1, 2].map(|axis| x(12 * end + 3 * k + axis));
        let moving = |corners: [usize; 3]| [0, 1].map(|end| corners.map(|k| point(end, k)));
        let [a, b] = [[[0; 3], [1, 2, 3]], [[0, 1, 1], [2, 3, 3]]][word(0) as usize].map(moving);
        let truth = word(2) == 1;
        assert_eq!(meet_while_moving(&a, &b, [0.0, 1.0]), truth, "query {number}, the oracle");
        let found = impact(&a, &b).unwrap();
        assert_eq!(found.is_some(), truth, "query {number}");
        let Some(Impact { from, to }) = found else { continue };
        hits += 1;
        assert!(from == 0.0 || !meet_while_moving(&a, &b, [0.0, from]), "query {number}");
        if to.is_finite() {
            proven += 1;
            assert!(meet_while_moving(&a, &b, [from, to]), "query {number}");
        }
    }
    assert_eq!((hits, proven), (303, 303));
}

/// Every feature pair of which it is recorded that it meets, by a program with exact roots.
#[test]
fn cloth_ball_features() {
    let mesh = |frame: u32| data::mesh(&format!("cloth/cloth_ball/cloth_ball{frame}.ply"));
    let (start, end) = (mesh(92), mesh(93));
    let triangles = &start.triangles;
    let vertices = start.positions.len() as u32;
    let mut edges: Vec<_> = triangles
        .iter()
        .flat_map(|&[p, q, r]| [[p, q], [q, r], [r, p]])
        .map(|[p, q]| [p.max(q), p.min(q)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let first_face = vertices + edges.len() as u32;
    // A vertex, an edge or a face as a triangle.
    let feature = |number: u32| -> MovingTriangle {
        let corners = if number < vertices {
            [number; 3]
        } else if number < first_face {
            let [q, p] = edges[(number - vertices) as usize];
            [p, q, q]
        } else {
            triangles[(number - first_face) as usize]
        };
        [&start, &end].map(|mesh| corners.map(|v| mesh.positions[v as usize].map(f64::from)))
    };
    let (mut features, mut proven) = (0, 0);
    for kind in ["vf", "ee"] {
        let pairs = json(&format!("cloth/cloth_ball/92{kind}.json"));
        let truths = json(&format!("cloth/cloth_ball/92{kind}_mma_bool.json"));
        assert_eq!(pairs.len(), truths.len());
        for (pair, truth) in pairs.iter().zip(&truths) {
            let [p, q] = [0, 1].map(|k| pair[k].as_u64().unwrap() as u32);
            let truth = truth.as_bool().unwrap();
            let (a, b) = (feature(p), feature(q));
            let found = impact(&a, &b).unwrap();
            if truth {
                features += 1;
                let found = found.unwrap_or_else(|| panic!("{kind} {p} {q} is missed"));
                proven += u32::from(found.is_proven());
            } else if found.is_some_and(|impact| impact.is_proven()) {
                panic!("{kind} {p} {q} does not meet");
            }
        }
    }
    println!("{features} features meet, of which {proven} are proven to");
    assert_eq!(features, 113_854);
    assert!(f64::from(proven) >= 0.9999 * f64::from(features));
}

fn json(file: &str) -> Vec<serde_json::Value> {
    serde_json::from_slice(&std::fs::read(data::data().join(file)).unwrap()).unwrap()
}
