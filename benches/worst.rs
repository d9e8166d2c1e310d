//! The worst frame of what deforms, over the same pose at its best: a sheet that folds, a cloth on a ball, and a scene of bodies
//! that deform, each to and fro, on one thread and on two.
//!
//! `cargo bench --bench worst`. A frame moves the vertices and asks for all pairs. Frames are played several times from the
//! first on, with models and queries made anew, and the shortest time of each frame counts, so that what is left is the
//! frame's own: on one thread processor time, where the system tells it. With recorded data (`PFRONT_DATA`, see test.sh)
//! the cloth is that of two recorded frames and what is between them.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use pfront::{BodyId, Executor, Model, Pose, SceneQuery, SelfQuery};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Scene, icosphere};
use std::path::Path;
use std::time::{Duration, Instant};

/// The frames of a run, the poses between which they go to and fro, and how often the run is repeated.
struct Length {
    frames: usize,
    poses: usize,
    runs: usize,
}

/// Meshes that deform: the positions of each in each pose.
struct Play {
    name: &'static str,
    meshes: Vec<MeshData>,
    poses: Vec<Vec<Vec<[f32; 3]>>>,
}

/// A query, with the model or the bodies that it is about.
enum Asker {
    Within(Box<Model>, Box<SelfQuery>),
    Scene(Box<SceneQuery>, Vec<BodyId>),
}

impl Asker {
    fn new(play: &Play, executor: &Executor) -> Self {
        let model =
            |mesh: &MeshData| Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
        if let [mesh] = &play.meshes[..] {
            return Self::Within(Box::new(model(mesh)), Box::new(SelfQuery::new().on(executor)));
        }
        let mut query = SceneQuery::new().on(executor);
        let place = |i: usize| [i % 5, i / 5 % 5, i / 25].map(|i| 1.9 * i as f32);
        let bodies = play.meshes.iter().enumerate();
        let added = bodies
            .map(|(i, mesh)| query.add(model(mesh), Pose::from_translation(place(i))).unwrap());
        let bodies = added.collect();
        Self::Scene(Box::new(query), bodies)
    }

    /// A frame; returns how many pairs there are.
    fn frame(&mut self, positions: &[Vec<[f32; 3]>]) -> usize {
        match self {
            Self::Within(model, query) => {
                query.set_positions(model, &positions[0]).unwrap();
                query.all(model).unwrap().len()
            }
            Self::Scene(query, bodies) => {
                for (&body, positions) in bodies.iter().zip(positions) {
                    query.set_positions(body, positions).unwrap();
                }
                query.all().unwrap().len()
            }
        }
    }
}

/// Time since some moment: of this thread's processor where `/proc` has it and nobody else works, else of the wall.
fn now(start: Instant, threads: usize) -> Duration {
    let on_processor = || {
        // The kernel counts up to the last switch of threads.
        std::thread::yield_now();
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        Some(Duration::from_nanos(text.split(' ').next()?.parse().ok()?))
    };
    if threads == 1 { on_processor() } else { None }.unwrap_or_else(|| start.elapsed())
}

/// The pose of a frame, to and fro.
fn turn(frame: usize, poses: usize) -> usize {
    let turn = frame % (2 * poses - 2);
    turn.min(2 * poses - 2 - turn)
}

