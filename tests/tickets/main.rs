//! Tickets bring the answers of queries, from every executor, however they are read, and never more than once.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

#[cfg(feature = "gpu")]
mod on_a_gpu;

use pfront::{
    Adjacency, Batch, Error, Executor, Model, PairLists, PairQuery, Pose, Pose64, SelfQuery,
    Ticket, TrianglePair,
};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::scenes::{Scene, icosphere};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

static EXECUTORS: LazyLock<Vec<(&'static str, Executor)>> = LazyLock::new(|| {
    let mut all = vec![("sequential", Executor::sequential())];
    #[cfg(feature = "threads")]
    {
        use pfront::threads::{Pool, Schedule, Settings};
        all.extend([("1 thread", Executor::threads(1)), ("2 threads", Executor::threads(2))]);
        for (name, schedule) in [("static", Schedule::Static), ("hybrid", Schedule::Hybrid)] {
            let settings = Settings { schedule, ..Settings::default() };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            let pool = Pool::from(Arc::new(pool)).with_settings(settings);
            all.push((name, pool.into()));
        }
    }
    #[cfg(feature = "gpu")]
    {
        use pfront::gpu::{Budget, Gpu, GpuSettings};
        let gpu = Gpu::new().unwrap();
        let settings = GpuSettings { budget: Budget { bytes: 1 << 20 }, ..gpu.settings() };
        all.push(("gpu", Executor::gpu(&gpu, settings)));
        // Questions that do not fit in its lists.
        let settings = GpuSettings { budget: Budget::LEAST, ..settings };
        all.push(("gpu of little memory", Executor::gpu(&gpu, settings)));
        let both = Executor::threads(2).and_gpu(&gpu, gpu.settings()).unwrap();
        all.push(("2 threads and gpu", both));
    }
    all
});

fn ball(triangles: usize) -> Arc<Model> {
    let ball = icosphere(triangles);
    Arc::new(Model::new(ball.positions, ball.triangles).unwrap())
}

/// The same mesh in f64.
fn in_f64(model: &Arc<Model>) -> Arc<Model> {
    let mesh = model.mesh();
    let positions = mesh.shadow().iter().map(|p| p.map(f64::from)).collect();
    Arc::new(Model::from_f64(positions, mesh.triangles().to_vec()).unwrap())
}

/// A sheet in folds.
fn sheet(triangles: usize) -> Arc<Model> {
    let scene = Scene::by_name("sheet", Some(triangles)).unwrap();
    let mesh = &scene.meshes[0];
    let mut model = Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
    let mut positions = Vec::new();
    scene.positions(110, &mut positions);
    model.set_positions(&positions).unwrap();
    Arc::new(model)
}

fn aside(x: f32) -> Pose {
    Pose::from_translation([x, 0.01, 0.02])
}

/// A batch of so many questions of all kinds, and their answers.
fn mixed(count: usize) -> (Batch, Vec<Vec<TrianglePair>>) {
    let (ball, sheet) = (ball(500), sheet(2_000));
    let bare = Arc::new(Model::new(vec![[0.0; 3]], vec![]).unwrap());
    let [ball_f64, sheet_f64] = [&ball, &sheet].map(in_f64);
    let (mut batch, mut truth) = (Batch::new(), Vec::new());
    for i in 0..count {
        let pose = aside(0.1 + 0.3 * i as f32 % 2.5);
        if i % 8 == 6 {
            let pose = Pose64::from_translation([0.1 + 0.03 * i as f64, 1e-9, 0.02]);
            batch.pair(&ball_f64, &sheet, pose).unwrap();
            truth.push(PairQuery::new().all(&ball_f64, &sheet, pose).unwrap().to_vec());
            continue;
        }
        if i % 8 == 7 {
            batch.itself(&sheet_f64, Adjacency::default());
            truth.push(SelfQuery::new().all(&sheet_f64).unwrap().to_vec());
            continue;
        }
        if i % 5 == 3 {
            let adjacency = [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours][i / 5 % 2];
            batch.itself(&sheet, adjacency);
            let mut query = SelfQuery::new().with_adjacency(adjacency);
            truth.push(query.all(&sheet).unwrap().to_vec());
            continue;
        }
        let [a, b] =
            [[&ball, &ball], [&ball, &sheet], [&sheet, &ball], [&sheet, &ball], [&ball, &bare]]
                [i % 5];
        batch.pair(a, b, pose).unwrap();
        truth.push(PairQuery::new().all(a, b, pose).unwrap().to_vec());
    }
    (batch, truth)
}

