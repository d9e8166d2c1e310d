//! Every executor gives the same answers, frame by frame and verb by verb, as sequential queries that know nothing of earlier
//! frames; and an unchanged question is answered by the last answer.

mod kept;
mod verbs;

use crate::crosses;
use pfront::{BodyId, Error, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::{Scene, icosphere};
use std::sync::{Arc, Barrier, LazyLock};
use std::thread;
use verbs::{Between, Verbs, Within, check};

/// Every kind of executor, made once: what queries of several tests share is tested by that, too.
static EXECUTORS: LazyLock<Vec<(&'static str, Executor)>> = LazyLock::new(|| {
    let mut all = vec![("sequential", Executor::sequential())];
    #[cfg(feature = "threads")]
    {
        use pfront::threads::{Pool, Schedule, Settings};
        all.extend([
            ("1 thread", Executor::threads(1)),
            ("2 threads", Executor::threads(2)),
            ("7 threads", Executor::threads(7)),
        ]);
        let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let pool = Pool::from(Arc::new(pool)).with_settings(settings);
        all.push(("static", pool.into()));
    }
    #[cfg(feature = "gpu")]
    {
        use pfront::gpu::{Budget, Gpu, GpuSettings};
        let gpu = Gpu::new().unwrap();
        let settings = GpuSettings { budget: Budget { bytes: 1 << 20 }, ..gpu.settings() };
        all.push(("gpu", Executor::gpu(&gpu, settings)));
        all.push((
            "sequential and gpu",
            Executor::sequential().and_gpu(&gpu, gpu.settings()).unwrap(),
        ));
        #[cfg(feature = "threads")]
        all.push((
            "2 threads and gpu",
            Executor::threads(2).and_gpu(&gpu, gpu.settings()).unwrap(),
        ));
    }
    all
});

fn model(mesh: &MeshData) -> Model {
    Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
}

/// A worm drive, and poses in which it turns, is taken apart, and is put together again.
fn worm() -> (Model, Model, Vec<Pose>) {
    let scene = Scene::by_name("worm-gear", Some(4_000)).unwrap();
    let mut rows = Vec::new();
    let mut poses: Vec<_> = (0..10)
        .map(|frame| {
            scene.poses(frame, &mut rows);
            Pose::new(rows[1])
        })
        .collect();
    poses.push(Pose::from_translation([100.0, 0.0, 0.0]));
    poses.push(poses[3]);
    let [a, b] = [0, 1].map(|object| model(&scene.meshes[scene.objects[object]]));
    (a, b, poses)
}

/// The positions of a sheet that folds, with two jumps.
fn folds() -> (Model, Vec<Vec<[f32; 3]>>) {
    let scene = Scene::by_name("sheet", Some(2_000)).unwrap();
    let positions = |frame| {
        let mut positions = Vec::new();
        scene.positions(frame, &mut positions);
        positions
    };
    let frames = (70..80).chain([5, 110, 111]).map(positions).collect();
    (model(&scene.meshes[0]), frames)
}

#[test]
fn pairs_are_the_same() {
    let (a, b, poses) = worm();
    for (name, executor) in EXECUTORS.iter() {
        let mut query = PairQuery::new().on(executor);
        for (frame, &pose) in poses.iter().enumerate() {
            let mut truth = PairQuery::new();
            let mut truth = Between(&mut truth, [&a, &b], pose);
            check(&mut Between(&mut query, [&a, &b], pose), &mut truth, frame, name);
        }
    }
}

/// The models of a question change places, deform, and are one and the same.
#[test]
fn pairs_of_changing_models_are_the_same() {
    let (sheet, shapes) = folds();
    let (mut moving, ball, bare) =
        (sheet.clone(), model(&icosphere(320)), Model::new(vec![[0.0; 3]], vec![]).unwrap());
    let aside = Pose::from_translation([0.1, 0.02, 0.03]);
    for (name, executor) in EXECUTORS.iter() {
        let (mut query, mut met) = (PairQuery::new().on(executor), 0);
        for (frame, shape) in shapes.iter().enumerate().take(6) {
            moving.set_positions(shape).unwrap();
            for two in [[&moving, &ball], [&ball, &moving], [&moving; 2], [&sheet, &moving]] {
                let mut truth = PairQuery::new();
                let mut truth = Between(&mut truth, two, aside);
                met += check(&mut Between(&mut query, two, aside), &mut truth, frame, name);
            }
            for two in [[&bare, &moving], [&moving, &bare], [&bare; 2]] {
                assert!(query.all(two[0], two[1], aside).unwrap().is_empty(), "{name}");
            }
        }
        assert!(met > 1_000, "{met}");
    }
}

