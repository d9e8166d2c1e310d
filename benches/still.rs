//! No more than what moves: a scene of 10,000 bodies of which all move, 1 % do, or none.
//!
//! `cargo bench --bench still`. A frame moves the bodies that move, to and fro, and asks for all pairs, or for all contacts.
//! Answers are compared with those of a scene that remembers nothing before anything is timed.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use pfront::{BodyId, Executor, Model, Pose, SceneQuery};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::scenes::icosphere;
use std::sync::Arc;

const BODIES: usize = 10_000;
/// Triangles of each body.
const TRIANGLES: usize = 320;
/// Bodies along an edge of the heap, in which each lies where ...
const EDGE: usize = 22;
/// ... in radii, it touches most of its six neighbours, ...
const APART: f32 = 1.95;
/// ... more or less.
const MORE_OR_LESS: f32 = 0.05;

/// A scene, and both places that each of its bodies may have.
struct Crowd {
    query: SceneQuery,
    bodies: Vec<(BodyId, [Pose; 2])>,
    /// How many of them move.
    moving: usize,
    frame: usize,
}

impl Crowd {
    fn new(mut query: SceneQuery, moving: usize) -> Self {
        let random = &mut seeded(1);
        let ball = icosphere(TRIANGLES);
        let ball = Arc::new(Model::new(ball.positions, ball.triangles).unwrap());
        let mut body = |number: usize| {
            let cell = [number % EDGE, number / EDGE % EDGE, number / EDGE / EDGE];
            let place =
                cell.map(|i| APART * i as f32 + random.random_range(-MORE_OR_LESS..MORE_OR_LESS));
            let poses = [0.0, 0.02].map(|aside| Pose::from_translation(place.map(|x| x + aside)));
            (query.add(ball.clone(), poses[0]).unwrap(), poses)
        };
        let bodies = (0..BODIES).map(&mut body).collect();
        Self { query, bodies, moving, frame: 0 }
    }

    /// Moves those that move.
    fn step(&mut self) -> &mut SceneQuery {
        self.frame += 1;
        for (body, poses) in &self.bodies[..self.moving] {
            self.query.set_pose(*body, poses[self.frame % 2]).unwrap();
        }
        &mut self.query
    }
}

fn still(c: &mut Criterion) {
    let mut group = c.benchmark_group("still");
    group.sample_size(20);
    let executors = [("one thread", Executor::sequential()), ("auto", Executor::auto())];
    for (name, moving) in [("all move", BODIES), ("1 % move", BODIES / 100), ("none moves", 0)] {
        for (who, executor) in &executors {
            let mut crowd = Crowd::new(SceneQuery::new().on(executor), moving);
            for _ in 0..3 {
                let found = crowd.step().all().unwrap().len();
                let mut fresh = Crowd::new(SceneQuery::new(), moving);
                fresh.frame = crowd.frame - 1;
                assert_eq!(found, fresh.step().all().unwrap().len(), "{name}, {who}");
            }
            group.bench_function(BenchmarkId::new(name, who), |bench| {
                bench.iter(|| crowd.step().all().unwrap().len());
            });
            if moving > 0 {
                let name = format!("{name}, contacts");
                group.bench_function(BenchmarkId::new(name, who), |bench| {
                    bench.iter(|| crowd.step().contacts().unwrap().len());
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, still);
criterion_main!(benches);
