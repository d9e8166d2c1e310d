//! Recorded truths of moving features: the public queries of Wang et al., and the cloth that falls on a ball.
//!
//! They run with `--features recorded`; `data.rs` says where the data is looked for.

use super::data;
use pfront::{Bvh, Executor, Impact, Model, Motion, Pose, SelfQuery};
use pfront_core::bvh::{Refit, refit};
use pfront_core::bvtt::{PosedBvh, SelfBvtt, Work};
use pfront_core::motion::{MovingBvh, MovingTriangle, impact};
use pfront_testkit::oracle::{meet_while_moving, share_a_vertex};
use std::collections::{HashMap, HashSet};
use std::ops::ControlFlow;
use std::time::Instant;

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
    let edges = edges(triangles);
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

/// The edges as the recorded features number them.
fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<_> = triangles
        .iter()
        .flat_map(|&[p, q, r]| [[p, q], [q, r], [r, p]])
        .map(|[p, q]| [p.max(q), p.min(q)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn json(file: &str) -> Vec<serde_json::Value> {
    serde_json::from_slice(&std::fs::read(data::data().join(file)).unwrap()).unwrap()
}

/// Every triangle pair of which a recorded feature pair is a part, unless they share a vertex.
#[test]
fn cloth_ball_triangles() {
    let model = |frame: u32| {
        let read = data::mesh(&format!("cloth/cloth_ball/cloth_ball{frame}.ply"));
        Model::new(read.positions, read.triangles).unwrap()
    };
    let (start, end) = (model(92), model(93));
    let begin = Instant::now();
    let impacts = SelfQuery::new().impacts(&Motion::between(&start, &end).unwrap()).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    let proven = impacts.iter().filter(|hit| hit.1.is_proven()).count();
    println!("ball: {} pairs, {proven} proven; {seconds:.2} s on one thread", impacts.len());
    for workers in [1, 2, 7] {
        let threads = &Executor::threads(workers);
        let motion = Motion::between(&start, &end).unwrap();
        let mut query = SelfQuery::new().on(threads);
        assert_eq!(query.impacts(&motion).unwrap(), impacts);
        let first =
            impacts.iter().min_by(|p, q| (p.1.from, p.0).partial_cmp(&(q.1.from, q.0)).unwrap());
        assert_eq!(query.first_impact(&motion).unwrap().as_ref(), first);
    }
    assert!(proven as f64 >= 0.9999 * impacts.len() as f64);
    let found: HashSet<_> = impacts.iter().map(|(pair, _)| (pair.a, pair.b)).collect();

    let triangles = start.mesh().triangles();
    let vertices = start.mesh().vertex_count() as u32;
    let edges = edges(triangles);
    let mut around = HashMap::<u32, Vec<u32>>::new();
    let first_face = vertices + edges.len() as u32;
    for (number, &[p, q, r]) in triangles.iter().enumerate() {
        let own = [[p, q], [q, r], [r, p]]
            .map(|[p, q]| vertices + edges.binary_search(&[p.max(q), p.min(q)]).unwrap() as u32);
        for feature in [p, q, r].into_iter().chain(own).chain([first_face + number as u32]) {
            around.entry(feature).or_default().push(number as u32);
        }
    }
    let mut asked = 0;
    for kind in ["vf", "ee"] {
        let pairs = json(&format!("cloth/cloth_ball/92{kind}.json"));
        let truths = json(&format!("cloth/cloth_ball/92{kind}_mma_bool.json"));
        for (pair, _) in pairs.iter().zip(&truths).filter(|(_, truth)| truth.as_bool().unwrap()) {
            let [p, q] = [0, 1].map(|k| &around[&(pair[k].as_u64().unwrap() as u32)]);
            for (&a, &b) in p.iter().flat_map(|a| q.iter().map(move |b| (a, b))) {
                if share_a_vertex(triangles[a as usize], triangles[b as usize]) {
                    continue;
                }
                asked += 1;
                assert!(found.contains(&(a.min(b), a.max(b))), "{kind} {a} {b} is missed");
            }
        }
    }
    println!("{asked} triangle pairs of features that meet, none missed");
}

/// Steps of a garment: box tests of the motion as multiples of those at rest, and how long one takes.
#[test]
fn kick_steps() {
    let first = data::mesh("cloth/kick/kick_frame000.ply");
    let positions = data::vectors("cloth/kick/kick_positions_121x12811x3.f32le");
    let frames: Vec<_> = positions.chunks_exact(12_811).collect();
    let [mut moving, mut at_rest] = [Work::default(); 2];
    let (mut seconds, mut hits, mut proven) = (0.0, 0, 0);
    let steps = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110];
    for step in steps {
        let [start, end] = [step, step + 1].map(|frame| {
            let mut model = Model::new(first.positions.clone(), first.triangles.clone()).unwrap();
            model.set_positions(frames[frame]).unwrap();
            model
        });
        let motion = Motion::between(&start, &end).unwrap();
        let begin = Instant::now();
        let impacts = SelfQuery::new().impacts(&motion).unwrap();
        seconds += begin.elapsed().as_secs_f64();
        (hits, proven) =
            (hits + impacts.len(), proven + impacts.iter().filter(|hit| hit.1.is_proven()).count());
        let mut nodes = start.bvh().nodes().to_vec();
        refit(end.mesh(), &mut nodes, start.bvh().order(), Refit::default()).unwrap();
        let moved = Bvh::new_unchecked(end.mesh(), &nodes, start.bvh().order());
        let [start, moved] =
            [start.bvh(), moved].map(|bvh| PosedBvh::new(bvh, &Pose::IDENTITY).unwrap());
        for (to, work) in [(moved, &mut moving), (start, &mut at_rest)] {
            let tree = SelfBvtt::moving(MovingBvh::new(start, to).unwrap());
            let _ = tree.visit_below(tree.root().unwrap(), work, |_, _| ControlFlow::Continue(()));
        }
    }
    let ratio = moving.box_tests as f64 / at_rest.box_tests as f64;
    let tests = moving.triangle_tests as f64 / at_rest.triangle_tests as f64;
    println!(
        "kick: {hits} pairs, {proven} proven; box tests x {ratio:.3}, triangle tests x {tests:.3}; {:.1} ms a step",
        1000.0 * seconds / steps.len() as f64
    );
    assert!(ratio <= 1.05 && proven as f64 >= 0.9999 * f64::from(hits as u32));
}