/// Asserts that the answers to all verbs are right.
macro_rules! check {
    ($batch:expr, $truth:expr, $name:expr, $executor:expr, $read:expr) => {{
        let lists = $read($batch.all($executor).unwrap());
        assert_eq!(lists.len(), $truth.len(), "{}", $name);
        assert!(lists.iter().eq($truth.iter().map(Vec::as_slice)), "{}", $name);
        assert!(lists.pairs().iter().eq($truth.iter().flatten()), "{}", $name);
        let counts = $read($batch.count($executor).unwrap());
        assert!(counts.into_iter().eq($truth.iter().map(|all| all.len() as u64)), "{}", $name);
        let found = $read($batch.any($executor).unwrap());
        assert_eq!(found.len(), $truth.len(), "{}", $name);
        for (found, all) in found.iter().zip(&$truth) {
            assert!(found.map_or(all.is_empty(), |pair| all.contains(&pair)), "{}", $name);
        }
    }};
}

/// Polls a ticket until it is answered.
fn polled<T>(mut ticket: Ticket<T>) -> T {
    loop {
        if let Some(found) = ticket.try_read().unwrap() {
            return found;
        }
        std::thread::yield_now();
    }
}

#[test]
fn answers_are_those_of_queries() {
    for count in [0, 1, 2, 23] {
        let (mut batch, truth) = mixed(count);
        assert_eq!((batch.len(), batch.is_empty()), (count, count == 0));
        assert!(count < 23 || truth.iter().filter(|all| all.len() > 50).count() > 8);
        for (name, executor) in EXECUTORS.iter() {
            check!(batch, truth, name, executor, |ticket: Ticket<_>| ticket.read().unwrap());
        }
    }
}

#[test]
fn each_way_of_reading_brings_the_same() {
    fn in_slices<T>(mut ticket: Ticket<T>) -> T {
        loop {
            if let Some(found) = ticket.wait(Duration::from_micros(200)).unwrap() {
                return found;
            }
        }
    }
    fn when_ready<T>(mut ticket: Ticket<T>) -> T {
        while !ticket.is_ready() {
            std::thread::yield_now();
        }
        // A ticket that is ready is not waited for.
        ticket.wait(Duration::ZERO).unwrap().unwrap()
    }
    for count in [1, 6] {
        let (mut batch, truth) = mixed(count);
        for (name, executor) in EXECUTORS.iter() {
            check!(batch, truth, name, executor, polled);
            check!(batch, truth, name, executor, in_slices);
            check!(batch, truth, name, executor, when_ready);
            check!(batch, truth, name, executor, |ticket: Ticket<_>| pollster::block_on(ticket)
                .unwrap());
            check!(batch, truth, name, executor, |mut ticket: Ticket<_>| {
                ticket.wait(Duration::MAX).unwrap().unwrap()
            });
        }
    }
}

#[test]
fn thousands_of_questions_are_answered_in_their_order() {
    let ball = ball(80);
    let poses: Vec<_> = (0..5_000).map(|i| aside(0.0007 * i as f32)).collect();
    let (mut batch, mut query) = (Batch::new(), PairQuery::new());
    for pose in &poses {
        batch.pair(&ball, &ball, pose).unwrap();
    }
    let truth: Vec<_> =
        poses.iter().map(|pose| query.all(&ball, &ball, pose).unwrap().to_vec()).collect();
    assert!(truth.iter().any(Vec::is_empty) && truth.iter().any(|all| all.len() > 10));
    for (name, executor) in EXECUTORS.iter().filter(|(name, _)| !name.starts_with("gpu")) {
        check!(batch, truth, name, executor, |ticket: Ticket<_>| ticket.read().unwrap());
    }
}

#[test]
fn a_ticket_is_read_once() {
    let (mut batch, truth) = mixed(1);
    for (name, executor) in EXECUTORS.iter() {
        let mut ticket = batch.count(executor).unwrap();
        while ticket.try_read().unwrap().is_none() {}
        assert!(ticket.is_ready(), "{name}");
        assert_eq!(ticket.try_read(), Err(Error::AlreadyRead), "{name}");
        assert_eq!(ticket.wait(Duration::ZERO), Err(Error::AlreadyRead), "{name}");
        ticket.cancel();
        assert_eq!(pollster::block_on(&mut ticket), Err(Error::AlreadyRead), "{name}");
        assert_eq!(ticket.read(), Err(Error::AlreadyRead), "{name}");
        assert_eq!(batch.count(executor).unwrap().read().unwrap(), [truth[0].len() as u64]);
    }
}

