//! A planner changes who answers, never the answer.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::planner::{Backend, Concession, Limits, Machine, Planner, Reason};
use pfront::{Accuracy, BodyId, Model, PairQuery, Pose, SceneHit, SceneQuery, SelfQuery};
use pfront_scenes::{Scene, icosphere};
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

/// A machine on which threads seem to cost nothing, so that they are used.
fn eager() -> Machine {
    let mut machine = Machine::typical();
    (machine.threads, machine.speedup) = (4, 4.0);
    (machine.fork, machine.fork_more) = (1.0, 1.0);
    machine
}

/// Planners that end up in all kinds of places.
fn planners() -> Vec<Planner> {
    let all = [
        Planner::new(Machine::typical()),
        Planner::new(Machine::typical()).with_threads(1),
        Planner::new(eager()),
    ];
    #[cfg(feature = "gpu")]
    let all = all.into_iter().chain([gpu::planner()]);
    all.into_iter().collect()
}

#[cfg(feature = "gpu")]
mod gpu {
    use super::*;
    use pfront::gpu::Gpu;

    /// One that has reason to believe its adapter to be faster than anything.
    pub(crate) fn planner() -> Planner {
        let gpu = Gpu::new().unwrap();
        gpu.warm_up().unwrap();
        let mut machine = eager().measure_gpu(&gpu).unwrap();
        let device = machine.device.as_mut().unwrap();
        (device.question, device.test) = (1.0, 1e-6);
        (device.setup, device.upload) = (0.0, 0.0);
        (machine.fork, machine.fork_more) = (1e9, 1e9);
        Planner::new(machine).with_gpu(&gpu)
    }

    #[test]
    fn it_does_take_the_gpu() {
        let (a, b, poses) = worm();
        let mut query = PairQuery::new().with_planner(planner());
        let taken = poses.iter().any(|pose| {
            query.all(&a, &b, pose).unwrap();
            query.plan().unwrap().backend == Backend::Gpu
        });
        assert!(taken, "{}", query.plan().unwrap());
    }
}

#[cfg(feature = "threads")]
#[test]
fn any_number_of_workers_is_bounded() {
    use pfront::threads::{MAX_WORKERS, Traversal};
    for (workers, threads) in [(0, 1), (3, 3), (usize::MAX, MAX_WORKERS)] {
        let planner = Planner::new(eager()).with_traversal(Traversal::new(workers));
        assert_eq!(planner.machine().threads as usize, threads);
    }
}

fn model(mesh: &pfront_scenes::TriMesh) -> Model {
    Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
}

fn worm() -> (Model, Model, Vec<Pose>) {
    let scene = Scene::by_name("worm-gear", Some(8000)).unwrap();
    let mut rows = Vec::new();
    // Each frame twice, so that some are kept; then far apart, and back.
    let mut poses: Vec<_> = (0..20)
        .map(|frame| {
            scene.poses(frame / 2, &mut rows);
            Pose::new(rows[1])
        })
        .collect();
    poses.push(Pose::from_translation([100.0, 0.0, 0.0]));
    poses.push(poses[3]);
    let [a, b] = [0, 1].map(|object| model(&scene.meshes[scene.objects[object]]));
    (a, b, poses)
}

#[test]
fn pairs_are_the_same() {
    let (a, b, poses) = worm();
    let mut plain = PairQuery::new();
    for planner in planners() {
        let mut planned = PairQuery::new().with_planner(planner);
        for (frame, pose) in poses.iter().enumerate() {
            let truth = plain.all(&a, &b, pose).unwrap();
            match frame % 4 {
                0 => assert_eq!(planned.count(&a, &b, pose).unwrap(), truth.len() as u64),
                1 => {
                    let any = planned.any(&a, &b, pose).unwrap();
                    assert_eq!(any.is_some(), !truth.is_empty());
                    assert!(any.is_none_or(|pair| truth.contains(&pair)));
                }
                _ => {}
            }
            assert_eq!(planned.all(&a, &b, pose).unwrap(), truth, "{frame}");
            let contacts = planned.contacts(&a, &b, pose).unwrap().to_vec();
            assert_eq!(contacts, plain.contacts(&a, &b, pose).unwrap());
        }
    }
}