/// Plays all frames; prints the worst one over the best of its pose.
fn play(play: &Play, threads: usize, length: &Length) {
    let mut times = vec![Duration::MAX; length.frames];
    let mut pairs = vec![None; length.poses];
    let start = Instant::now();
    for _ in 0..length.runs {
        let executor =
            if threads == 1 { Executor::sequential() } else { Executor::threads(threads) };
        let mut asker = Asker::new(play, &executor);
        for (frame, time) in times.iter_mut().enumerate() {
            let pose = turn(frame, length.poses);
            let before = now(start, threads);
            let found = asker.frame(&play.poses[pose]);
            *time = (*time).min(now(start, threads) - before);
            assert_eq!(*pairs[pose].get_or_insert(found), found, "the same pose, the same pairs");
        }
    }
    let of_pose = |pose: usize| {
        times.iter().enumerate().filter(move |(frame, _)| turn(*frame, length.poses) == pose)
    };
    let ratios = (0..length.poses).filter_map(|pose| {
        let best = of_pose(pose).map(|(_, time)| *time).min()?;
        let (frame, worst) = of_pose(pose).max_by_key(|(_, time)| **time)?;
        Some((worst.as_secs_f64() / best.as_secs_f64(), frame, *worst, best))
    });
    let Some((ratio, frame, worst, best)) = ratios.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return;
    };
    let mut sorted = times.clone();
    sorted.sort_unstable();
    println!(
        "{:<11} {threads} thread{}: worst {ratio:.2} x its best (frame {frame}: {worst:.2?}, best {best:.2?}); median frame {:.2?}",
        play.name,
        if threads == 1 { " " } else { "s" },
        sorted[sorted.len() / 2],
    );
}

fn sheet(triangles: usize, poses: usize) -> Play {
    let scene = Scene::by_name("sheet", Some(triangles)).unwrap();
    let pose = |pose| {
        let mut positions = Vec::new();
        scene.positions(60 + pose, &mut positions);
        vec![positions]
    };
    Play { name: "sheet", poses: (0..poses).map(pose).collect(), meshes: scene.meshes.clone() }
}

fn cloth_ball(poses: usize) -> Option<Play> {
    let folder = std::env::var_os("PFRONT_DATA")?;
    let read = |frame: u32| {
        let path = format!("cloth/cloth_ball/cloth_ball{frame}.ply");
        let read = pfront_files::read_f32(&Path::new(&folder).join(path)).ok()?;
        Some(MeshData { positions: read.positions, triangles: read.triangles })
    };
    let (first, second) = (read(92)?, read(93)?.positions);
    let pose = |pose: usize| {
        let share = pose as f32 / (poses - 1) as f32;
        let between =
            |(p, q): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|k| p[k] + share * (q[k] - p[k]));
        vec![first.positions.iter().zip(&second).map(between).collect()]
    };
    let poses = (0..poses).map(pose).collect();
    Some(Play { name: "cloth-ball", poses, meshes: vec![first] })
}

/// Balls that are twisted and flattened, each at a moment of its own.
fn bodies(count: usize, triangles: usize, poses: usize) -> Play {
    let meshes = vec![icosphere(triangles); count];
    let body = |i: usize, pose: usize| {
        let time = (pose as f32 / poses as f32 + 0.37 * i as f32).fract();
        let swing = (std::f32::consts::TAU * time).sin();
        let twist = |&[x, y, z]: &[f32; 3]| {
            let (sin, cos) = (2.5 * swing * z).sin_cos();
            [cos * x - sin * y, (1.0 + 0.5 * swing) * (sin * x + cos * y), (1.0 - 0.4 * swing) * z]
        };
        meshes[i].positions.iter().map(twist).collect()
    };
    let pose = |pose| (0..count).map(|i| body(i, pose)).collect();
    Play { name: "bodies", poses: (0..poses).map(pose).collect(), meshes: meshes.clone() }
}

fn main() {
    // As a test, once and small.
    let is_bench = std::env::args().any(|argument| argument == "--bench");
    let length = if is_bench {
        Length { frames: 300, poses: 51, runs: 5 }
    } else {
        Length { frames: 20, poses: 6, runs: 1 }
    };
    let poses = length.poses;
    let plays = if is_bench {
        [Some(sheet(92_000, poses)), cloth_ball(poses), Some(bodies(50, 5_000, poses))]
    } else {
        [Some(sheet(2_000, poses)), None, Some(bodies(50, 320, poses))]
    };
    for threads in [1, 2] {
        plays.iter().flatten().for_each(|one| play(one, threads, &length));
    }
}
