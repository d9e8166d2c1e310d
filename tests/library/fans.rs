//! Self-collision around vertices of many triangles: the true pairs, and as few tests as elsewhere.

use pfront::pfront_core::bvtt::{Query, SelfBvtt};
use pfront::{Adjacency, Model, SelfQuery, TrianglePair};
use pfront_testkit::oracle::{self_hit, self_pairs};
use pfront_testkit::rng::{Rng, RngExt, seeded, seq::SliceRandom};
use pfront_testkit::shapes::sheet;
use std::ops::ControlFlow;

/// A disc or part of one around vertex 0, or a cone, in any direction; its vertices are disturbed sometimes.
fn fan(n: usize, rng: &mut impl Rng) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let turns = [1.0, 1.0, 0.5, 0.97, 1.03][rng.random_range(0..5)];
    let (steepness, noise) =
        (rng.random_range(0.0..3.0), [0.0, 0.0, 1e-4, 0.05][rng.random_range(0..4)]);
    let (turned, is_ring) = (rng.random_range(0..3), rng.random_bool(0.7));
    let mut points = vec![[0.0; 3]];
    for i in 0..n {
        let angle = turns * std::f32::consts::TAU * i as f32 / n as f32;
        let mut p =
            [angle.cos(), angle.sin(), steepness].map(|x| x + noise * rng.random_range(-1.0..1.0));
        p.rotate_left(turned);
        points.push(p);
    }
    let n = n as u32;
    let last = if is_ring { n } else { n - 1 };
    let mut triangles: Vec<_> = (0..last).map(|i| [0, i + 1, (i + 1) % n + 1]).collect();
    match rng.random_range(0..6) {
        // One is there twice, one is turned over, one is missing.
        0 => triangles.push(triangles[7]),
        1 => triangles[7].swap(0, 1),
        2 => _ = triangles.swap_remove(7),
        _ => {}
    }
    triangles.iter_mut().for_each(|t| t.rotate_left(rng.random_range(0..3)));
    (points, triangles)
}

/// Fans alone, several at one vertex, side by side, folded, and through each other: nodes are skipped where they may be.
#[test]
fn fans_of_every_kind() {
    let mut rng = seeded(12);
    let (mut certified, mut met) = (0, 0);
    for round in 0..60 {
        let (mut points, mut triangles) = fan(rng.random_range(60..150), &mut rng);
        let is_second_at_the_same = rng.random_bool(0.3);
        if rng.random_bool(0.6) {
            let (more, others) = fan(rng.random_range(10..120), &mut rng);
            let (first, aside) = (points.len() as u32, rng.random_range(-1.0..1.0));
            let at = |vertex| if is_second_at_the_same && vertex == 0 { 0 } else { first + vertex };
            points.extend(more.iter().map(|&[x, y, z]| [x + aside, y, z]));
            triangles.extend(others.iter().map(|t| t.map(at)));
        }
        triangles.shuffle(&mut rng);
        let is_f64 = rng.random_bool(0.3);
        let mut model = if is_f64 {
            let points = points.iter().map(|p| p.map(|x| f64::from(x) + 0.1)).collect();
            Model::from_f64(points, triangles.clone()).unwrap()
        } else {
            Model::new(points.clone(), triangles.clone()).unwrap()
        };
        for time in 0..3 {
            let truth: Vec<_> = if let Some(points) = model.mesh().positions_f64() {
                let hits = |&(a, b): &(usize, usize)| self_hit(triangles[a], triangles[b], points);
                let all = (0..triangles.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
                all.filter(hits).map(|(a, b)| TrianglePair { a: a as u32, b: b as u32 }).collect()
            } else {
                let pairs = self_pairs(model.mesh().shadow(), &triangles);
                pairs.iter().map(|&(a, b)| TrianglePair { a, b }).collect()
            };
            let mut truth = truth;
            truth.sort_unstable();
            assert_eq!(SelfQuery::new().all(&model).unwrap(), truth, "round {round}, {time}");
            for rule in [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours] {
                let plain = SelfBvtt::new(model.bvh()).with_adjacency(rule);
                let skipping = plain.with_certificates(model.certificates());
                assert_eq!(skipping.count(), plain.count(), "round {round}, {time}, {rule:?}");
            }
            certified += usize::from(model.certificates().is_certified(0));
            met += truth.len();
            // The hub moves, first a little.
            let to = 0.03 * (40 * time + 1) as f32;
            if is_f64 {
                let mut points = model.mesh().positions_f64().unwrap().to_vec();
                points[0] = [0.1 + f64::from(to), 0.1, 0.1];
                model.set_positions(&points).unwrap();
            } else {
                points[0] = [to, 0.0, 0.0];
                model.set_positions(&points).unwrap();
            }
        }
    }
    assert!(certified > 20 && met > 1_000, "{certified} certified, {met} pairs");
}

/// The tests of a self query with certificates.
fn tests(points: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> u64 {
    let model = Model::new(points, triangles).unwrap();
    let query = SelfBvtt::new(model.bvh()).with_certificates(model.certificates());
    let mut cursor = query.start();
    assert!(query.visit(&mut cursor, |_| ControlFlow::Break(())).is_continue(), "no hit");
    cursor.work.tests()
}

/// So many triangles in a grid, in a disc around its centre and from its rim, in a cone, and around both poles of a sphere.
#[test]
fn a_vertex_of_many_triangles_takes_as_many_tests_as_a_grid() {
    let n = 20_000;
    let grid = sheet(100, |_, _| 0.0);
    let most = 2 * tests(grid.positions, grid.triangles);
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i % n) / f64::from(n);
    let rim = |z: f32| (0..n).map(move |i| [angle(i).cos() as f32, angle(i).sin() as f32, z]);
    for height in [0.0, 0.5] {
        let points = std::iter::once([0.0, 0.0, height]).chain(rim(0.0)).collect();
        let around = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
        assert!(tests(points, around) < most, "around the centre, {height}");
    }
    let face = (1..n - 1).map(|i| [0, i, i + 1]).collect();
    assert!(tests(rim(0.0).collect(), face) < most, "a face of many corners");
    // Two rims with a band between, and a pole beyond each.
    let points = rim(0.5).chain(rim(-0.5)).chain([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]).collect();
    let next = |i: u32| (i + 1) % n;
    let meridian = |i: u32| {
        let ([a, b], [c, d]) = ([i, next(i)], [n + i, n + next(i)]);
        [[2 * n, a, b], [a, c, d], [a, d, b], [2 * n + 1, d, c]]
    };
    assert!(tests(points, (0..n).flat_map(meridian).collect()) < 4 * most, "both poles");
}
