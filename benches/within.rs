//! Pairs within a distance, beside those that intersect; and the smallest distance, beside parry's: two torus knots, by mean edges.
//!
//! `cargo bench --bench within [-- MESH_FILE]`: two of a mesh of a file instead. Best times of some rounds in turn, on one
//! thread and on all, and how many times those at 0 they are. The smallest distance is that of poses which turn by a degree a
//! frame, at the gap of a seventh of the width in the first; parry's is wrong if it is not in our interval, but for 1e-5 of it.
//! Batches are those of 10,000 poses of an arm within the mesh.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use glam::Vec3;
use pfront::{Batch, Executor, Model, PairQuery, Pose};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::scenes::torus_knot;
use pfront_testkit::shapes::sphere;
use std::sync::Arc;
use std::time::Instant;

/// As few as that in a test, which runs the bench once.
const TRIANGLES: usize = if cfg!(debug_assertions) { 20_000 } else { 800_000 };
const ROUNDS: usize = if cfg!(debug_assertions) { 1 } else { 15 };

/// Frames in which the smallest distance is asked for.
const FRAMES: usize = if cfg!(debug_assertions) { 2 } else { 20 };

/// Poses of an arm.
const ARMS: usize = if cfg!(debug_assertions) { 5 } else { 10_000 };

/// In mean edges.
const DISTANCES: [f32; 6] = [0.0, 0.01, 0.1, 0.5, 1.0, 2.0];

fn main() {
    let file = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let (positions, triangles) = match file {
        Some(path) => {
            let mesh = pfront_files::read_f32(path.as_ref()).unwrap();
            (mesh.positions, mesh.triangles)
        }
        None => {
            let knot = torus_knot(TRIANGLES);
            (knot.positions, knot.triangles)
        }
    };
    let point = |vertex: u32| Vec3::from_array(positions[vertex as usize]);
    let lengths = triangles.iter().map(|&[a, b, _]| f64::from(point(a).distance(point(b))));
    let edge = (lengths.sum::<f64>() / triangles.len() as f64) as f32;
    let across = positions.iter().map(|p| p[0]);
    let width = across.clone().fold(f32::MIN, f32::max) - across.fold(f32::MAX, f32::min);
    let pose = Pose::from_rotation_translation(
        [0.0, 0.05, 0.0, (1.0_f32 - 0.0025).sqrt()],
        [0.35 * width, 0.0, 0.0],
    );
    let model = Model::new(positions, triangles).unwrap();
    let threads = std::thread::available_parallelism().unwrap().get();
    let executors = [(1, Executor::sequential()), (threads, Executor::threads(threads))];
    for (threads, executor) in &executors {
        let queries = DISTANCES.map(|d| PairQuery::new().on(executor).within(d * edge).unwrap());
        let (mut queries, mut best) = (queries, [f64::INFINITY; DISTANCES.len()]);
        let mut pairs = [0; DISTANCES.len()];
        for _ in 0..ROUNDS {
            for (i, query) in queries.iter_mut().enumerate() {
                query.forget();
                let began = Instant::now();
                pairs[i] = query.all(&model, &model, pose).unwrap().len();
                best[i] = best[i].min(began.elapsed().as_secs_f64());
            }
        }
        assert!(pairs.is_sorted(), "pairs only become more with the distance");
        for (i, distance) in DISTANCES.into_iter().enumerate() {
            let (ms, ratio) = (best[i] * 1e3, best[i] / best[0]);
            println!(
                "{threads} threads, {distance} edges: {} pairs, {ms:.2} ms, {ratio:.1} x",
                pairs[i]
            );
        }
    }
    let truth = distances(&model, width, &executors);
    parry(&model, width, &truth);
    arm(&model, width, &executors);
}