#[test]
fn a_deforming_mesh_is_the_same() {
    let (start, shapes) = folds();
    for (name, executor) in EXECUTORS.iter() {
        let (mut own, mut other) = (start.clone(), start.clone());
        let (mut query, mut met) = (SelfQuery::new().on(executor), 0);
        for (frame, shape) in shapes.iter().enumerate() {
            match frame % 3 {
                0 => own.set_positions(shape).unwrap(),
                _ => query.set_positions(&mut own, shape).unwrap(),
            }
            other.set_positions(shape).unwrap();
            let mut truth = SelfQuery::new();
            let mut truth = Within(&mut truth, &other);
            met += check(&mut Within(&mut query, &own), &mut truth, frame, name);
        }
        assert!(met > 100, "{met}");
    }
}

/// Pairs of crossing triangles in a row, which change places: a tree is worn by that, and built anew.
#[test]
fn a_mesh_whose_parts_change_places_is_the_same() {
    const PARTS: u64 = 600;
    let shape = |stride, shift| crosses(PARTS, stride, shift);
    let triangles: Vec<_> = (0..2 * PARTS as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    // The strides have no factor in common with the number of parts.
    let frames = [(1, 0.0), (7, 0.0), (7, 0.5), (11, 0.0), (11, 0.25), (13, 0.0), (1, 0.0)];
    for (name, executor) in EXECUTORS.iter() {
        let mut own = Model::new(shape(1, 0.0), triangles.clone()).unwrap();
        let mut query = SelfQuery::new().on(executor);
        for (frame, &(stride, shift)) in frames.iter().enumerate() {
            query.set_positions(&mut own, &shape(stride, shift)).unwrap();
            let other = Model::new(shape(stride, shift), triangles.clone()).unwrap();
            let mut truth = SelfQuery::new();
            let mut truth = Within(&mut truth, &other);
            let met = check(&mut Within(&mut query, &own), &mut truth, frame, name);
            assert!(met >= PARTS as usize, "{name} {frame}: {met}");
        }
    }
}

/// A heap of balls, to which something happens each frame.
struct Heap {
    ball: MeshData,
    shared: Arc<Model>,
}

impl Heap {
    fn new() -> Self {
        let ball = icosphere(320);
        Self { shared: Arc::new(model(&ball)), ball }
    }

    fn at(i: usize, frame: usize) -> Pose {
        let turn = 0.02 * frame as f32 * (i % 3) as f32;
        Pose::from_translation([1.6 * (i % 4) as f32 + turn, 1.7 * (i / 4) as f32, 0.3 * turn])
    }

    fn fill(&self, scene: &mut SceneQuery) {
        for i in 0..12 {
            scene.add(self.shared.clone(), Self::at(i, 0)).unwrap();
        }
    }

    /// Nothing happens in every fourth frame.
    fn happen(&self, scene: &mut SceneQuery, frame: usize) {
        let ids: Vec<BodyId> = scene.bodies().map(pfront::Body::id).collect();
        if frame % 4 == 1 {
            return;
        }
        for (i, &id) in ids.iter().enumerate().filter(|(i, _)| (i + frame).is_multiple_of(3)) {
            scene.set_pose(id, Self::at(i, frame)).unwrap();
        }
        match frame {
            2 | 9 => drop(scene.remove(ids[3]).unwrap()),
            3 | 10 => drop(scene.add(self.shared.clone(), Self::at(7, 40)).unwrap()),
            4 | 6 | 7 => {
                let scale = 1.0 + 0.03 * frame as f32;
                let grown: Vec<_> =
                    self.ball.positions.iter().map(|p| p.map(|x| scale * x)).collect();
                scene.set_positions(ids[6], &grown).unwrap();
            }
            // The second is of one that has deformed.
            8 => drop(scene.split(ids[2], |triangle| triangle % 2).unwrap()),
            11 => drop(scene.split(ids[5], |triangle| triangle / 100).unwrap()),
            12 => ids.iter().skip(1).for_each(|&id| drop(scene.remove(id).unwrap())),
            13 => drop(scene.remove(ids[0]).unwrap()),
            14 => self.fill(scene),
            _ => {}
        }
    }
}

/// The same bodies, of which nothing is known.
fn forgetful(scene: &SceneQuery) -> SceneQuery {
    scene.clone().on(&Executor::sequential())
}

#[test]
fn a_scene_is_the_same() {
    let heap = Heap::new();
    for (name, executor) in EXECUTORS.iter() {
        let (mut scene, mut other, mut met) =
            (SceneQuery::new().on(executor), SceneQuery::new(), 0);
        assert!(scene.all().unwrap().is_empty() && scene.any().unwrap().is_none(), "{name}");
        heap.fill(&mut scene);
        heap.fill(&mut other);
        for frame in 0..18 {
            heap.happen(&mut scene, frame);
            heap.happen(&mut other, frame);
            met += check(&mut scene, &mut forgetful(&other), frame, name);
        }
        assert!(met > 1_000, "{met}");
    }
}

/// Each frame asks one verb only, so that later ones begin with what few of them have left.
#[test]
fn a_scene_of_which_one_thing_is_asked_is_the_same() {
    let heap = Heap::new();
    for (name, executor) in EXECUTORS.iter() {
        let mut scene = SceneQuery::new().on(executor);
        heap.fill(&mut scene);
        for frame in 0..18 {
            heap.happen(&mut scene, frame);
            let truth = forgetful(&scene).all().unwrap().to_vec();
            match frame * 7 % 5 {
                0 | 1 => assert_eq!(scene.count().unwrap(), truth.len() as u64, "{name} {frame}"),
                2 => {
                    let any = scene.any().unwrap();
                    assert!(any.map_or(truth.is_empty(), |hit| truth.contains(&hit)), "{name}");
                }
                3 => assert_eq!(scene.visited(), truth, "{name} {frame}"),
                _ => assert_eq!(scene.all().unwrap(), truth, "{name} {frame}"),
            }
        }
    }
}

#[test]
fn a_scene_goes_from_executor_to_executor() {
    let heap = Heap::new();
    let mut scene = SceneQuery::new();
    heap.fill(&mut scene);
    for round in 0..3 {
        for (i, (name, executor)) in EXECUTORS.iter().enumerate() {
            let frame = round * EXECUTORS.len() + i;
            scene = scene.on(executor);
            heap.happen(&mut scene, frame % 18);
            let mut truth = forgetful(&scene);
            check(&mut scene, &mut truth, frame, name);
        }
    }
}

/// A GPU has its lists once: each question is asked between two of another query.
#[test]
fn queries_take_turns() {
    let (a, b, poses) = worm();
    let (mut sheet, shapes) = folds();
    let ball = model(&icosphere(320));
    for (name, executor) in EXECUTORS.iter() {
        let [mut first, mut second] = [(); 2].map(|()| PairQuery::new().on(executor));
        let [mut third, mut fourth] = [(); 2].map(|()| SelfQuery::new().on(executor));
        for (frame, (&pose, shape)) in poses.iter().zip(&shapes).enumerate().take(5) {
            sheet.set_positions(shape).unwrap();
            let near = Pose::from_translation([0.1 * frame as f32, 0.2, 0.3]);
            let [mut drive, mut balls] = [(); 2].map(|()| PairQuery::new());
            let mut drive = Between(&mut drive, [&a, &b], pose);
            let mut balls = Between(&mut balls, [&ball; 2], near);
            check(&mut Between(&mut first, [&a, &b], pose), &mut drive, frame, name);
            check(&mut Between(&mut second, [&ball; 2], near), &mut balls, frame, name);
            let mut truth = SelfQuery::new();
            check(&mut Within(&mut third, &sheet), &mut Within(&mut truth, &sheet), frame, name);
            check(&mut Within(&mut fourth, &a), &mut Within(&mut truth, &a), frame, name);
        }
    }
}

#[test]
fn threads_that_share_an_executor_are_answered_right() {
    let (a, b, poses) = worm();
    let (start, shapes) = folds();
    let pairs: Vec<_> =
        poses.iter().map(|pose| PairQuery::new().all(&a, &b, pose).unwrap().to_vec()).collect();
    let mut moved = start.clone();
    let selves = shapes.iter().map(|shape| {
        moved.set_positions(shape).unwrap();
        SelfQuery::new().all(&moved).unwrap().to_vec()
    });
    let selves: Vec<_> = selves.collect();
    for (name, executor) in EXECUTORS.iter() {
        let begin = Barrier::new(4);
        let two = |from: usize| {
            let mut query = PairQuery::new().on(executor);
            begin.wait();
            for i in (0..poses.len()).map(|i| (i + from) % poses.len()) {
                assert_eq!(query.all(&a, &b, poses[i]).unwrap(), pairs[i], "{name}");
            }
        };
        let one = |from: usize| {
            let (mut query, mut model) = (SelfQuery::new().on(executor), start.clone());
            begin.wait();
            for i in (0..shapes.len()).map(|i| (i + from) % shapes.len()).take(6) {
                query.set_positions(&mut model, &shapes[i]).unwrap();
                assert_eq!(query.all(&model).unwrap(), selves[i], "{name}");
            }
        };
        thread::scope(|scope| {
            scope.spawn(|| two(0));
            scope.spawn(|| two(5));
            scope.spawn(|| one(0));
            scope.spawn(|| one(5));
        });
    }
}

#[test]
fn poses_are_refused_alike_and_harm_nothing() {
    let (a, b, poses) = worm();
    let truth = PairQuery::new().all(&a, &b, poses[0]).unwrap().to_vec();
    for (name, executor) in EXECUTORS.iter() {
        let mut query = PairQuery::new().on(executor);
        for pose in [[f32::NAN, 0.0, 0.0], [0.0, 1e38, 0.0]].map(Pose::from_translation) {
            assert_eq!(query.all(&a, &b, poses[0]).unwrap(), truth, "{name}");
            let refused = query.all(&a, &b, pose).err();
            assert!(matches!(refused, Some(Error::Pose(_))), "{name}: {refused:?}");
            assert_eq!(query.contacts(&a, &b, pose).err(), refused);
            assert_eq!(query.any(&a, &b, pose).err(), refused);
            assert_eq!(query.count(&a, &b, pose).err(), refused);
        }
        assert_eq!(query.all(&a, &b, poses[0]).unwrap(), truth, "{name}");
    }
}

#[cfg(feature = "threads")]
#[test]
fn any_number_of_workers_will_do() {
    let (a, b, poses) = worm();
    let truth = PairQuery::new().all(&a, &b, poses[0]).unwrap().to_vec();
    for workers in [0, 3, 64, usize::MAX] {
        let mut query = PairQuery::new().on(&Executor::threads(workers));
        assert_eq!(query.all(&a, &b, poses[0]).unwrap(), truth, "{workers}");
    }
}

/// A frame that was divided among workers or sent to a GPU says so.
#[test]
fn the_plan_tells_who_answered() {
    use pfront::executor::{Backend, Reason};
    let ball = model(&icosphere(20_480));
    for (name, executor) in EXECUTORS.iter() {
        let mut query = PairQuery::new().on(executor);
        assert!(query.plan().is_none());
        let mut backends = Vec::new();
        for frame in 0..4 {
            let aside = Pose::from_translation([0.3 + 0.01 * frame as f32, 0.0, 0.0]);
            query.all(&ball, &ball, aside).unwrap();
            let plan = query.plan().unwrap();
            assert_eq!(plan.failure, None);
            let is_choice = name.contains("and gpu");
            assert_eq!(plan.reason == Reason::NoChoice, !is_choice, "{name}: {plan}");
            // The first frame has nothing to go by.
            assert_eq!(plan.predicted.is_some(), is_choice && frame > 0, "{name}: {plan}");
            assert!(plan.to_string().starts_with(&plan.backend.to_string()));
            backends.push(plan.backend);
            #[cfg(feature = "threads")]
            if backends.last() != Some(&Backend::Gpu) && name.contains("threads") {
                let called = query.report().is_some_and(|report| !report.shares.is_empty());
                assert_eq!(query.plan().unwrap().backend == Backend::Threads, called, "{name}");
            }
        }
        match *name {
            "sequential" | "1 thread" => assert_eq!(backends, [Backend::Sequential; 4], "{name}"),
            "gpu" => assert_eq!(backends, [Backend::Gpu; 4], "{name}"),
            "sequential and gpu" => assert!(!backends.contains(&Backend::Threads), "{name}"),
            "2 threads and gpu" => {}
            // Whether others are called depends on how long that takes on this machine, now.
            _ => assert!(!backends.contains(&Backend::Gpu), "{name}: {backends:?}"),
        }
    }
}
