//! Threads change no answer: the same queries with and without.

use pfront::threads::{Pool, Report, Schedule, Settings, Traversal};
use pfront::{BuildOptions, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery, TrianglePair};
use pfront_core::bvtt;
use pfront_core::bvtt::{PosedBvh, Query};
use pfront_testkit::scenes::{Scene, icosphere};
use std::ops::ControlFlow;
use std::sync::Arc;

fn pools() -> impl Iterator<Item = Pool> {
    let schedules = [Schedule::Static, Schedule::Hybrid];
    [1, 3, 64].into_iter().flat_map(move |workers| {
        schedules.map(|schedule| {
            let settings = Settings { schedule, ..Settings::default() };
            Pool::new(workers).with_settings(settings)
        })
    })
}

#[test]
fn two_models() {
    let scene = Scene::by_name("worm-gear", Some(8_000)).unwrap();
    let models: Vec<_> = scene
        .meshes
        .iter()
        .map(|m| Model::new(m.positions.clone(), m.triangles.clone()).unwrap())
        .collect();
    let [a, b] = [0, 1].map(|i| &models[scene.objects[i]]);
    let mut one = PairQuery::new();
    for pool in pools() {
        let mut many = PairQuery::new().on(&pool.into());
        let mut poses = Vec::new();
        for frame in 0..4 {
            scene.poses(frame, &mut poses);
            let pose = Pose::new(poses[1]);
            // In this order none is answered by what is kept of the one before.
            let (found, any) = (many.any(a, b, pose).unwrap(), one.any(a, b, pose).unwrap());
            assert_eq!(found.is_some(), any.is_some());
            assert_eq!(many.count(a, b, pose).unwrap(), one.count(a, b, pose).unwrap());
            assert_eq!(many.all(a, b, pose).unwrap(), one.all(a, b, pose).unwrap());
            assert_eq!(many.contacts(a, b, pose).unwrap(), one.contacts(a, b, pose).unwrap());
        }
        assert!(many.report().is_some() && one.report().is_none());
    }
}

/// Nested spheres of which one vertex of the inner sticks out: the first pair comes anywhere in the traversal.
#[test]
fn a_search_takes_the_calling_thread_no_longer_than_alone() {
    let outer = icosphere(5_000);
    let inner = outer.clone().map(|p| p.map(|x| 0.999 * x));
    let a = Model::new(outer.positions, outer.triangles).unwrap();
    let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
    let mut late = 0;
    for vertex in (0..inner.positions.len()).step_by(inner.positions.len() / 12) {
        let mut positions = inner.positions.clone();
        positions[vertex] = positions[vertex].map(|x| 1.01 * x);
        let b = Model::new(positions, inner.triangles.clone()).unwrap();
        let tree = bvtt::PairBvtt::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
        let mut cursor = tree.start();
        assert!(tree.visit(&mut cursor, |_| ControlFlow::Break(())).is_break());
        let alone = cursor.work.tests();
        late += u32::from(alone > 20_000);
        // A thread that has come to its end gives its place in the report to another, which counts there too: the fewest
        // tests of some searches are those of the calling thread.
        let tests = (0..5).map(|_| {
            let mut many = PairQuery::new().on(&Pool::new(2).with_settings(settings).into());
            assert!(many.any(&a, &b, Pose::IDENTITY).unwrap().is_some());
            let report = many.report().unwrap();
            let own = report.shares.first().map(|share| share.work).unwrap_or_default();
            let works = [report.alone, own];
            works.iter().map(|work| work.tests()).sum::<u64>()
        });
        let fewest = tests.min().unwrap();
        // Threads look at each other every 512 tests, which end at a whole node pair.
        assert!(fewest <= alone + 600, "{vertex}: {fewest} tests, {alone} alone");
    }
    assert!(late > 3, "{late}");
}

/// No clock decides what a query does under the static schedule: its counts are those of the traversal by itself.
#[test]
fn counts_under_the_static_schedule_depend_on_no_machine() {
    let scene = Scene::by_name("worm-gear", Some(8_000)).unwrap();
    let model = |i: usize| {
        let mesh = &scene.meshes[scene.objects[i]];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
    };
    let [a, b] = [0, 1].map(model);
    for workers in [2, 64, 1024] {
        let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
        let pool = Pool::new(workers).with_settings(settings);
        let mut alone = Traversal::new(&pool);
        let mut query = PairQuery::new().on(&pool.into());
        let (mut poses, mut pairs) = (Vec::new(), Vec::<TrianglePair>::new());
        for frame in 0..4 {
            scene.poses(frame, &mut poses);
            let pose = Pose::new(poses[1]);
            query.all(&a, &b, pose).unwrap();
            alone.all(&[bvtt::PairBvtt::new(a.bvh(), b.bvh(), pose).unwrap()], &mut pairs).unwrap();
            let counts = |report: &Report| {
                let shares: Vec<_> = report.shares.iter().map(|share| share.work).collect();
                (report.nodes, report.alone, shares)
            };
            assert!(alone.report.nodes > 0);
            assert_eq!(counts(query.report().unwrap()), counts(&alone.report));
        }
    }
}