/// Reads by tasks wake up as well when the answer comes after the first poll.
#[test]
fn tickets_in_flight_together_are_answered_in_any_order_of_reading() {
    let batches: Vec<_> = [3, 1, 9, 2].map(mixed).into();
    for (name, executor) in EXECUTORS.iter() {
        let submit = |(batch, _): &(Batch, _)| batch.clone().all(executor).unwrap();
        let tickets: Vec<_> = batches.iter().map(submit).collect();
        for (ticket, (_, truth)) in tickets.into_iter().zip(&batches).rev() {
            let lists = pollster::block_on(ticket).unwrap();
            assert!(lists.iter().eq(truth.iter().map(Vec::as_slice)), "{name}");
        }
    }
}

/// Asks one question that takes some time, or so many that they take minutes.
fn endless(ball: &Arc<Model>, questions: usize) -> Batch {
    let mut batch = Batch::new();
    for i in 0..questions {
        batch.pair(ball, ball, aside(1e-3 + 1e-6 * i as f32)).unwrap();
    }
    batch
}

#[test]
fn a_cancelled_ticket_reads_as_such_and_nobody_works_on_it() {
    for (triangles, questions) in [(100_000, 1), (20_000, 5_000)] {
        let ball = ball(triangles);
        let mut batch = endless(&ball, questions);
        for (name, executor) in EXECUTORS.iter().filter(|(name, _)| *name != "gpu of little memory")
        {
            let mut ticket = batch.count(executor).unwrap();
            assert_eq!(ticket.wait(Duration::from_millis(2)), Ok(None), "{name}");
            assert_eq!(ticket.try_read(), Ok(None), "{name}");
            ticket.cancel();
            assert!(ticket.is_ready(), "{name}");
            assert_eq!(ticket.try_read(), Err(Error::Cancelled), "{name}");
            // At once, and when it is dropped.
            let mut ticket = batch.count(executor).unwrap();
            ticket.cancel();
            drop(batch.count(executor).unwrap());
            assert_eq!(ticket.read(), Err(Error::Cancelled), "{name}");
        }
        // Threads at work hold the questions.
        let clock = std::time::Instant::now();
        drop(batch);
        while Arc::strong_count(&ball) > 1 {
            assert!(clock.elapsed() < Duration::from_secs(60), "{}", Arc::strong_count(&ball));
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn executors_and_batches_may_go_before_their_tickets() {
    let (batch, truth) = mixed(7);
    for (name, executor) in [
        ("sequential", Executor::sequential()),
        #[cfg(feature = "threads")]
        ("pool", {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
            pfront::threads::Pool::from(Arc::new(pool)).into()
        }),
        #[cfg(feature = "gpu")]
        ("gpu", {
            let gpu = pfront::gpu::Gpu::new().unwrap();
            Executor::gpu(&gpu, gpu.settings())
        }),
    ] {
        let mut batch = batch.clone();
        let ticket = batch.all(&executor).unwrap();
        // Its questions are its own.
        batch.clear();
        drop((batch, executor));
        let lists = ticket.read().unwrap();
        assert!(lists.iter().eq(truth.iter().map(Vec::as_slice)), "{name}");
    }
}

/// Questions are about what the model was when they were asked.
#[test]
fn models_that_change_while_a_ticket_is_in_flight_are_others() {
    for (name, executor) in EXECUTORS.iter() {
        let (mut model, mut batch) = (ball(320), Batch::new());
        for frame in 0..3 {
            batch.clear();
            batch.pair(&model, &model, aside(0.5)).unwrap();
            let truth = PairQuery::new().count(&model, &model, aside(0.5)).unwrap();
            let ticket = batch.count(executor).unwrap();
            let grown: Vec<_> =
                model.mesh().positions().unwrap().iter().map(|p| p.map(|x| 1.1 * x)).collect();
            Arc::make_mut(&mut model).set_positions(&grown).unwrap();
            assert_eq!(ticket.read().unwrap(), [truth], "{name} {frame}");
        }
    }
}

#[test]
fn poses_are_refused_as_queries_refuse_them() {
    let (ball, mut batch) = (ball(80), Batch::new());
    for pose in [[f32::NAN, 0.0, 0.0], [0.0, 1e38, 0.0]].map(Pose::from_translation) {
        let refused = PairQuery::new().all(&ball, &ball, pose).err();
        assert_eq!(batch.pair(&ball, &ball, pose).err(), refused);
    }
    assert!(batch.is_empty());
}

/// The only thread of a pool answers the ticket that it waits for.
#[cfg(feature = "threads")]
#[test]
fn a_thread_of_the_pool_may_wait() {
    let (mut batch, truth) = mixed(6);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let executor = Executor::threads(4);
            check!(batch, truth, threads, &executor, |ticket: Ticket<_>| ticket.read().unwrap());
            check!(batch, truth, threads, &executor, |mut ticket: Ticket<_>| {
                ticket.wait(Duration::from_secs(60)).unwrap().unwrap()
            });
        });
    }
}