/// Times batches of poses of an arm of three links that stands within the model: whether the links meet it, and how far apart.
fn arm(cell: &Model, width: f32, executors: &[(usize, Executor)]) {
    let (cell, reach) = (Arc::new(cell.clone()), 0.2 * width);
    let link =
        sphere(24).map(|[x, y, z]| [reach * (0.5 + 0.5 * x), 0.1 * reach * y, 0.1 * reach * z]);
    let link = Arc::new(Model::new(link.positions, link.triangles).unwrap());
    let mut batch = Batch::new();
    let mut rng = seeded(5);
    for _ in 0..ARMS {
        let (mut angle, mut joint) = (0.0_f32, Vec3::ZERO);
        for _ in 0..3 {
            angle += rng.random_range(-1.5..1.5_f32);
            let (sin, cos) = (0.5 * angle).sin_cos();
            batch
                .pair(
                    &cell,
                    &link,
                    Pose::from_rotation_translation([0.0, 0.0, sin, cos], joint.to_array()),
                )
                .unwrap();
            joint += reach * Vec3::new(angle.cos(), angle.sin(), 0.0);
        }
    }
    for (threads, executor) in executors {
        let mut best = [f64::INFINITY; 2];
        let mut meet = 0;
        for _ in 0..ROUNDS.min(5) {
            let began = Instant::now();
            let any = batch.any(executor).unwrap().read().unwrap();
            best[0] = best[0].min(began.elapsed().as_secs_f64() * 1e3);
            let began = Instant::now();
            let gaps = batch.distance(executor).unwrap().read().unwrap();
            best[1] = best[1].min(began.elapsed().as_secs_f64() * 1e3);
            meet = any.iter().flatten().count();
            assert_eq!(gaps.iter().flatten().filter(|gap| gap.interval[1] == 0.0).count(), meet);
        }
        let [any, distance] = best;
        println!(
            "{threads} threads, {ARMS} poses of an arm, {meet} of {} links meet the cell: any {any:.1} ms, distance {distance:.1}, {:.2} x",
            batch.len(),
            distance / any
        );
    }
}

/// A pose for each frame, in which the second is 1.15 widths away and turned by some degrees.
fn frames(width: f32) -> impl Iterator<Item = Pose> {
    (0..FRAMES).map(move |frame| {
        let (sin, cos) = (0.5 * (frame as f32).to_radians()).sin_cos();
        Pose::from_rotation_translation([0.0, sin, 0.0, cos], [1.15 * width, 0.0, 0.0])
    })
}

/// Times the smallest distance by each executor, by a new query for each frame and by one for all. Returns the intervals.
fn distances(model: &Model, width: f32, executors: &[(usize, Executor)]) -> Vec<[f64; 2]> {
    let mut truth: Vec<[f64; 2]> = Vec::new();
    for (threads, executor) in executors {
        let mut best = [[f64::INFINITY; FRAMES]; 2];
        for _ in 0..ROUNDS {
            let mut kept = PairQuery::new().on(executor);
            for (frame, pose) in frames(width).enumerate() {
                let mut new = PairQuery::new().on(executor);
                for (query, best) in [&mut new, &mut kept].into_iter().zip(&mut best) {
                    let began = Instant::now();
                    let gap = query.distance(model, model, pose).unwrap().unwrap();
                    best[frame] = best[frame].min(began.elapsed().as_secs_f64() * 1e3);
                    if truth.len() == frame {
                        truth.push(gap.interval);
                    }
                    assert_eq!(
                        gap.interval, truth[frame],
                        "every answer to a question is the same"
                    );
                }
            }
        }
        let [mut new, mut kept] = best;
        tell(&format!("{threads} threads, distance"), &mut new);
        tell(&format!("{threads} threads, distance of frame after frame"), &mut kept);
    }
    truth
}

fn parry(model: &Model, width: f32, truth: &[[f64; 2]]) {
    use parry3d::math::{Pose as ParryPose, Rotation, Vec3 as V};
    let mesh = model.mesh();
    let vertices = mesh.shadow().iter().copied().map(V::from_array).collect();
    let parry = parry3d::shape::TriMesh::new(vertices, mesh.triangles().to_vec()).unwrap();
    let (mut times, mut wrong) = (Vec::new(), 0);
    for (frame, [low, high]) in truth.iter().enumerate() {
        let turn = Rotation::from_rotation_y((frame as f32).to_radians());
        let pose = ParryPose::from_parts(V::new(1.15 * width, 0.0, 0.0), turn);
        let began = Instant::now();
        let found = parry3d::query::distance(&ParryPose::IDENTITY, &parry, &pose, &parry).unwrap();
        times.push(began.elapsed().as_secs_f64() * 1e3);
        let slack = 1e-5 * high;
        wrong += u32::from(!(low - slack..=high + slack).contains(&f64::from(found.distance)));
    }
    tell(&format!("parry, {wrong} of {} wrong, distance", times.len()), &mut times);
}

fn tell(what: &str, times: &mut [f64]) {
    times.sort_by(f64::total_cmp);
    let (median, worst) = (times[times.len() / 2], times[times.len() - 1]);
    println!(
        "{what}: median {median:.3} ms, sum {:.2}, worst {worst:.3}",
        times.iter().sum::<f64>()
    );
}
