//! The plan of a query tells who answered the last question, for every verb and executor, however it ended.

use pfront::executor::Backend;
use pfront::{BodyId, Error, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery};
use pfront_testkit::scenes::icosphere;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

const VERBS: [&str; 8] =
    ["all", "update", "any", "count", "contacts", "contacts_f64", "visit", "intersecting_bodies"];

fn ask(scene: &mut SceneQuery, verb: &str) -> Result<(), Error> {
    match verb {
        "all" => scene.all().map(drop),
        "update" => scene.update(),
        "any" => scene.any().map(drop),
        "count" => scene.count().map(drop),
        "contacts" => scene.contacts().map(drop),
        "contacts_f64" => scene.contacts_f64().map(drop),
        "intersecting_bodies" => scene.intersecting_bodies().map(drop),
        _ => scene.visit(|_| ControlFlow::Continue(())).map(drop),
    }
}

/// Bodies side by side, each of which meets its neighbours.
fn scene(executor: &Executor, bodies: usize) -> (SceneQuery, Vec<BodyId>) {
    let ball = icosphere(80);
    let model = Arc::new(Model::new(ball.positions, ball.triangles).unwrap());
    let mut scene = SceneQuery::new().on(executor);
    let mut add = |i| scene.add(model.clone(), Pose::from_translation([1.1 * i as f32, 0.1, 0.0]));
    let ids: Vec<_> = (0..bodies).map(|i| add(i).unwrap()).collect();
    (scene, ids)
}

fn backend(scene: &SceneQuery) -> Backend {
    scene.plan().unwrap().backend
}

/// Moves all bodies, so that nothing that is kept is true.
fn step(scene: &mut SceneQuery, bodies: &[BodyId], frame: usize) {
    for (i, &body) in bodies.iter().enumerate() {
        let at = [1.1 * i as f32, 0.1, 0.01 * frame as f32 + 0.01];
        scene.set_pose(body, Pose::from_translation(at)).unwrap();
    }
}

#[test]
fn on_one_thread() {
    let (mut scene, ids) = scene(&Executor::sequential(), 5);
    assert!(scene.plan().is_none());
    for (frame, verb) in VERBS.into_iter().enumerate() {
        step(&mut scene, &ids, frame);
        ask(&mut scene, verb).unwrap();
        assert_eq!(backend(&scene), Backend::Sequential, "{verb}");
        scene.contacts().unwrap();
        ask(&mut scene, verb).unwrap();
        // Contacts in f64 are not kept.
        let kept = if verb == "contacts_f64" { Backend::Sequential } else { Backend::Cached };
        assert_eq!(backend(&scene), kept, "{verb}");
        ask(&mut scene, "all").unwrap();
        assert_eq!(backend(&scene), Backend::Cached, "after {verb}");
    }
}

#[test]
fn on_threads() {
    let executor = Executor::threads(2);
    for (frame, verb) in VERBS.into_iter().cycle().take(24).enumerate() {
        // Few bodies and many.
        let (mut scene, _) = scene(&executor, if frame < 8 { 3 } else { 700 });
        ask(&mut scene, verb).unwrap();
        let called = !scene.report().unwrap().shares.is_empty();
        let expected = match verb {
            "visit" => false,
            "intersecting_bodies" | "contacts" | "contacts_f64" => frame >= 8,
            _ => called,
        };
        assert_eq!(backend(&scene) == Backend::Threads, expected, "{verb} {frame}");
        scene.all().unwrap();
        ask(&mut scene, verb).unwrap();
        // After `all` segments are found, after a question for them only those in f64.
        let is_kept = !verb.starts_with("contacts");
        assert_eq!(backend(&scene) == Backend::Cached, is_kept || verb == "contacts", "{verb}");
    }
}

