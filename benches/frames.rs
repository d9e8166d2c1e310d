//! The parts of a frame: building and refitting, the first frame and those after it, on one core and on
//! threads, under each schedule.
//!
//! `cargo bench --bench frames`. Threads go up to those of the machine. With recorded data
//! (`PFRONT_DATA`, see test.sh) two dragons of 871,414 triangles are added. Every answer on threads is
//! compared with that of one core before it is timed.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use pfront::threads::{Pool, Schedule, Settings};
use pfront::{BuildOptions, Executor, Model, Node, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_core::bvh::{self, BvhStorage, node_bound};
use pfront_testkit::scenes::{Kind, Scene};
use rayon::ThreadPoolBuilder;
use std::hint::black_box;
use std::sync::{Arc, LazyLock};

const SCHEDULES: [Schedule; 2] = [Schedule::Static, Schedule::Hybrid];

/// Frames that a bench goes to and fro over.
const FRAMES: usize = 16;

/// Consecutive frames of two models, or of one that deforms.
#[expect(clippy::large_enum_variant, reason = "there are few cases, each for the whole run")]
enum Case {
    Pair { name: &'static str, a: Model, b: Model, poses: Vec<Pose> },
    Within { name: &'static str, model: Model, frames: Vec<Model> },
}

/// Built once.
static CASES: LazyLock<Vec<Case>> = LazyLock::new(cases);

fn cases() -> Vec<Case> {
    let mut cases = vec![
        generated("worm-gear", None, 60),
        generated("torus-knots", Some(1_000_000), 60),
        generated("sheet", None, 100),
    ];
    cases.extend(dragon().map(|model| {
        let sway = |i: usize| Pose::from_translation([0.02 + 0.0002 * i as f32, 0.0, 0.0]);
        let poses = (0..FRAMES).map(sway).collect();
        Case::Pair { name: "dragons", a: model.clone(), b: model, poses }
    }));
    cases
}

fn generated(name: &'static str, size: Option<usize>, from: usize) -> Case {
    let scene = Scene::by_name(name, size).unwrap();
    let model = |object: usize| {
        let mesh = &scene.meshes[scene.objects[object]];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
    };
    let frames = from..from + FRAMES;
    if scene.kind() == Kind::Pair {
        let mut rows = Vec::new();
        let pose = |frame| {
            scene.poses(frame, &mut rows);
            Pose::new(rows[1])
        };
        return Case::Pair { name, a: model(0), b: model(1), poses: frames.map(pose).collect() };
    }
    let mut positions = Vec::new();
    let mut moved = model(0);
    let frame = |frame| {
        scene.positions(frame, &mut positions);
        moved.set_positions(&positions).unwrap();
        moved.clone()
    };
    Case::Within { name, frames: frames.map(frame).collect(), model: model(0) }
}

fn dragon() -> Option<Model> {
    let folder = std::env::var_os("PFRONT_DATA")?;
    let path = std::path::Path::new(&folder).join("classic/dragon_871414.ply");
    let mesh = pfront_files::read_f32(&path).unwrap_or_else(|e| panic!("{e}"));
    Some(Model::new(mesh.positions, mesh.triangles).unwrap())
}

/// The number of the frame that comes next, to and fro; never twice the same, whose answer a query would have kept.
fn turn(number: usize) -> usize {
    let turn = number % (2 * FRAMES - 2);
    turn.min(2 * FRAMES - 2 - turn)
}

impl Case {
    fn name(&self) -> &'static str {
        match self {
            Self::Pair { name, .. } | Self::Within { name, .. } => name,
        }
    }

    /// The pairs of a frame.
    fn found<'q>(&self, query: &'q mut Asker, frame: usize) -> &'q [TrianglePair] {
        match self {
            Self::Pair { a, b, poses, .. } => query.pair.all(a, b, poses[frame]).unwrap(),
            Self::Within { frames, .. } => query.within.all(&frames[frame]).unwrap(),
        }
    }
}

/// A query of either kind.
#[derive(Clone, Default)]
struct Asker {
    pair: PairQuery,
    within: SelfQuery,
}

impl Asker {
    fn on(pool: &Pool) -> Self {
        let executor = Executor::from(pool.clone());
        Self { pair: PairQuery::new().on(&executor), within: SelfQuery::new().on(&executor) }
    }
}

/// A pool of `threads`, and a worker for each.
fn pool(threads: usize, schedule: Schedule) -> Pool {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let settings = Settings { schedule, ..Settings::default() };
    Pool::from(Arc::new(pool)).with_settings(settings)
}

/// Threads of this machine.
fn all_threads() -> usize {
    std::thread::available_parallelism().unwrap().get()
}

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
