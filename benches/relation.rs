//! The relation of two solids and their overlap volume, beside the plain queries that they begin with, and the check of a scene.
//!
//! `cargo bench --bench relation [-- MESH_FILE]`: two of a closed mesh of a file instead of two torus knots. Best times of some rounds
//! in turn, on one thread; the check on all.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use glam::Vec3;
use pfront::{Allowed, Executor, Model, PairQuery, Pose, Relation, SceneQuery, Solid};
use pfront_testkit::MeshData;
use pfront_testkit::rng::seeded;
use pfront_testkit::scenes::torus_knot;
use pfront_testkit::shapes::sphere;
use pfront_testkit::solids::{Blocks, cells_of_box};
use std::sync::Arc;
use std::time::Instant;

/// As few as that in a test, which runs the bench once.
const TRIANGLES: usize = if cfg!(debug_assertions) { 5_000 } else { 800_000 };
const ROUNDS: usize = if cfg!(debug_assertions) { 1 } else { 15 };
/// Parts along each axis of the scene.
const PARTS: u16 = if cfg!(debug_assertions) { 3 } else { 10 };
/// Cells along an edge of a ball, and of two plates that lie flush.
const BALL: i32 = if cfg!(debug_assertions) { 4 } else { 60 };
const CELLS: i32 = if cfg!(debug_assertions) { 5 } else { 19 };

fn main() {
    let file = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let mesh = match file {
        Some(path) => {
            let mesh = pfront_files::read_f32(path.as_ref()).unwrap();
            MeshData { positions: mesh.positions, triangles: mesh.triangles }
        }
        None => torus_knot(TRIANGLES),
    };
    let across = mesh.positions.iter().map(|p| p[0]);
    let width = across.clone().fold(f32::MIN, f32::max) - across.fold(f32::MAX, f32::min);
    let began = Instant::now();
    let large = solid(mesh);
    let ms = began.elapsed().as_secs_f64() * 1e3;
    println!("a solid of {} triangles: {ms:.1} ms", large.model().mesh().triangles().len());
    let pose = Pose::from_rotation_translation(
        [0.0, 0.05, 0.0, (1.0_f32 - 0.0025).sqrt()],
        [0.35 * width, 0.0, 0.0],
    );
    compare("crossing", [&large, &large], pose, Some(Relation::Crossing));

    let plate = |height| {
        let blocks = cells_of_box([CELLS, CELLS, 1]).collect();
        solid(Blocks { size: [1; 3], offset: [0, 0, height], blocks }.mesh(false, &mut seeded(7)))
    };
    let [a, b] = [plate(0), plate(1)];
    compare("flush plates", [&a, &b], Pose::IDENTITY, Some(Relation::Touching));

    let [inner, outer] = [0.5, 1.0].map(|r| solid(ball(r)));
    compare("one inside the other", [&inner, &outer], Pose::IDENTITY, Some(Relation::AInB));
    check();
}

/// The surface of a cube of many cells, blown up to a sphere.
fn ball(radius: f32) -> MeshData {
    let blocks = cells_of_box([BALL; 3]).collect();
    let cube = Blocks { size: [1; 3], offset: [0; 3], blocks }.mesh(false, &mut seeded(8));
    cube.map(|p| {
        let from = Vec3::from_array(p) - 0.5 * BALL as f32;
        (from.normalize() * radius).to_array()
    })
}

fn solid(mesh: MeshData) -> Solid {
    Solid::new(Model::new(mesh.positions, mesh.triangles).unwrap()).unwrap()
}

/// Times the questions of two solids beside each other.
fn compare(what: &str, [a, b]: [&Solid; 2], pose: Pose, expected: Option<Relation>) {
    let (mut query, mut best) = (PairQuery::new(), [f64::INFINITY; 4]);
    let (mut hits, mut volume) = (0, [0.0; 2]);
    let [own, other] = [a, b].map(|solid| &**solid.model());
    for _ in 0..ROUNDS {
        let mut times = [0.0; 4];
        query.forget();
        let took = || {
            let began = Instant::now();
            move || began.elapsed().as_secs_f64() * 1e3
        };
        let time = took();
        query.any(own, other, pose).unwrap();
        times[0] = time();
        query.forget();
        let time = took();
        let found = query.relation(a, b, pose).unwrap();
        times[1] = time();
        assert_eq!(found.relation, expected, "{what}");
        query.forget();
        let time = took();
        hits = query.all(own, other, pose).unwrap().len();
        times[2] = time();
        query.forget();
        let time = took();
        volume = query.overlap_volume(a, b, pose).unwrap();
        times[3] = time();
        for (best, time) in best.iter_mut().zip(times) {
            *best = best.min(time);
        }
    }
    let [any, relation, all, overlap] = best;
    println!(
        "{what}: any {any:.4} ms, relation {relation:.4}, all {all:.3} with {hits} pairs, overlap volume {overlap:.3}, \
         in {volume:?}"
    );
}

/// A lattice of spheres, each a model of its own, that cross their neighbours.
fn check() {
    let threads = std::thread::available_parallelism().unwrap().get();
    let executors = [(1, Executor::sequential()), (threads, Executor::threads(threads))];
    for (threads, executor) in executors {
        let mut scene = SceneQuery::new().on(&executor);
        let axes = || (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| (i, j)));
        for (i, j, k) in axes().flat_map(|(i, j)| (0..PARTS).map(move |k| (i, j, k))) {
            let at = [i, j, k].map(|x| f32::from(x) * 1.98);
            let part = sphere(32).map(|p| [0, 1, 2].map(|k| p[k] + at[k]));
            let model = Model::new(part.positions, part.triangles).unwrap();
            scene.add(Arc::new(model), Pose::IDENTITY).unwrap();
        }
        let mut times = Vec::new();
        let mut crossing = 0;
        for _ in 0..ROUNDS.min(5) {
            let began = Instant::now();
            let report = scene.check(&Allowed::default()).unwrap();
            times.push(began.elapsed().as_secs_f64() * 1e3);
            assert!(report.refused.is_empty());
            let is_crossing =
                |pair: &&pfront::CheckedPair| pair.relation == Some(Relation::Crossing);
            crossing = report.pairs.iter().filter(is_crossing).count();
        }
        times.sort_by(f64::total_cmp);
        println!(
            "{threads} threads, check of {} parts of 2,048 triangles, {crossing} pairs that cross: median {:.0} ms, worst {:.0}",
            usize::from(PARTS).pow(3),
            times[times.len() / 2],
            times[times.len() - 1]
        );
    }
}
