//! Self-collision around one vertex against brute force with the exact oracle: where certificates answer.

use pfront::{Model, SelfQuery, TrianglePair};
use pfront_testkit::oracle::self_pairs;
use pfront_testkit::rng::{Rng, RngExt, seeded, seq::SliceRandom};

/// A centre and a rim about it, wound `turns` times, then disturbed.
fn rim(n: usize, turns: f32, rng: &mut impl Rng) -> Vec<[f32; 3]> {
    let (noise, height) = (rng.random_range(0.0..0.6), rng.random_range(0.0..1.0));
    let whole = rng.random_bool(0.5);
    let turned = rng.random_range(0..3);
    let mut points = vec![[0.0; 3]];
    for i in 0..n {
        let angle = turns * std::f32::consts::TAU * i as f32 / n as f32;
        let mut p = [angle.cos(), angle.sin(), height * rng.random_range(-1.0..1.0)];
        for x in &mut p {
            *x += noise * rng.random_range(-1.0..1.0);
            // On a coarse lattice, much is level, in line and in one plane.
            *x = if whole { (*x * 2.0).round() } else { *x };
        }
        p.rotate_left(turned);
        points.push(p);
    }
    points
}

/// The triangles around the centre, in any order and turned any way, some of them turned over.
fn one_ring(n: usize, ring: bool, rng: &mut impl Rng) -> Vec<[u32; 3]> {
    let n = n as u32;
    let over = if rng.random_bool(0.8) { 0.0 } else { 0.2 };
    let mut triangles: Vec<_> = (0..if ring { n } else { n - 1 })
        .map(|i| {
            let mut t = [0, i + 1, (i + 1) % n + 1];
            t.rotate_left(rng.random_range(0..3));
            if rng.random_bool(over) {
                t.swap(0, 1);
            }
            t
        })
        .collect();
    triangles.shuffle(rng);
    triangles
}

#[test]
fn rings_and_rows_of_every_kind() {
    let mut rng = seeded(9);
    let (mut certified, mut met) = (0, 0);
    for round in 0..20_000 {
        let n = rng.random_range(3..12);
        let turns = [1.0, 1.0, 0.5, 0.95, 1.05, 2.0][rng.random_range(0..6)];
        let triangles = one_ring(n, rng.random_bool(0.7), &mut rng);
        let mut model = Model::new(rim(n, turns, &mut rng), triangles.clone()).unwrap();
        let mut query = SelfQuery::new();
        // The second time, vertices have moved.
        for _ in 0..2 {
            let truth = self_pairs(model.mesh().positions().unwrap(), &triangles);
            let truth: Vec<_> = truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect();
            assert_eq!(query.all(&model).unwrap(), truth, "round {round}: {model:?}");
            certified += usize::from(model.certificates().is_certified(0));
            met += truth.len();
            model.set_positions(&rim(n, turns, &mut rng)).unwrap();
        }
    }
    assert!(certified > 3_000 && met > 3_000, "{certified} certified, {met} pairs");
}
