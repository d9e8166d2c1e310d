//! Any query is asked in the background, from every executor, and comes back with its answer.

use pfront::{Adjacency, BodyOptions, Error, Executor, Model, Pose, SceneQuery, SelfQuery, Ticket};
use pfront_testkit::scenes::{Scene, icosphere};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{Arc, LazyLock, mpsc};

static EXECUTORS: LazyLock<Vec<(&'static str, Executor)>> = LazyLock::new(|| {
    let mut all = vec![("sequential", Executor::sequential())];
    #[cfg(feature = "threads")]
    all.extend([("1 thread", Executor::threads(1)), ("4 threads", Executor::threads(4))]);
    #[cfg(feature = "gpu")]
    {
        let gpu = pfront::gpu::Gpu::new().unwrap();
        all.push(("gpu", Executor::gpu(&gpu, gpu.settings())));
        all.push(("cpu and gpu", Executor::threads(2).and_gpu(&gpu, gpu.settings()).unwrap()));
    }
    all
});

fn aside(x: f32) -> Pose {
    Pose::from_translation([x, 0.01, 0.02])
}

#[test]
fn a_scene_is_asked_in_the_background_and_comes_back() {
    let ball = icosphere(320);
    let ball = Arc::new(Model::new(ball.positions, ball.triangles).unwrap());
    for (name, executor) in &*EXECUTORS {
        let (mut scene, mut truth) = (SceneQuery::new().on(executor), SceneQuery::new());
        let options = BodyOptions { itself: Some(Adjacency::default()), ..Default::default() };
        let [bodies, _] = [&mut scene, &mut truth].map(|scene| {
            [0.0, 0.7, 1.4].map(|x| scene.add_with(ball.clone(), aside(x), options).unwrap())
        });
        for frame in 0..6 {
            for scene in [&mut scene, &mut truth] {
                let body = scene.bodies().nth(frame % 3).unwrap().id();
                scene.set_pose(body, aside(0.2 * frame as f32)).unwrap();
            }
            let ticket = executor.submit(move || {
                let contacts = scene.contacts().map(<[_]>::len);
                (scene, contacts)
            });
            let (back, contacts) = ticket.unwrap().read().unwrap();
            scene = back;
            assert_eq!(scene.hits().len(), truth.all().unwrap().len(), "{name} {frame}");
            assert_eq!(contacts, truth.contacts().map(<[_]>::len), "{name} {frame}");
            // The scene knows what it has found.
            scene.all().unwrap();
            let backend = scene.plan().unwrap().backend;
            assert_eq!(backend, pfront::executor::Backend::Cached, "{name} {frame}");
        }
        assert_eq!(scene.body(bodies[0]).unwrap().options(), options);
    }
}

#[test]
fn a_mesh_that_deforms_goes_with_its_query() {
    let scene = Scene::by_name("sheet", Some(2_000)).unwrap();
    let mesh = &scene.meshes[0];
    let new = || Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
    for (name, executor) in &*EXECUTORS {
        let (mut query, mut sheet) = (SelfQuery::new().on(executor), new());
        let (mut truth, mut other) = (SelfQuery::new(), new());
        for frame in 0..4 {
            let mut positions = Vec::new();
            scene.positions(30 * frame, &mut positions);
            truth.set_positions(&mut other, &positions).unwrap();
            let ticket = executor.submit(move || {
                query.set_positions(&mut sheet, &positions)?;
                let pairs = query.all(&sheet)?.to_vec();
                Ok::<_, Error>((query, sheet, pairs))
            });
            let pairs;
            (query, sheet, pairs) = ticket.unwrap().read().unwrap().unwrap();
            assert_eq!(pairs, truth.all(&other).unwrap(), "{name} {frame}");
        }
    }
}

#[test]
fn a_panic_is_an_error_of_the_ticket() {
    for (name, executor) in &*EXECUTORS {
        let ticket = executor.submit(|| std::panic::resume_unwind(Box::new(0)) as ()).unwrap();
        assert_eq!(ticket.read(), Err(Error::Panicked), "{name}");
        assert_eq!(executor.submit(|| 1).unwrap().read(), Ok(1), "{name}");
    }
}

