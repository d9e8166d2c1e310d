//! Batches: how many of 10,000 poses a second, or of as many as PFRONT_POSES says, can be asked for any triangle pair that meets.
//!
//! `PFRONT_DATA=... cargo bench --bench batch`, with `--features gpu` on a GPU as well. Two bunnies of 69,451 triangles, or
//! two torus knots if there is no such data, in random poses in which they overlap in part or just miss:
//! - "one by one": a [`PairQuery`] on one thread, and parry's own query of two meshes;
//! - "batch": a [`Batch`] on one thread, on all threads, and on a GPU that does not compute on the CPU.
//!
//! All answers of pfront are compared before anything is timed; in how many of 200 poses parry says otherwise is printed.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use parry3d::math::{Mat3, Pose as Isometry, Rotation, Vec3};
use parry3d::query::intersection_test;
use parry3d::shape::TriMesh as ParryMesh;
use pfront::threads::Pool;
use pfront::{Batch, Executor, Model, PairQuery, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Scene, torus_knot};
use rayon::ThreadPoolBuilder;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

/// Poses, unless PFRONT_POSES says how many.
const POSES: usize = 10_000;
/// Poses that parry is asked about, which takes hundreds of times as long.
const FEW: usize = 200;
const SEED: u64 = 11;

fn mesh() -> (&'static str, MeshData) {
    let Some(folder) = std::env::var_os("PFRONT_DATA") else {
        return ("torus knots", torus_knot(70_000));
    };
    let path = std::path::Path::new(&folder).join("classic/bunny_69451.obj");
    let mesh = pfront_files::read_f32(&path).unwrap();
    ("bunnies", MeshData { positions: mesh.positions, triangles: mesh.triangles })
}

fn pool(threads: usize) -> Executor {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    Pool::from(Arc::new(pool)).into()
}

fn executors() -> Vec<(String, Executor)> {
    let all = rayon::current_num_threads();
    #[cfg_attr(not(feature = "gpu"), expect(unused_mut, reason = "a GPU comes last"))]
    let mut executors: Vec<_> = [1, all].map(|n| (format!("batch, {n} threads"), pool(n))).into();
    #[cfg(feature = "gpu")]
    {
        use pfront::gpu::{Gpu, wgpu::DeviceType};
        match Gpu::new() {
            Ok(gpu) if gpu.device().adapter_info().device_type != DeviceType::Cpu => {
                executors.push(("batch, GPU".to_owned(), Executor::gpu(&gpu, gpu.settings())));
            }
            _ => eprintln!("no GPU"),
        }
    }
    executors
}

/// A pose as parry takes it: a rotation and a translation.
fn isometry(pose: &Pose) -> Isometry {
    let [x, y, z] = pose.rows;
    let rows = [x, y, z].map(|[x, y, z, _]| Vec3::new(x, y, z));
    let rotation = Mat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    Isometry::from_parts(Vec3::new(x[3], y[3], z[3]), Rotation::from_mat3(&rotation))
}

fn poses(c: &mut Criterion) {
    let (name, mesh) = mesh();
    let count = std::env::var("PFRONT_POSES").map_or(POSES, |count| count.parse().unwrap());
    let course = Scene::course(mesh.clone(), mesh.clone(), count, SEED);
    let mut rows = Vec::new();
    let pose = |frame| {
        course.poses(frame, &mut rows);
        Pose::new(rows[1])
    };
    let poses: Vec<_> = (0..count).map(pose).collect();
    let vertices = mesh.positions.iter().copied().map(Vec3::from_array).collect();
    let parry = ParryMesh::new(vertices, mesh.triangles.clone()).unwrap();
    let isometries: Vec<_> = poses.iter().map(isometry).collect();
    let model = Arc::new(Model::new(mesh.positions, mesh.triangles).unwrap());
    let mut batch = Batch::new();
    for pose in &poses {
        batch.pair(&model, &model, pose).unwrap();
    }

    let mut query = PairQuery::new();
    let mut one_by_one = |pose| query.any(&model, &model, pose).unwrap().is_some();
    let truth: Vec<_> = poses.iter().map(&mut one_by_one).collect();
    let meet = truth.iter().filter(|&&meets| meets).count();
    eprintln!("{name}: {meet} of {count} poses meet");

    let mut group = c.benchmark_group(format!("any of {count} poses, {name}"));
    group.throughput(Throughput::Elements(count as u64));
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_secs(1));
    group.bench_function("one by one", |bench| {
        bench.iter(|| poses.iter().map(&mut one_by_one).filter(|&meets| meets).count());
    });
    for (who, executor) in &executors() {
        let found = batch.any(executor).unwrap().read().unwrap();
        assert!(found.iter().map(Option::is_some).eq(truth.iter().copied()), "{who}");
        group.bench_function(who, |bench| {
            bench.iter(|| black_box(batch.any(executor).unwrap().read().unwrap()));
        });
    }
    let meets = |pose| intersection_test(&Isometry::IDENTITY, &parry, pose, &parry).unwrap();
    let meets = |pose| meets(pose).intersecting;
    let few = FEW.min(count);
    let isometries = &isometries[..few];
    let others = isometries.iter().zip(&truth).filter(|(pose, truth)| meets(pose) != **truth);
    eprintln!("{name}: parry says otherwise in {} of {few} poses", others.count());
    group.throughput(Throughput::Elements(few as u64));
    group.bench_function("parry, one by one", |bench| {
        bench.iter(|| isometries.iter().filter(|pose| meets(pose)).count());
    });
    group.finish();
}

criterion_group!(benches, poses);
criterion_main!(benches);