#[test]
fn what_has_not_changed_is_kept() {
    let (a, b, poses) = worm();
    let mut query = PairQuery::new().with_planner(Planner::new(Machine::typical()));
    let first = query.all(&a, &b, &poses[4]).unwrap().to_vec();
    assert_ne!(query.plan().unwrap().backend, Backend::Kept);
    assert_eq!(query.all(&a, &b, &poses[4]).unwrap(), first);
    assert_eq!(query.plan().unwrap().reason, Reason::Unchanged);
    assert_eq!(query.count(&a, &b, &poses[4]).unwrap(), first.len() as u64);
    // Another model that is the same is no change, one that has moved is.
    let mut moved = b.clone();
    assert_eq!(query.all(&a, &moved, &poses[4]).unwrap(), first);
    assert_eq!(query.plan().unwrap().backend, Backend::Kept);
    let positions: Vec<_> = b.mesh().positions().iter().map(|p| p.map(|x| x + 50.0)).collect();
    moved.set_positions(&positions).unwrap();
    assert!(query.all(&a, &moved, &poses[4]).unwrap().is_empty());
    // What was too small to think about has overwritten the list.
    let small = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    assert_eq!(query.all(&a, &b, &poses[4]).unwrap(), first);
    assert_eq!(query.all(&small, &small, &Pose::IDENTITY).unwrap().len(), 1);
    assert_eq!(query.plan().unwrap().reason, Reason::Small);
    assert_eq!(query.all(&a, &b, &poses[4]).unwrap(), first);
}

#[test]
fn a_deforming_mesh_is_the_same() {
    let scene = Scene::by_name("sheet", Some(3000)).unwrap();
    let start = model(&scene.meshes[0]);
    let mut positions = Vec::new();
    for planner in planners() {
        let (mut own, mut other) = (start.clone(), start.clone());
        let (mut planned, mut plain) = (SelfQuery::new().with_planner(planner), SelfQuery::new());
        for frame in (60..90).chain([5, 110]) {
            scene.positions(frame, &mut positions);
            planned.set_positions(&mut own, &positions).unwrap();
            other.set_positions(&positions).unwrap();
            assert_eq!(planned.all(&own), plain.all(&other), "{frame}");
            assert_eq!(planned.count(&own), plain.count(&other));
        }
    }
}

/// Hits by the places of their bodies.
fn by_place(ids: &[BodyId], hits: &[SceneHit]) -> Vec<([usize; 2], [u32; 2])> {
    let place = |id| ids.binary_search(&id).unwrap();
    hits.iter().map(|hit| (hit.bodies.map(place), [hit.pair.a, hit.pair.b])).collect()
}

#[test]
fn a_scene_is_the_same() {
    let ball = Arc::new(model(&icosphere(1280)));
    let at = |i: usize, frame: usize| {
        let turn = 0.02 * frame as f32 * (i % 3) as f32;
        Pose::from_translation([1.6 * (i % 5) as f32 + turn, 1.7 * (i / 5) as f32, 0.3 * turn])
    };
    let mut backends = HashSet::new();
    for planner in planners() {
        let mut scenes = [SceneQuery::new().with_planner(planner), SceneQuery::new()];
        let mut ids = [Vec::new(), Vec::new()];
        for (scene, ids) in scenes.iter_mut().zip(&mut ids) {
            ids.extend((0..20).map(|i| scene.add(ball.clone(), at(i, 0)).unwrap()));
        }
        for frame in 0..32 {
            for (scene, ids) in scenes.iter_mut().zip(&mut ids) {
                for i in (0..ids.len()).filter(|i| (i + frame) % 4 == 0) {
                    scene.set_pose(ids[i], at(i, frame)).unwrap();
                }
                if frame == 8 {
                    scene.remove(ids.remove(3)).unwrap();
                    ids.push(scene.add(ball.clone(), at(7, 40)).unwrap());
                }
                if frame == 12 {
                    let grown: Vec<_> =
                        ball.mesh().positions().iter().map(|p| p.map(|x| 1.2 * x)).collect();
                    scene.set_positions(ids[6], &grown).unwrap();
                }
            }
            let [planned, plain] = &mut scenes;
            let truth = by_place(&ids[1], plain.all().unwrap());
            if frame % 5 == 0 {
                assert_eq!(planned.count().unwrap(), truth.len() as u64, "{frame}");
                assert_eq!(planned.any().unwrap().is_some(), !truth.is_empty());
            }
            if frame % 7 == 6 {
                // Which needs the broad phase, that some frames may have gone without.
                let mut visited = Vec::new();
                let end = planned.visit(|hit| {
                    visited.push(hit);
                    ControlFlow::Continue(())
                });
                visited.sort_unstable();
                assert_eq!(
                    (by_place(&ids[0], &visited), end.unwrap().is_continue()),
                    (truth.clone(), true)
                );
            }
            assert_eq!(by_place(&ids[0], planned.all().unwrap()), truth, "{frame}");
            backends.insert(planned.plan().unwrap().backend.to_string());
            assert_eq!(by_place(&ids[0], planned.all().unwrap()), truth, "{frame}, kept");
        }
    }
    let ways = [
        "one thread",
        "threads",
        #[cfg(feature = "gpu")]
        "GPU",
    ];
    assert!(ways.iter().all(|way| backends.iter().any(|name| name.contains(way))), "{backends:?}");
}