#[test]
fn a_ticket_can_be_awaited_and_polled() {
    for (name, executor) in &*EXECUTORS {
        assert_eq!(pollster::block_on(executor.submit(|| 2).unwrap()), Ok(2), "{name}");
        let mut ticket = executor.submit(|| 3).unwrap();
        while !ticket.is_ready() {
            std::thread::yield_now();
        }
        assert_eq!(ticket.try_read(), Ok(Some(3)), "{name}");
        assert_eq!(ticket.try_read(), Err(Error::AlreadyRead), "{name}");
        assert_eq!(ticket.plan(0), None, "{name}");
    }
}

/// A ticket that waits until the sender goes, and keeps whatever does others' work busy, if that is one thread.
fn blocked(executor: &Executor) -> (Ticket<()>, mpsc::Sender<()>) {
    let (end, ended) = mpsc::channel::<()>();
    let wait = move || {
        let _ = ended.recv();
    };
    (executor.submit(wait).unwrap(), end)
}

#[test]
fn work_that_has_not_begun_ends_with_its_ticket() {
    // The global pool would begin work at once.
    #[cfg_attr(not(feature = "threads"), expect(unused_mut, reason = "one executor"))]
    let mut queues = vec![("sequential", Executor::sequential())];
    #[cfg(feature = "threads")]
    {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        queues.push(("a pool of one", pfront::threads::Pool::from(Arc::new(pool)).into()));
    }
    #[cfg(feature = "gpu")]
    {
        let gpu = pfront::gpu::Gpu::new().unwrap();
        queues.push(("gpu", Executor::gpu(&gpu, gpu.settings())));
    }
    for (name, executor) in queues {
        let (ticket, end) = blocked(&executor);
        let runs = Arc::new(AtomicU32::new(0));
        let mut submit = |_| {
            let runs = runs.clone();
            executor.submit(move || runs.fetch_add(1, Relaxed)).unwrap()
        };
        let mut tickets: Vec<_> = (0..1_000).map(&mut submit).collect();
        tickets[0].cancel();
        assert_eq!(tickets[0].try_read(), Err(Error::Cancelled), "{name}");
        drop(tickets);
        drop(end);
        ticket.read().unwrap();
        submit(0).read().unwrap();
        assert_eq!(runs.load(Relaxed), 1, "{name}");
    }
}

/// The threads of this process, by what the system counts.
#[cfg(target_os = "linux")]
fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// A thousand tickets in flight take one thread of an executor at most.
#[cfg(target_os = "linux")]
#[test]
fn a_thousand_tickets_take_no_thread_each() {
    for (name, executor) in &*EXECUTORS {
        executor.submit(|| ()).unwrap().read().unwrap();
        let before = threads();
        let slow = || std::thread::sleep(std::time::Duration::from_micros(10));
        let tickets: Vec<_> = (0..1_000).map(|_| executor.submit(slow).unwrap()).collect();
        // Other tests of this file start executors of their own meanwhile.
        assert!(threads() < before + 100, "{name}");
        tickets.into_iter().for_each(|ticket| ticket.read().unwrap());
    }
}

/// A ticket within a ticket: the thread that answers both does not wait for itself.
#[test]
fn a_question_may_ask_in_the_background_itself() {
    let ball = icosphere(80);
    let ball = Arc::new(Model::new(ball.positions, ball.triangles).unwrap());
    for (name, executor) in &*EXECUTORS {
        let (own, model) = (executor.clone(), ball.clone());
        let ticket = executor.submit(move || {
            let mut batch = pfront::Batch::new();
            batch.pair(&model, &model, Pose::IDENTITY)?;
            batch.pair(&model, &model, aside(9.0))?;
            Ok::<_, Error>((own.submit(|| 7)?.read()?, batch.count(&own)?.read()?))
        });
        let (seven, counts) = ticket.unwrap().read().unwrap().unwrap();
        assert_eq!((seven, counts[1]), (7, 0), "{name}");
        assert!(counts[0] > 0, "{name}");
    }
}

/// A function that waits for what is dropped after its ticket and its executor.
#[cfg(feature = "gpu")]
#[test]
fn whoever_drops_a_ticket_does_not_wait_for_its_function() {
    let gpu = pfront::gpu::Gpu::new().unwrap();
    let executor = Executor::gpu(&gpu, gpu.settings());
    let ((begin, begun), (end, ended)) = (mpsc::channel(), mpsc::channel::<()>());
    let wait = move || {
        begin.send(()).unwrap();
        let _ = ended.recv();
    };
    let ticket = executor.submit(wait).unwrap();
    begun.recv().unwrap();
    drop(ticket);
    drop(executor);
    drop(end);
}