#[test]
fn a_question_that_was_cancelled_has_a_plan() {
    let flag = Arc::new(AtomicBool::new(true));
    for executor in [Executor::sequential(), Executor::threads(2)] {
        let executor = executor.with_cancel(flag.clone());
        for verb in VERBS {
            let (mut scene, ids) = scene(&executor, 5);
            assert_eq!(ask(&mut scene, verb), Err(Error::Cancelled), "{verb}");
            assert_eq!(backend(&scene), Backend::Sequential, "{verb}");
            flag.store(false, Relaxed);
            scene.contacts().unwrap();
            flag.store(true, Relaxed);
            step(&mut scene, &ids, 1);
            assert_eq!(ask(&mut scene, verb), Err(Error::Cancelled), "{verb}");
            assert_eq!(backend(&scene), Backend::Sequential, "{verb}");
        }
    }
}

#[test]
fn of_queries_about_one_model_or_two() {
    let ball = icosphere(80);
    let model = Model::new(ball.positions, ball.triangles).unwrap();
    let flag = Arc::new(AtomicBool::new(false));
    for executor in [Executor::sequential(), Executor::threads(2)] {
        let executor = executor.with_cancel(flag.clone());
        let mut query = PairQuery::new().on(&executor);
        query.all(&model, &model, Pose::IDENTITY).unwrap();
        query.all(&model, &model, Pose::IDENTITY).unwrap();
        assert_eq!(query.plan().unwrap().backend, Backend::Cached);
        query.contacts(&model, &model, Pose::IDENTITY).unwrap();
        assert_ne!(query.plan().unwrap().backend, Backend::Cached);
        query.contacts(&model, &model, Pose::IDENTITY).unwrap();
        assert_eq!(query.plan().unwrap().backend, Backend::Cached);
        let _ = query.visit(&model, &model, Pose::IDENTITY, |_| ControlFlow::Break(())).unwrap();
        assert_eq!(query.plan().unwrap().backend, Backend::Sequential);
        // Segments hear the flag, and the next answer is complete.
        flag.store(true, Relaxed);
        let contacts = query.contacts_f64(&model, &model, Pose::IDENTITY);
        assert_eq!(contacts.map(|list| list.len()), Err(Error::Cancelled));
        flag.store(false, Relaxed);
        let hits = query.count(&model, &model, Pose::IDENTITY).unwrap() as usize;
        let contacts = query.contacts_f64(&model, &model, Pose::IDENTITY).unwrap();
        assert!(contacts.len() == hits && hits > 0);

        let mut query = SelfQuery::new().on(&executor);
        query.all(&model).unwrap();
        query.all(&model).unwrap();
        assert_eq!(query.plan().unwrap().backend, Backend::Cached);
        let _ = query.visit(&model, |_| ControlFlow::Break(())).unwrap();
        assert_eq!(query.plan().unwrap().backend, Backend::Sequential);
    }
}

#[cfg(feature = "gpu")]
mod on_gpu {
    use super::*;
    use pfront::Pose64;
    use pfront::executor::Reason;
    use pfront::gpu::Gpu;

    fn executor() -> Executor {
        let gpu = Gpu::new().unwrap();
        Executor::gpu(&gpu, gpu.settings())
    }

    #[test]
    fn alone_and_with_the_cpu_beside() {
        let (mut scene, ids) = scene(&executor(), 5);
        for (frame, verb) in VERBS.into_iter().enumerate() {
            step(&mut scene, &ids, frame);
            ask(&mut scene, verb).unwrap();
            let expected = match verb {
                "contacts" | "contacts_f64" => Backend::GpuAndCpu,
                "visit" | "intersecting_bodies" => Backend::Sequential,
                _ => Backend::Gpu,
            };
            assert_eq!(backend(&scene), expected, "{verb}");
            let is_cpu_only = scene.plan().unwrap().reason == Reason::CpuOnly;
            assert_eq!(is_cpu_only, expected == Backend::Sequential, "{verb}");
        }
        step(&mut scene, &ids, 99);
        scene.all().unwrap();
        scene.contacts().unwrap();
        let plan = scene.plan().unwrap();
        assert_eq!((plan.backend, plan.reason), (Backend::Sequential, Reason::CpuOnly));
        scene.contacts().unwrap();
        assert_eq!(backend(&scene), Backend::Cached);
    }

