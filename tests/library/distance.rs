//! The smallest distance: by every query and executor, as core finds it, which is tested against every two triangles.

use crate::each_executor;
use pfront::executor::{Backend, Reason};
use pfront::pfront_core::bvtt::{PairBvtt, PosedBvh};
use pfront::{
    Adjacency, Batch, BodyOptions, Distance, Error, Executor, Gap, Groups, Model, PairQuery, Pose,
    Pose64, SceneQuery,
};
use pfront_testkit::MeshData;
use pfront_testkit::rng::seeded;
use pfront_testkit::scenes::torus_knot;
use pfront_testkit::shapes::{bumpy, pose_rows, sphere, tangle};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn model(mesh: MeshData) -> Arc<Model> {
    Arc::new(Model::new(mesh.positions, mesh.triangles).unwrap())
}

/// The answer about two in the world, alone.
fn of_two(a: (&Model, Pose), b: (&Model, Pose)) -> Option<Gap> {
    let [a, b] = [a, b].map(|(model, pose)| PosedBvh::new(model.bvh(), &pose).unwrap());
    PairBvtt::in_world(a, b).distance(None, None)
}

#[test]
fn pairs_and_batches_on_every_executor() {
    let (a, b) = (model(sphere(20)), model(torus_knot(20_000)));
    let mut rng = seeded(71);
    let poses: Vec<_> = (0..30).map(|_| Pose::new(pose_rows(5.0, &mut rng))).collect();
    let truth = |pose: &Pose| of_two((&a, Pose::IDENTITY), (&b, *pose)).unwrap();
    let truths: Vec<_> = poses.iter().map(truth).collect();
    let apart = truths.iter().filter(|gap| gap.interval[0] > 0.0).count();
    assert!((5..30).contains(&apart), "{apart}");
    // If some intersect, each executor may tell another pair.
    let same = |found: Option<Gap>, truth: &Gap| {
        let found = found.unwrap();
        assert_eq!(found.interval, truth.interval);
        assert!(found == *truth || truth.interval[1] == 0.0, "{found:?} {truth:?}");
    };
    for executor in each_executor(&[1, 3, 16]) {
        let (mut query, mut batch) = (PairQuery::new().on(&executor), Batch::new());
        for (pose, truth) in poses.iter().zip(&truths) {
            same(query.distance(&a, &b, *pose).unwrap(), truth);
            let plan = query.plan().unwrap();
            assert!(matches!(plan.backend, Backend::Sequential | Backend::Threads), "{plan:?}");
            let limit = Distance::at_least(truth.interval[1]).unwrap().get();
            same(query.distance_below(&a, &b, *pose, limit).unwrap(), truth);
            let below = truth.interval[0] as f32;
            let is_none = query.distance_below(&a, &b, *pose, below).unwrap().is_none();
            assert_eq!(is_none, truth.interval[0] > 0.0, "{truth:?}");
            batch.pair(&a, &b, *pose).unwrap();
        }
        let gaps = batch.distance(&executor).unwrap().read().unwrap();
        assert_eq!(gaps.len(), poses.len());
        gaps.into_iter().zip(&truths).for_each(|(gap, truth)| same(gap, truth));
        // So few that the threads divide each.
        batch.clear();
        batch.pair(&a, &b, poses[0]).unwrap();
        let gaps = batch.distance(&executor).unwrap().read().unwrap();
        same(gaps[0], &truths[0]);
        let near = batch.distance_below(&executor, 0.0).unwrap().read().unwrap();
        assert_eq!(near[0].is_none(), truths[0].interval[0] > 0.0);
    }
}

