//! The parts of a frame: building and refitting, the first frame and those after it, on one core and on
//! threads, under each schedule.
//!
//! `cargo bench --bench frames`. Threads go up to those of the machine. With recorded data
//! (`PFRONT_DATA`, see test.sh) two dragons of 871,414 triangles are added. Every answer on threads is
//! compared with that of one core before it is timed.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

mod cases;

use cases::{Asker, CASES, Case, FRAMES, all_threads, pool, turn};
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use pfront::threads::{Pool, Schedule};
use pfront::{BuildOptions, Executor, Model, Node};
use pfront_core::bvh::node_bound;
use pfront_core::bvh::{self, BvhStorage};
use std::hint::black_box;

const SCHEDULES: [Schedule; 2] = [Schedule::Static, Schedule::Hybrid];

fn thread_counts() -> Vec<usize> {
    let most = all_threads();
    let powers = (0..).map(|i| 1 << i);
    powers.take_while(|&threads| threads < most).chain([most]).collect()
}

/// The model whose builds and refits a case measures.
fn model(case: &Case) -> &Model {
    match case {
        Case::Pair { a, .. } => a,
        Case::Within { model, .. } => model,
    }
}

/// On one thread and on all; a test of `pfront-cpu` compares the trees.
fn builds(c: &mut Criterion) {
    for case in CASES.iter() {
        let mesh = model(case).mesh();
        let n = mesh.triangles().len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let mut items = vec![Node::EMPTY; n];
        let mut keys = vec![0; 2 * n];
        let mut group = c.benchmark_group(format!("build/{}", case.name()));
        group.sample_size(10);
        let threads = all_threads();
        let joins: [(usize, Option<&bvh::Join<'_>>); 2] =
            [(1, None), (threads, Some(&pfront::threads::join))];
        for (threads, join) in joins {
            let options = BuildOptions { join, ..BuildOptions::default() };
            group.bench_function(BenchmarkId::new("sah", threads), |bench| {
                bench.iter(|| {
                    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                    bvh::sah(mesh, &options, storage, &mut items).unwrap().nodes().len()
                });
            });
            group.bench_function(BenchmarkId::new("morton", threads), |bench| {
                bench.iter(|| {
                    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                    bvh::morton(mesh, &options, storage, &mut keys).unwrap().nodes().len()
                });
            });
        }
        let mut moving = model(case).clone();
        // In turns, since nothing is refitted to the positions that a model has.
        let scaled = |by: f32| mesh.shadow().iter().map(|p| p.map(|x| by * x)).collect();
        let mut shapes: [Vec<[f32; 3]>; 2] = [scaled(1.001), scaled(0.999)];
        group.bench_function(BenchmarkId::new("refit", 1), |bench| {
            bench.iter(|| {
                shapes.swap(0, 1);
                moving.set_positions(black_box(&shapes[0])).unwrap();
            });
        });
        let executor = Executor::from(Pool::default());
        group.bench_function(BenchmarkId::new("refit", threads), |bench| {
            bench.iter(|| {
                shapes.swap(0, 1);
                executor.refit(&mut moving, black_box(&shapes[0])).unwrap();
            });
        });
        group.finish();
    }
}

fn frames(c: &mut Criterion) {
    for case in CASES.iter() {
        let mut alone = Asker::default();
        let truth: Vec<_> =
            (0..FRAMES).map(|frame| case.found(&mut alone, frame).to_vec()).collect();
        let mut group = c.benchmark_group(format!("coherent frame/{}", case.name()));
        group.sample_size(20);
        // Goes on from sample to sample: with a frame a sample, each would be the one before.
        let mut frame = 0;
        group.bench_function("core", |bench| {
            bench.iter(|| {
                frame += 1;
                case.found(&mut alone, turn(frame)).len()
            });
        });
        for schedule in SCHEDULES {
            for threads in thread_counts() {
                let mut query = Asker::on(&pool(threads, schedule));
                for (frame, truth) in truth.iter().enumerate() {
                    assert_eq!(case.found(&mut query, frame), truth, "{schedule:?} {threads}");
                }
                let mut frame = 0;
                group.bench_function(BenchmarkId::new(format!("{schedule:?}"), threads), |bench| {
                    bench.iter(|| {
                        frame += 1;
                        case.found(&mut query, turn(frame)).len()
                    });
                });
            }
        }
        group.finish();
    }
}

fn first_frames(c: &mut Criterion) {
    let threads = all_threads();
    for case in CASES.iter() {
        let mut group = c.benchmark_group(format!("first frame/{}", case.name()));
        group.sample_size(10);
        for schedule in SCHEDULES {
            let fresh = Asker::on(&pool(threads, schedule));
            group.bench_function(BenchmarkId::new(format!("{schedule:?}"), threads), |bench| {
                bench.iter_batched_ref(
                    || fresh.clone(),
                    |query| case.found(query, 0).len(),
                    BatchSize::PerIteration,
                );
            });
        }
        group.finish();
    }
}

criterion_group!(benches, builds, frames, first_frames);
criterion_main!(benches);