#[test]
fn one_model() {
    let scene = Scene::by_name("sheet", Some(4_000)).unwrap();
    let mesh = &scene.meshes[0];
    let mut model = Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
    let (mut one, mut positions) = (SelfQuery::new(), Vec::new());
    for pool in pools() {
        let mut many = SelfQuery::new().on(&pool.into());
        for frame in 50..53 {
            scene.positions(frame, &mut positions);
            model.set_positions(&positions).unwrap();
            let (found, any) = (many.any(&model).unwrap(), one.any(&model).unwrap());
            assert_eq!(found.is_some(), any.is_some());
            assert_eq!(many.count(&model).unwrap(), one.count(&model).unwrap());
            assert_eq!(many.all(&model).unwrap(), one.all(&model).unwrap());
            assert_eq!(many.contacts(&model).unwrap(), one.contacts(&model).unwrap());
        }
    }
}

/// Fronts and partitions of two meshes that are both posed, as on one thread.
#[test]
fn models_in_a_world() {
    let scene = Scene::by_name("worm-gear", Some(8_000)).unwrap();
    let [a, b] = [0, 1].map(|i: usize| {
        let mesh = &scene.meshes[scene.objects[i]];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
    });
    let (mut poses, mut found) = (Vec::new(), Vec::<TrianglePair>::new());
    let aside = Pose::new([[0.6, -0.8, 0.0, 0.3], [0.8, 0.6, 0.0, -2.0], [0.0, 0.0, 1.0, 0.1]]);
    for pool in pools() {
        let mut traversal = Traversal::new(&pool);
        for frame in 0..3 {
            scene.poses(frame, &mut poses);
            let here = PosedBvh::new(a.bvh(), &aside).unwrap();
            let there = PosedBvh::new(b.bvh(), &Pose::new(poses[1])).unwrap();
            let query = bvtt::PairBvtt::in_world(here, there);
            traversal.all(&[query], &mut found).unwrap();
            let mut truth = Vec::new();
            let _ = query.visit(&mut query.start(), |pair| {
                truth.push(pair);
                ControlFlow::Continue(())
            });
            truth.sort_unstable();
            assert!(found == truth && !truth.is_empty());
        }
    }
}

#[test]
fn many_models() {
    let swarm = Scene::by_name("swarm", Some(40_000)).unwrap();
    let models = swarm.meshes.iter().map(|m| (m.positions.clone(), m.triangles.clone()));
    let models: Vec<_> = models.map(|(p, t)| Arc::new(Model::new(p, t).unwrap())).collect();
    let (mut one, mut poses) = (SceneQuery::new(), Vec::new());
    let add = |scene: &mut SceneQuery| {
        let objects = swarm.objects.iter();
        objects.map(|&m| scene.add(models[m].clone(), Pose::IDENTITY).unwrap()).collect::<Vec<_>>()
    };
    let ids = add(&mut one);
    for pool in pools() {
        let mut many = SceneQuery::new().on(&pool.into());
        assert_eq!(add(&mut many), ids);
        for frame in [3, 4] {
            swarm.poses(frame, &mut poses);
            for (&id, &rows) in ids.iter().zip(&poses) {
                one.set_pose(id, Pose::new(rows)).unwrap();
                many.set_pose(id, Pose::new(rows)).unwrap();
            }
            assert_eq!(many.any().unwrap().is_some(), one.any().unwrap().is_some());
            assert_eq!(many.count().unwrap(), one.count().unwrap());
            assert!(many.all().unwrap() == one.all().unwrap() && !one.all().unwrap().is_empty());
            assert!(many.contacts().unwrap() == one.contacts().unwrap());
        }
        assert!(many.report().is_some() && one.report().is_none());
    }
}

#[test]
fn a_model_and_its_rebuild() {
    // Triangles that share nothing, and then change places, so that a refit does not do.
    let scene = Scene::by_name("sheet", Some(40_000)).unwrap();
    let mesh = &scene.meshes[0];
    let count = mesh.triangles.len();
    let corners = |i: usize| mesh.triangles[i].map(|corner| mesh.positions[corner as usize]);
    let positions: Vec<_> = (0..count).flat_map(corners).collect();
    let moved: Vec<_> = (0..count).flat_map(|i| corners(i * 7919 % count)).collect();
    let triangles: Vec<_> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let options = BuildOptions { leaf_size: 3, ..BuildOptions::default() };
    let (alone, threads) = (Executor::sequential(), Executor::threads(4));
    let mut one = alone.build(positions.clone(), triangles.clone(), options).unwrap();
    let mut many = threads.build(positions, triangles, options).unwrap();
    let same = |one: &Model, many: &Model| {
        let (one, many) = (one.bvh(), many.bvh());
        one.nodes() == many.nodes() && one.order() == many.order()
    };
    assert!(same(&one, &many));
    let before = one.bvh().order().to_vec();
    one.set_positions(&moved).unwrap();
    threads.refit(&mut many, &moved).unwrap();
    assert!(same(&one, &many) && one.bvh().order() != before);
}