#[test]
fn scenes_on_every_executor() {
    let mut rng = seeded(72);
    let shapes = [model(sphere(4)), model(bumpy(4)), model(tangle(20, 20, 1, &mut rng))];
    let empty = Arc::new(Model::new(vec![[9.0; 3]], vec![]).unwrap());
    for executor in each_executor(&[1, 3, 16]) {
        let mut scene = SceneQuery::new().on(&executor);
        let lonely =
            BodyOptions { groups: Groups { memberships: 0, filter: 0 }, ..BodyOptions::default() };
        let alone = scene.add_with(shapes[0].clone(), Pose::IDENTITY, lonely).unwrap();
        let none = scene.add(empty.clone(), Pose::IDENTITY).unwrap();
        let mut place = || Pose::new(pose_rows(9.0, &mut rng));
        let mut bodies = Vec::new();
        for k in 0..8 {
            let (shape, pose) = (&shapes[k % 3], place());
            bodies.push((scene.add(shape.clone(), pose).unwrap(), shape, pose));
        }
        scene.ignore(bodies[0].0, bodies[1].0, true).unwrap();
        for frame in 0..4 {
            for (i, a) in bodies.iter().enumerate() {
                let mut truth: Option<(pfront::BodyId, Gap)> = None;
                for (j, b) in bodies.iter().enumerate() {
                    if i == j || i + j == 1 {
                        continue;
                    }
                    let gap = of_two((a.1, a.2), (b.1, b.2)).unwrap();
                    if truth.is_none_or(|(_, best)| gap.interval[1] < best.interval[1]) {
                        truth = Some((b.0, gap));
                    }
                }
                let (id, truth) = truth.unwrap();
                let (found, gap) = scene.distance(a.0).unwrap().unwrap();
                assert_eq!((found, gap.interval), (id, truth.interval), "{executor:?} {frame}");
                assert!(gap == truth || truth.interval[1] == 0.0);
                let limit = Distance::at_least(truth.interval[1]).unwrap().get();
                assert_eq!(scene.distance_below(a.0, limit).unwrap().unwrap().0, id);
                let below = truth.interval[0] as f32;
                let is_none = scene.distance_below(a.0, below).unwrap().is_none();
                assert_eq!(is_none, truth.interval[0] > 0.0, "{truth:?}");
            }
            for body in [alone, none] {
                assert_eq!(scene.distance(body).unwrap(), None);
            }
            for (body, _, pose) in bodies.iter_mut().take(3 + frame) {
                *pose = place();
                scene.set_pose(*body, *pose).unwrap();
            }
        }
        let (first, ..) = bodies.remove(0);
        scene.remove(first).unwrap();
        assert!(matches!(scene.distance(first), Err(Error::StaleBody { .. })));
        assert!(scene.distance(bodies[0].0).unwrap().is_some());
    }
}

#[test]
fn in_f64_a_nanometre_is_told() {
    let positions = vec![[1e6, 0.0, 0.0], [1e6 + 1.0, 0.0, 0.0], [1e6, 1.0, 0.0]];
    let model = Model::from_f64(positions, vec![[0, 1, 2]]).unwrap();
    let above = Pose64::from_translation([0.0, 0.0, 1e-9]);
    for executor in each_executor(&[1, 3, 16]) {
        let gap = PairQuery::new().on(&executor).distance(&model, &model, above).unwrap().unwrap();
        let [low, high] = gap.interval;
        assert!(low <= 1e-9 && 1e-9 <= high && high - low < 1e-12, "{gap:?}");
    }
}

#[test]
fn what_is_no_question_is_refused() {
    let one = model(sphere(3));
    let pose = Pose::from_translation([3.0, 0.0, 0.0]);
    for limit in [-0.5, f32::NAN, f32::INFINITY] {
        let mut query = PairQuery::new();
        assert!(matches!(query.distance_below(&one, &one, pose, limit), Err(Error::Distance(_))));
    }
    let nowhere = Pose::from_translation([f32::NAN, 0.0, 0.0]);
    assert!(matches!(pfront::distance(&one, &one, nowhere), Err(Error::Pose(_))));
    let mut batch = Batch::new();
    batch.pair(&one, &one, pose).unwrap();
    batch.itself(&one, Adjacency::default());
    let refused = batch.distance(&Executor::sequential()).map(|_| ());
    assert_eq!(refused, Err(Error::NotAPair { question: 1 }));
    for executor in each_executor(&[1, 3, 16]) {
        let cancelled = executor.with_cancel(Arc::new(AtomicBool::new(true)));
        let mut query = PairQuery::new().on(&cancelled);
        assert_eq!(query.distance(&one, &one, pose), Err(Error::Cancelled));
        let reason = query.plan().unwrap().reason;
        assert!(matches!(reason, Reason::NoChoice | Reason::CpuOnly));
    }
}

/// A large body beside small ones has an error of its own; what is told does not depend on what was asked before.
#[test]
fn a_scene_tells_the_same_whatever_it_remembers() {
    let triangle = |size: f32, z: f32| {
        let positions = vec![[0.0, 0.0, z], [size, 0.0, z], [0.0, size, z]];
        Arc::new(Model::new(positions, vec![[0, 1, 2]]).unwrap())
    };
    let mut scene = SceneQuery::new();
    let at = |z| Pose::from_translation([0.0, 0.0, z]);
    let own = scene.add(triangle(1.0, 0.0), Pose::IDENTITY).unwrap();
    let small = scene.add(triangle(1.0, 0.0), at(5.0)).unwrap();
    scene.add(triangle(1e8, -1.000_000_5), Pose::IDENTITY).unwrap();
    scene.distance(own).unwrap();
    scene.set_pose(small, at(1.0)).unwrap();
    let first = scene.distance(own).unwrap();
    assert_eq!(first.unwrap().0, small);
    assert_eq!(scene.distance(own).unwrap(), first);
    let mut fresh = SceneQuery::new();
    let own = fresh.add(triangle(1.0, 0.0), Pose::IDENTITY).unwrap();
    fresh.add(triangle(1.0, 0.0), at(1.0)).unwrap();
    fresh.add(triangle(1e8, -1.000_000_5), Pose::IDENTITY).unwrap();
    assert_eq!(fresh.distance(own).unwrap(), first);
}