#[test]
fn tickets_go_from_thread_to_thread() {
    fn sent<T: Send + Unpin>() {}
    sent::<Ticket<Vec<u64>>>();
    sent::<Batch>();
}

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap())
}

/// How often random tests go around: `PFRONT_ROUNDS`, or so often.
fn rounds(few: u64) -> u64 {
    from_environment("PFRONT_ROUNDS").unwrap_or(few)
}

/// Tickets of all verbs that are read late, in any way and order, cancelled, dropped and forgotten while others are in flight.
#[test]
fn tickets_in_any_mix_bring_what_queries_do() {
    enum Flying {
        All(Ticket<PairLists>),
        Count(Ticket<Vec<u64>>),
        Any(Ticket<Vec<Option<TrianglePair>>>),
    }
    let mut rng = seeded(from_environment("PFRONT_SEED").unwrap_or(36));
    let batches: Vec<_> = [0, 1, 2, 8, 9].map(small_mixed).into();
    for (name, executor) in EXECUTORS.iter() {
        let mut flying: Vec<(Flying, usize)> = Vec::new();
        for round in 0..rounds(60) {
            let at = rng.random_range(0..batches.len());
            let mut batch = batches[at].0.clone();
            flying.push(match rng.random_range(0..3) {
                0 => (Flying::All(batch.all(executor).unwrap()), at),
                1 => (Flying::Count(batch.count(executor).unwrap()), at),
                _ => (Flying::Any(batch.any(executor).unwrap()), at),
            });
            while flying.len() > 6 || rng.random_bool(0.4) && !flying.is_empty() {
                let (ticket, at) = flying.swap_remove(rng.random_range(0..flying.len()));
                let (truth, way) = (&batches[at].1, rng.random_range(0..8));
                macro_rules! read {
                    ($ticket:expr) => {
                        match way {
                            0 => continue,
                            1 if rng.random_bool(0.1) => {
                                std::mem::forget($ticket);
                                continue;
                            }
                            2 => {
                                let mut ticket = $ticket;
                                ticket.cancel();
                                assert_eq!(ticket.read().err(), Some(Error::Cancelled));
                                continue;
                            }
                            3 => polled($ticket),
                            4 => pollster::block_on($ticket).unwrap(),
                            _ => $ticket.read().unwrap(),
                        }
                    };
                }
                match ticket {
                    Flying::All(ticket) => {
                        let lists = read!(ticket);
                        let is_same = lists.iter().eq(truth.iter().map(Vec::as_slice));
                        assert!(is_same, "{name} {round}");
                    }
                    Flying::Count(ticket) => {
                        let counts: Vec<_> = truth.iter().map(|all| all.len() as u64).collect();
                        assert_eq!(read!(ticket), counts, "{name} {round}");
                    }
                    Flying::Any(ticket) => {
                        let found = read!(ticket);
                        assert_eq!(found.len(), truth.len());
                        for (found, all) in found.iter().zip(truth) {
                            let is_one = found.map_or(all.is_empty(), |pair| all.contains(&pair));
                            assert!(is_one, "{name} {round}");
                        }
                    }
                }
            }
        }
    }
}

/// [`mixed`] about small meshes.
fn small_mixed(count: usize) -> (Batch, Vec<Vec<TrianglePair>>) {
    let (ball, sheet) = (ball(80), sheet(200));
    let [ball_f64, sheet_f64] = [&ball, &sheet].map(in_f64);
    let (mut batch, mut truth) = (Batch::new(), Vec::new());
    for i in 0..count {
        let pose = aside(0.2 * i as f32);
        let pose_f64 = Pose64::from_translation([0.17 * i as f64, 1e-9, 0.02]);
        let pairs = match i % 9 {
            4 => {
                batch.itself(&sheet, Adjacency::default());
                SelfQuery::new().all(&sheet).unwrap().to_vec()
            }
            5 => {
                batch.itself(&sheet_f64, Adjacency::default());
                SelfQuery::new().all(&sheet_f64).unwrap().to_vec()
            }
            1 | 6 => {
                batch.pair(&ball_f64, &sheet, pose_f64).unwrap();
                PairQuery::new().all(&ball_f64, &sheet, pose_f64).unwrap().to_vec()
            }
            _ => {
                batch.pair(&ball, &sheet, pose).unwrap();
                PairQuery::new().all(&ball, &sheet, pose).unwrap().to_vec()
            }
        };
        truth.push(pairs);
    }
    (batch, truth)
}
