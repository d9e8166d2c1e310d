//! Queries that a flag ends early, and the pairs of bodies of a scene.

use pfront::{Allowed, Error, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::scenes::icosphere;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Triangles of which almost all meet: some 800,000 pairs.
fn heap() -> Model {
    let mut rng = seeded(7);
    let mut positions = Vec::new();
    for _ in 0..900 {
        // The centre of each is near the origin.
        let [p, q] = [0; 2].map(|_| [0; 3].map(|_| rng.random_range(-9.0..9.0_f32)));
        let r = [0, 1, 2].map(|k| rng.random_range(-0.01..0.01) - p[k] - q[k]);
        positions.extend([p, q, r]);
    }
    let triangles = (0..900).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Model::new(positions, triangles).unwrap()
}

fn executors() -> [Executor; 2] {
    [Executor::sequential(), Executor::threads(2)]
}

/// A GPU, if there is to be one.
fn gpu() -> Option<Executor> {
    #[cfg(feature = "gpu")]
    {
        let gpu = pfront::gpu::Gpu::new().unwrap();
        Some(Executor::gpu(&gpu, gpu.settings()))
    }
    #[cfg(not(feature = "gpu"))]
    None
}

#[test]
fn a_cancelled_query_returns_soon_and_the_next_one_is_complete() {
    let model = Arc::new(heap());
    let count = PairQuery::new().count(&model, &model, Pose::IDENTITY).unwrap();
    assert!(count > 500_000, "{count}");
    for executor in executors().into_iter().chain(gpu()) {
        let flag = Arc::new(AtomicBool::new(false));
        let executor = executor.with_cancel(flag.clone());
        let (mut pairs, mut own) = (PairQuery::new().on(&executor), SelfQuery::new().on(&executor));
        let mut scene = SceneQuery::new().on(&executor);
        let ids = [0, 1].map(|_| scene.add(model.clone(), Pose::IDENTITY).unwrap());
        let late = {
            let flag = flag.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(20));
                flag.store(true, Relaxed);
                Instant::now()
            })
        };
        let mut frames = 0;
        // Each frame is short beside the 20 ms, or is ended by the flag.
        while pairs.count(&model, &model, Pose::from_translation([1e-6 * frames as f32, 0.0, 0.0]))
            != Err(Error::Cancelled)
        {
            frames += 1;
        }
        let delay = late.join().unwrap().elapsed();
        assert!(delay < Duration::from_secs(2), "{delay:?} after {frames} frames");
        assert_eq!(pairs.all(&model, &model, Pose::IDENTITY), Err(Error::Cancelled));
        assert_eq!(own.all(&model), Err(Error::Cancelled));
        let go_on = |_| ControlFlow::Continue(());
        let visited = pairs.visit(&model, &model, Pose::IDENTITY, go_on);
        assert_eq!([visited, own.visit(&model, go_on)], [const { Err(Error::Cancelled) }; 2]);
        let first = scene.segment_first([0.0, 0.0, -9.0], [0.0, 0.0, 9.0]);
        assert_eq!(first.map(|hit| hit.is_some()), Err(Error::Cancelled));
        assert_eq!(scene.all().map(<[_]>::len), Err(Error::Cancelled));
        assert_eq!(scene.intersecting_bodies(), Err(Error::Cancelled));
        flag.store(false, Relaxed);
        assert_eq!(pairs.count(&model, &model, Pose::IDENTITY), Ok(count));
        assert_eq!(own.count(&model), SelfQuery::new().count(&model));
        assert_eq!(scene.count(), Ok(count));
        assert_eq!(scene.intersecting_bodies(), Ok(vec![ids]));
    }
}

#[test]
fn a_check_of_a_scene_hears_the_flag() {
    let ball = icosphere(80);
    let ball = Arc::new(Model::new(ball.positions, ball.triangles).unwrap());
    for executor in executors() {
        let flag = Arc::new(AtomicBool::new(true));
        let mut scene = SceneQuery::new().on(&executor.with_cancel(flag.clone()));
        for x in [0.0, 0.5] {
            scene.add(ball.clone(), Pose::from_translation([x, 0.0, 0.0])).unwrap();
        }
        assert_eq!(scene.check(&Allowed::default()), Err(Error::Cancelled));
        flag.store(false, Relaxed);
        assert_eq!(scene.check(&Allowed::default()).unwrap().pairs.len(), 1);
    }
}

#[test]
fn a_flag_that_is_cleared_early_leaves_no_part_of_an_answer() {
    let model = Arc::new(heap());
    let pose = |frame: u64| Pose::from_translation([1e-6 * (frame % 2) as f32, 0.0, 0.0]);
    let truth = [0, 1].map(|frame| PairQuery::new().count(&model, &model, pose(frame)));
    for executor in executors() {
        let flag = Arc::new(AtomicBool::new(false));
        let executor = executor.with_cancel(flag.clone());
        let (mut pairs, mut scene) =
            (PairQuery::new().on(&executor), SceneQuery::new().on(&executor));
        let [_, moving] = [0, 1].map(|_| scene.add(model.clone(), pose(0)).unwrap());
        let mut cancelled = 0;
        for frame in 1..20_u64 {
            let flag = flag.clone();
            // It is cleared while what was found so far is being sorted.
            let brief = std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(3 * frame));
                flag.store(true, Relaxed);
                std::thread::sleep(Duration::from_micros(200));
                flag.store(false, Relaxed);
            });
            scene.set_pose(moving, pose(frame)).unwrap();
            let answers = [
                pairs.all(&model, &model, pose(frame)).map(<[_]>::len),
                scene.all().map(<[_]>::len),
            ];
            for answer in answers {
                match answer.map(|len| len as u64) {
                    Err(Error::Cancelled) => cancelled += 1,
                    answer => assert_eq!(answer, truth[frame as usize % 2]),
                }
            }
            brief.join().unwrap();
        }
        assert!(cancelled > 0);
    }
}

#[test]
fn intersecting_bodies_are_those_of_the_hits() {
    let ball = icosphere(300);
    let ball = Arc::new(Model::new(ball.positions, ball.triangles).unwrap());
    for executor in executors() {
        let mut rng = seeded(3);
        let mut scene = SceneQuery::new().on(&executor);
        let mut place = || Pose::from_translation([0; 3].map(|_| rng.random_range(-6.0..6.0)));
        let ids: Vec<_> = (0..300).map(|_| scene.add(ball.clone(), place()).unwrap()).collect();
        for frame in 0..4 {
            for id in ids.iter().skip(frame).step_by(frame + 1) {
                scene.set_pose(*id, place()).unwrap();
            }
            scene.ignore(ids[0], ids[frame + 1], true).unwrap();
            let before = scene.intersecting_bodies().unwrap();
            let mut truth: Vec<_> = scene.all().unwrap().iter().map(|hit| hit.bodies).collect();
            truth.dedup();
            assert!(truth.len() > 20, "{}", truth.len());
            assert_eq!(before, truth);
            assert_eq!(scene.intersecting_bodies().unwrap(), truth);
        }
    }
}
