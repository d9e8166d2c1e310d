//! What a frame takes: building and refitting, the first frame and those after it, on one core and on
//! threads, under each schedule.
//!
//! `cargo bench --bench frames`. Threads go up to those of the machine. With recorded data
//! (`PFRONT_DATA`, see test.sh) two dragons of 871,414 triangles are added. Every answer on threads is
//! compared with that of one core before it is timed.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use pfront::core::build::{self, BvhStorage};
use pfront::core::bvh::node_bound;
use pfront::threads::{Schedule, Settings, Traversal};
use pfront::{BuildOptions, Model, Node, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_scenes::{Kind, Scene};
use rayon::ThreadPoolBuilder;
use std::hint::black_box;
use std::num::NonZero;
use std::sync::{Arc, LazyLock};
use std::thread::available_parallelism;

const SCHEDULES: [Schedule; 3] = [Schedule::Static, Schedule::Stealing, Schedule::Hybrid];
/// Frames that a bench goes to and fro over.
const FRAMES: usize = 16;

/// Consecutive frames of two models, or of one that deforms.
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
    let mesh = pfront_cli::mesh::read(&path).unwrap_or_else(|e| panic!("{e}"));
    Some(Model::new(mesh.positions, mesh.triangles).unwrap())
}

impl Case {
    fn name(&self) -> &'static str {
        match self {
            Self::Pair { name, .. } | Self::Within { name, .. } => name,
        }
    }

    fn model(&self) -> &Model {
        match self {
            Self::Pair { a, .. } => a,
            Self::Within { model, .. } => model,
        }
    }

    /// The pairs of a frame, counted to and fro.
    fn found<'q>(&self, query: &'q mut Asker, frame: usize) -> &'q [TrianglePair] {
        let turn = frame % (2 * FRAMES - 2);
        let frame = turn.min(2 * FRAMES - 2 - turn);
        match self {
            Self::Pair { a, b, poses, .. } => query.pair.all(a, b, &poses[frame]).unwrap(),
            Self::Within { frames, .. } => query.within.all(&frames[frame]),
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
    fn on(traversal: &Traversal) -> Self {
        Self {
            pair: PairQuery::new().with_traversal(traversal.clone()),
            within: SelfQuery::new().with_traversal(traversal.clone()),
        }
    }
}

/// A pool of `threads`, and a worker for each.
fn traversal(threads: usize, schedule: Schedule) -> Traversal {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let settings = Settings { schedule, ..Settings::default() };
    Traversal::with_pool(Arc::new(pool)).with_settings(settings)
}

fn thread_counts() -> Vec<usize> {
    let most = available_parallelism().map_or(1, NonZero::get);
    let powers = (0..).map(|i| 1 << i);
    powers.take_while(|&threads| threads < most).chain([most]).collect()
}

fn builds(c: &mut Criterion) {
    for case in CASES.iter() {
        let mesh = case.model().mesh();
        let n = mesh.triangles().len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let mut items = vec![build::SahItem::default(); build::sah_scratch_bound(n)];
        let mut keys = vec![0; build::morton_scratch_bound(n)];
        let options = BuildOptions::default();
        let mut group = c.benchmark_group(format!("build/{}", case.name()));
        group.sample_size(10);
        group.bench_function("sah", |bench| {
            bench.iter(|| {
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                build::sah(mesh, &options, storage, &mut items).unwrap().nodes().len()
            });
        });
        group.bench_function("morton", |bench| {
            bench.iter(|| {
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                build::morton(mesh, &options, storage, &mut keys).unwrap().nodes().len()
            });
        });
        let mut model = case.model().clone();
        let positions = mesh.positions().to_vec();
        group.bench_function("refit", |bench| {
            bench.iter(|| model.set_positions(black_box(&positions)).unwrap());
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
        group.bench_function("core", |bench| {
            let mut frame = 0;
            bench.iter(|| {
                frame += 1;
                case.found(&mut alone, frame).len()
            });
        });
        for schedule in SCHEDULES {
            for threads in thread_counts() {
                let mut query = Asker::on(&traversal(threads, schedule));
                for (frame, truth) in truth.iter().enumerate() {
                    assert_eq!(case.found(&mut query, frame), truth, "{schedule:?} {threads}");
                }
                group.bench_function(BenchmarkId::new(format!("{schedule:?}"), threads), |bench| {
                    let mut frame = 0;
                    bench.iter(|| {
                        frame += 1;
                        case.found(&mut query, frame).len()
                    });
                });
            }
        }
        group.finish();
    }
}

fn first_frames(c: &mut Criterion) {
    let threads = available_parallelism().map_or(1, NonZero::get);
    for case in CASES.iter() {
        let mut group = c.benchmark_group(format!("first frame/{}", case.name()));
        group.sample_size(10);
        for schedule in SCHEDULES {
            let fresh = Asker::on(&traversal(threads, schedule));
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
