//! Questions that the cache answers, and questions that it does not.

#[cfg(feature = "gpu")]
use super::model;
use super::verbs::{Between, Within, check};
use super::{EXECUTORS, Heap, folds, forgetful, worm};
use pfront::executor::{Backend, Reason};
use pfront::{Adjacency, Body, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery};
#[cfg(feature = "gpu")]
use pfront_testkit::scenes::icosphere;

/// Asserts who answered a query last: what is kept, or somebody.
macro_rules! assert_kept {
    ($query:expr, $name:expr) => {{
        let plan = $query.plan().unwrap();
        assert_eq!((plan.backend, plan.reason), (Backend::Cached, Reason::Unchanged), "{}", $name);
    }};
}

macro_rules! assert_asked {
    ($query:expr, $name:expr) => {{
        let plan = $query.plan().unwrap();
        assert_ne!(plan.backend, Backend::Cached, "{}", $name);
        assert_ne!(plan.reason, Reason::Unchanged, "{}", $name);
    }};
}

#[test]
fn answers_about_two_models() {
    let (a, b, poses) = worm();
    for (name, executor) in EXECUTORS.iter() {
        let mut query = PairQuery::new().on(executor);
        let first = query.all(&a, &b, poses[4]).unwrap().to_vec();
        assert_asked!(query, name);
        assert_eq!(query.all(&a, &b, poses[4]).unwrap(), first);
        assert_kept!(query, name);
        assert_eq!(query.count(&a, &b, poses[4]).unwrap(), first.len() as u64);
        assert_kept!(query, name);
        assert_eq!(query.any(&a, &b, poses[4]).unwrap(), first.first().copied());
        assert_kept!(query, name);
        // Pairs are kept, and where they intersect is found.
        assert_eq!(query.contacts(&a, &b, poses[4]).unwrap().len(), first.len());
        assert_asked!(query, name);
        assert_eq!(query.contacts(&a, &b, poses[4]).unwrap().len(), first.len());
        assert_kept!(query, name);
        // A model that is the same is no other, nor is one whose vertices are moved to where they are.
        let mut moved = b.clone();
        moved.set_positions(b.mesh().positions().unwrap()).unwrap();
        assert_eq!(query.all(&a, &moved, poses[4]).unwrap(), first);
        assert_kept!(query, name);

        let shifted: Vec<_> =
            b.mesh().positions().unwrap().iter().map(|p| p.map(|x| x + 50.0)).collect();
        moved.set_positions(&shifted).unwrap();
        assert!(query.all(&a, &moved, poses[4]).unwrap().is_empty());
        assert_asked!(query, name);
        assert_eq!(query.all(&a, &b, poses[4]).unwrap(), first);
        assert_asked!(query, name);
        // A model that holds the same and was built by itself is another.
        let (positions, triangles) =
            (b.mesh().positions().unwrap().to_vec(), b.mesh().triangles().to_vec());
        let twin = Model::new(positions, triangles).unwrap();
        assert_eq!(query.all(&a, &twin, poses[4]).unwrap(), first);
        assert_asked!(query, name);
        query.all(&a, &twin, poses[5]).unwrap();
        assert_asked!(query, name);
        // In the other order.
        query.all(&twin, &a, poses[5]).unwrap();
        assert_asked!(query, name);
        query.all(&twin, &a, poses[5]).unwrap();
        assert_kept!(query, name);
        query.forget();
        query.all(&twin, &a, poses[5]).unwrap();
        assert_asked!(query, name);
        // Another executor remembers nothing of pairs.
        let mut query = query.on(executor);
        assert!(query.plan().is_none());
        query.all(&twin, &a, poses[5]).unwrap();
        assert_asked!(query, name);
    }
}

