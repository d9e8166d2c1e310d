//! Pairs within a distance, beside those that intersect: two torus knots, by mean edges.
//!
//! `cargo bench --bench within [-- MESH_FILE]`: two of a mesh of a file instead. Best times of some rounds in turn, on one
//! thread and on all, and how many times those at 0 they are.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use glam::Vec3;
use pfront::{Executor, Model, PairQuery, Pose};
use pfront_testkit::scenes::torus_knot;
use std::time::Instant;

/// As few as that in a test, which runs the bench once.
const TRIANGLES: usize = if cfg!(debug_assertions) { 20_000 } else { 800_000 };
const ROUNDS: usize = if cfg!(debug_assertions) { 1 } else { 15 };

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
    let mut executors = vec![(1, Executor::sequential())];
    #[cfg(feature = "threads")]
    executors.push((threads, Executor::threads(threads)));
    for (threads, executor) in executors {
        let queries = DISTANCES.map(|d| PairQuery::new().on(&executor).within(d * edge).unwrap());
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
}