#[test]
fn only_what_is_allowed_is_given_up() {
    let (a, b, poses) = worm();
    let truth = PairQuery::new().all(&a, &b, &poses[6]).unwrap().to_vec();
    let hurry = Limits { time: Some(Duration::from_nanos(1)), ..Limits::default() };
    for machine in [Machine::typical(), eager()] {
        let planner = Planner::new(machine);
        let ask = |limits: Limits| {
            let mut query = PairQuery::new().with_planner(planner.clone().with_limits(limits));
            // The first frame is not known to be late before it is.
            query.all(&a, &b, &poses[5]).unwrap();
            let found = query.all(&a, &b, &poses[6]).unwrap().to_vec();
            (found, query.plan().unwrap())
        };
        let (found, plan) = ask(hurry);
        assert_eq!((&found, plan.concession), (&truth, None));
        let (found, plan) = ask(Limits { incomplete: true, ..hurry });
        assert_eq!(plan.concession, Some(Concession::Incomplete));
        assert!(found.len() < truth.len() && found.iter().all(|pair| truth.contains(pair)));
        assert!(found.is_sorted());
        let (_, plan) = ask(Limits { accuracy: Accuracy::Fast, ..hurry });
        assert_eq!(plan.concession, Some(Concession::LessAccurate));
        assert!(plan.to_string().contains("less accurately"), "{plan}");
        // In so little memory there are no threads.
        let (found, plan) = ask(Limits { memory: Some(64), ..Limits::default() });
        assert_eq!((found, plan.backend), (truth.clone(), Backend::Sequential));
    }
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let (a, b, poses) = worm();
    let mut machine = Machine::typical();
    (machine.test, machine.speedup, machine.fork) = (f64::NAN, f64::INFINITY, -1.0);
    machine.threads = 0;
    let planner = Planner::new(machine);
    assert_eq!(planner.machine().threads, 1);
    let mut query = PairQuery::new().with_planner(planner);
    for pose in &poses {
        assert_eq!(query.all(&a, &b, pose).unwrap(), PairQuery::new().all(&a, &b, pose).unwrap());
    }
}

#[test]
fn what_is_measured_is_sound() {
    let machine = Machine::measure();
    assert!((0.01..1e4).contains(&machine.test), "{machine}");
    assert!((1.0..=f64::from(machine.threads)).contains(&machine.speedup), "{machine}");
    assert!(machine.threads == 1 || machine.fork > 0.0, "{machine}");
    assert_eq!(Planner::new(machine.clone()).machine(), &machine);
}

#[test]
fn what_is_incomplete_is_not_kept() {
    let (a, b, poses) = worm();
    let mut plain = SceneQuery::new();
    plain.add(a, Pose::IDENTITY).unwrap();
    plain.add(b, poses[6]).unwrap();
    let planner = Planner::new(Machine::typical());
    let time = Some(Duration::from_nanos(1));
    let hurry = planner.clone().with_limits(Limits { time, incomplete: true, ..Limits::default() });
    let mut scene = plain.clone().with_planner(hurry);
    let truth = plain.contacts().unwrap();
    assert!(scene.contacts().unwrap().len() < truth.len());
    assert_eq!(scene.plan().unwrap().concession, Some(Concession::Incomplete));
    let mut scene = scene.with_planner(planner);
    assert_eq!(scene.contacts().unwrap(), truth);
}

#[test]
fn many_small_queries_are_late_and_outgrow_what_was_expected_as_one_large_one_does() {
    let ball = Arc::new(model(&icosphere(80)));
    let mut plain = SceneQuery::new();
    for i in 0..1500 {
        plain.add(ball.clone(), Pose::from_translation([1.9 * i as f32, 0.0, 0.0])).unwrap();
    }
    let planner = Planner::new(Machine::typical()).with_threads(1);
    let time = Some(Duration::from_nanos(1));
    let hurry = planner.with_limits(Limits { time, incomplete: true, ..Limits::default() });
    let mut scene = plain.clone().with_planner(hurry);
    let truth = plain.clone().all().unwrap().to_vec();
    assert!(scene.all().unwrap().len() < truth.len());
    assert_eq!(scene.plan().unwrap().concession, Some(Concession::Incomplete));
    let mut scene = plain.with_planner(Planner::new(eager()));
    assert_eq!(scene.all().unwrap(), truth);
    #[cfg(feature = "threads")]
    assert_eq!(scene.plan().unwrap().reason, Reason::Outgrown, "{}", scene.plan().unwrap());
}