    /// One body in f64 takes its own pairs to the CPU, and no others.
    #[test]
    fn beside_bodies_in_f64() {
        for executor in [executor(), Executor::threads(2)] {
            let is_gpu = executor_has_gpu(&executor);
            let (mut scene, ids) = scene(&executor, 40);
            let first = ids[0];
            let model = scene.body(first).unwrap().model().clone();
            let (mut truth, _) = super::scene(&Executor::sequential(), 40);
            let add = |scene: &mut SceneQuery, x: f64| {
                let pose = Pose64::from_translation([x + 1e-9, 0.3, 0.2]);
                scene.add(model.clone(), pose).unwrap()
            };
            let far = add(&mut scene, 900.0);
            assert_eq!(add(&mut truth, 900.0), far);
            scene.all().unwrap();
            assert_eq!(backend(&scene) == Backend::Gpu, is_gpu, "no pair is in f64");
            for x in [3.3, 7.1, 900.0, 12.2] {
                let near = Pose64::from_translation([x + 1e-9, 0.3, 0.2]);
                for scene in [&mut scene, &mut truth] {
                    scene.set_pose(far, near).unwrap();
                    let moved = Pose::from_translation([0.001 * x as f32, 0.1, 0.0]);
                    scene.set_pose(first, moved).unwrap();
                }
                let expected = if x < 100.0 { Backend::GpuAndCpu } else { Backend::Gpu };
                assert_eq!(scene.count().unwrap(), truth.count().unwrap());
                assert_eq!(backend(&scene) == expected, is_gpu);
                assert_eq!(scene.any().unwrap().is_some(), truth.any().unwrap().is_some());
                assert_eq!(scene.all().unwrap(), truth.all().unwrap());
                assert_eq!(backend(&scene) == expected, is_gpu);
            }
            // None of the pairs that have changed is in f32.
            let near = Pose64::from_translation([4.0, 0.3, 0.2]);
            scene.set_pose(far, near).unwrap();
            truth.set_pose(far, near).unwrap();
            assert_eq!(scene.all().unwrap(), truth.all().unwrap());
            let plan = scene.plan().unwrap();
            assert!([Backend::Sequential, Backend::Threads].contains(&plan.backend));
            assert_eq!(plan.reason == Reason::CpuOnly, is_gpu);
        }
    }

    /// Two models within a distance are asked about on the GPU; one and itself, and bodies of a scene, on the CPU.
    #[test]
    fn within_a_distance() {
        let (mut scene, ids) = scene(&executor(), 5);
        let model = scene.body(ids[0]).unwrap().model().clone();
        let aside = Pose::from_translation([2.01, 0.0, 0.0]);
        let mut query = PairQuery::new().on(&executor()).within(0.3).unwrap();
        assert!(!query.all(&model, &model, aside).unwrap().is_empty());
        assert_eq!(query.plan().unwrap().backend, Backend::Gpu);
        let far = Pose64::from_translation([2.01, 0.0, 1e-12]);
        assert!(query.count(&model, &model, far).unwrap() > 0);
        assert_eq!(query.plan().unwrap().backend, Backend::Gpu);
        // Above a quarter of the range, no box grows so much on a GPU.
        let largest = f32::MAX / 4.0;
        let all = model.mesh().triangles().len().pow(2) as u64;
        for (distance, is_gpu) in [(largest, true), (largest.next_up(), false), (1e38, false)] {
            let mut query = PairQuery::new().on(&executor()).within(distance).unwrap();
            assert_eq!(query.count(&model, &model, aside).unwrap(), all);
            let plan = query.plan().unwrap();
            assert_eq!(plan.backend == Backend::Gpu, is_gpu, "{distance}");
            assert_eq!(plan.reason == Reason::CpuOnly, !is_gpu, "{distance}");
        }
        let mut query = SelfQuery::new().on(&executor()).within(0.1).unwrap();
        query.all(&model).unwrap();
        assert_eq!(query.plan().unwrap().reason, Reason::CpuOnly);
        scene.within(0.1).unwrap();
        scene.all().unwrap();
        assert_eq!(scene.plan().unwrap().reason, Reason::CpuOnly);
    }

    fn executor_has_gpu(executor: &Executor) -> bool {
        format!("{executor:?}").contains("has_gpu: true")
    }
}