/// From a list follows everything, from a count or a pair only that.
#[test]
fn answers_to_other_verbs() {
    let (a, b, poses) = worm();
    for (name, executor) in EXECUTORS.iter() {
        let mut query = PairQuery::new().on(executor);
        let any = query.any(&a, &b, poses[4]).unwrap();
        assert_eq!(query.any(&a, &b, poses[4]).unwrap(), any);
        assert_kept!(query, name);
        let count = query.count(&a, &b, poses[4]).unwrap();
        assert_asked!(query, name);
        assert_eq!(query.count(&a, &b, poses[4]).unwrap(), count);
        assert_kept!(query, name);
        assert_eq!(query.contacts(&a, &b, poses[4]).unwrap().len() as u64, count);
        assert_asked!(query, name);
        assert_eq!(query.all(&a, &b, poses[4]).unwrap().len() as u64, count);
        assert_kept!(query, name);
    }
}

#[test]
fn answers_about_one_model() {
    let (mut sheet, shapes) = folds();
    for (name, executor) in EXECUTORS.iter() {
        sheet.set_positions(&shapes[2]).unwrap();
        let mut query = SelfQuery::new().on(executor);
        let first = query.all(&sheet).unwrap().to_vec();
        assert_asked!(query, name);
        assert_eq!(query.contacts(&sheet).unwrap().len(), first.len());
        assert_asked!(query, name);
        assert_eq!(query.contacts(&sheet).unwrap().len(), first.len());
        assert_kept!(query, name);
        query.set_positions(&mut sheet, &shapes[2]).unwrap();
        assert_eq!(query.count(&sheet).unwrap(), first.len() as u64);
        assert_kept!(query, name);
        query.set_positions(&mut sheet, &shapes[3]).unwrap();
        let second = query.all(&sheet).unwrap().to_vec();
        assert_asked!(query, name);
        let mut query = query.with_adjacency(Adjacency::SkipNeighbours);
        let apart = query.all(&sheet).unwrap().to_vec();
        assert_asked!(query, name);
        assert!(apart.iter().all(|pair| second.contains(pair)), "{name}");
        query.all(&sheet).unwrap();
        assert_kept!(query, name);
        query.forget();
        query.all(&sheet).unwrap();
        assert_asked!(query, name);
        // There and back is another stamp.
        sheet.set_positions(&shapes[2]).unwrap();
        let mut query = query.with_adjacency(Adjacency::SharedIndexRule);
        assert_eq!(query.all(&sheet).unwrap(), first);
        assert_asked!(query, name);
    }
}

#[test]
fn answers_about_a_scene() {
    let heap = Heap::new();
    for (name, executor) in EXECUTORS.iter() {
        let mut scene = SceneQuery::new().on(executor);
        assert!(scene.plan().is_none());
        heap.fill(&mut scene);
        let ids: Vec<_> = scene.bodies().map(Body::id).collect();
        let count = scene.count().unwrap();
        assert_asked!(scene, name);
        let first = scene.all().unwrap().to_vec();
        assert_asked!(scene, name);
        for round in 0..2 {
            assert_eq!(scene.all().unwrap(), first);
            assert_kept!(scene, name);
            assert_eq!(scene.count().unwrap(), count);
            assert_kept!(scene, name);
            assert_eq!(scene.any().unwrap(), first.first().copied());
            assert_kept!(scene, name);
            assert_eq!(scene.contacts().unwrap().len(), first.len());
            if round == 0 {
                assert_asked!(scene, name);
            } else {
                assert_kept!(scene, name);
            }
            // The pose that it has.
            scene.set_pose(ids[3], scene.body(ids[3]).unwrap().pose()).unwrap();
        }
        // Other executors take over what is known.
        scene = scene.on(&Executor::sequential()).on(executor);
        assert_eq!(scene.all().unwrap(), first);
        assert_kept!(scene, name);

        let asked = |scene: &mut SceneQuery| {
            let truth = forgetful(scene).all().unwrap().to_vec();
            assert_eq!(scene.all().unwrap(), truth, "{name}");
            assert_asked!(scene, name);
        };
        scene.set_pose(ids[3], Pose::from_translation([0.3; 3])).unwrap();
        asked(&mut scene);
        let small: Vec<_> = heap.ball.positions.iter().map(|p| p.map(|x| 0.9 * x)).collect();
        scene.set_positions(ids[3], &small).unwrap();
        asked(&mut scene);
        scene.remove(ids[0]).unwrap();
        asked(&mut scene);
        scene.add(heap.shared.clone(), Pose::from_translation([0.5; 3])).unwrap();
        asked(&mut scene);
        scene.split(ids[3], |triangle| triangle % 2).unwrap();
        asked(&mut scene);
    }
}

#[test]
fn clones_go_their_own_way() {
    let (a, b, poses) = worm();
    let (start, shapes) = folds();
    let heap = Heap::new();
    for (name, executor) in EXECUTORS.iter() {
        let mut query = PairQuery::new().on(executor);
        let first = query.all(&a, &b, poses[0]).unwrap().to_vec();
        query.contacts(&a, &b, poses[0]).unwrap();
        let mut copy = query.clone();
        query.all(&a, &b, poses[5]).unwrap();
        assert_eq!(copy.all(&a, &b, poses[0]).unwrap(), first);
        assert_kept!(copy, name);
        for (is_copy, frame) in [(true, 2), (false, 2), (true, 3)] {
            let query = if is_copy { &mut copy } else { &mut query };
            let mut truth = PairQuery::new();
            let mut truth = Between(&mut truth, [&a, &b], poses[frame]);
            check(&mut Between(query, [&a, &b], poses[frame]), &mut truth, frame, name);
        }

        let mut sheets = [start.clone(), start.clone()];
        let mut query = SelfQuery::new().on(executor);
        query.set_positions(&mut sheets[0], &shapes[1]).unwrap();
        query.count(&sheets[0]).unwrap();
        let mut copy = query.clone();
        for (i, shape) in [(0, 2), (1, 3), (0, 3), (0, 4), (1, 2)] {
            let query = if i == 0 { &mut query } else { &mut copy };
            query.set_positions(&mut sheets[i], &shapes[shape]).unwrap();
            let mut truth = SelfQuery::new();
            let mut truth = Within(&mut truth, &sheets[i]);
            check(&mut Within(query, &sheets[i]), &mut truth, shape, name);
        }

        let mut scenes = [SceneQuery::new().on(executor), SceneQuery::new()];
        heap.fill(&mut scenes[0]);
        scenes[0].count().unwrap();
        scenes[1] = scenes[0].clone();
        for (i, frame) in [(0, 2), (1, 3), (0, 4), (1, 4), (0, 8), (1, 11)] {
            heap.happen(&mut scenes[i], frame);
            let mut truth = forgetful(&scenes[i]);
            check(&mut scenes[i], &mut truth, frame, name);
        }
    }
}

/// The memory of the lists, which is most of what a small question takes on a GPU, is taken once.
#[cfg(feature = "gpu")]
#[test]
fn lists_of_a_gpu() {
    use pfront::gpu::{Budget, Gpu, GpuSettings};
    let gpu = Gpu::new().unwrap();
    let settings = GpuSettings { budget: Budget { bytes: 32 << 20 }, ..gpu.settings() };
    let executor = Executor::gpu(&gpu, settings);
    let taken =
        || gpu.device().generate_allocator_report().map(|report| report.total_allocated_bytes);
    let (ball, before) = (model(&icosphere(320)), taken());
    let mut queries = [(); 3].map(|()| PairQuery::new().on(&executor));
    let mut ask = |i: usize| {
        let pose = Pose::from_translation([0.1, 0.2, 0.3 + 0.1 * i as f32]);
        let found = queries[i].all(&ball, &ball, pose).unwrap();
        assert_eq!(found, PairQuery::new().all(&ball, &ball, pose).unwrap());
        taken()
    };
    let [first, second, third] = [0, 1, 2].map(&mut ask);
    if let (Some(before), Some(first), Some(second), Some(third)) = (before, first, second, third) {
        assert!(first - before >= 16 << 20, "{before} {first}");
        assert!(second.max(third) < first + (1 << 20), "{first} {second} {third}");
    }
}
