//! Tickets bring the answers of queries, from every executor, however they are read, and never more than once.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

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

#[cfg(feature = "gpu")]
mod on_a_gpu {
    use super::*;

    /// Threads of this process that answer tickets, if the system tells.
    fn readers() -> Option<usize> {
        let tasks = std::fs::read_dir("/proc/self/task").ok()?;
        let name = |task: std::io::Result<std::fs::DirEntry>| {
            std::fs::read_to_string(task.ok()?.path().join("comm")).ok()
        };
        Some(tasks.filter_map(name).filter(|name| name.starts_with("pfront ticket")).count())
    }

    /// In a process of its own, since other tests have such threads.
    #[test]
    fn there_is_one_thread_for_all_tickets_and_none_after_them() {
        const ALONE: &str = "PFRONT_ALONE";
        if std::env::var_os(ALONE).is_none() {
            let own = "on_a_gpu::there_is_one_thread_for_all_tickets_and_none_after_them";
            let mut child = std::process::Command::new(std::env::current_exe().unwrap());
            let child = child.args(["--exact", own, "--nocapture"]).env(ALONE, "1").output();
            let child = child.unwrap();
            assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stderr));
            return;
        }
        let Some(before) = readers() else { return };
        assert_eq!(before, 0);
        let gpu = Gpu::new().unwrap();
        let settings = GpuSettings { budget: Budget::LEAST, ..gpu.settings() };
        let (batch, truth) = mixed(9);
        for is_executor_first in [false, true] {
            let executor = Executor::gpu(&gpu, settings);
            let tickets: Vec<_> = (0..8).map(|_| batch.clone().count(&executor).unwrap()).collect();
            assert_eq!(readers(), Some(1));
            if is_executor_first {
                drop(executor);
                let mut tickets = tickets.into_iter();
                let counts = tickets.next().unwrap().read().unwrap();
                assert!(counts.into_iter().eq(truth.iter().map(|all| all.len() as u64)));
                assert_eq!(readers(), Some(1));
                drop(tickets);
            } else {
                drop(tickets);
                drop(executor);
            }
            assert_eq!(readers(), Some(0), "{is_executor_first}");
        }
    }

    /// Runs that are submitted after a batch is cancelled.
    #[test]
    fn a_cancelled_batch_submits_nothing_more() {
        let gpu = Gpu::new().unwrap();
        let settings = GpuSettings { budget: Budget { bytes: 1 << 18 }, ..gpu.settings() };
        let executor = Executor::gpu(&gpu, settings);
        let sheet = sheet(6_000);
        let mut batch = endless(&sheet, 200);
        let mut ticket = batch.count(&executor).unwrap();
        // Some of many runs.
        while gpu.totals().runs < 5 {
            std::thread::sleep(Duration::from_millis(1));
        }
        ticket.cancel();
        let cancelled_at = gpu.totals().runs;
        std::thread::sleep(Duration::from_millis(500));
        let after = gpu.totals().runs;
        assert!(after <= cancelled_at + 1, "{cancelled_at} {after}");
        assert_eq!(ticket.read(), Err(Error::Cancelled));
    }

    #[test]
    fn lists_of_tickets_are_few_however_many_are_in_flight() {
        let gpu = Gpu::new().unwrap();
        let bytes = 16 << 20;
        let settings = GpuSettings { budget: Budget { bytes }, ..gpu.settings() };
        let executor = Executor::gpu(&gpu, settings);
        let (mut batch, truth) = mixed(1);
        batch.count(&executor).unwrap().read().unwrap();
        let taken =
            || gpu.device().generate_allocator_report().map(|all| all.total_allocated_bytes);
        let before = taken();
        let mut tickets: Vec<_> = (0..20).map(|_| batch.all(&executor).unwrap()).collect();
        let shown = tickets.iter().filter(|ticket| ticket.hits_buffer().is_some()).count();
        assert_eq!(shown, 2);
        // The last is answered while all others are there, read by nobody.
        let last = tickets.pop().unwrap().read().unwrap();
        assert_eq!(last[0], truth[0]);
        if let (Some(before), Some(now)) = (before, taken()) {
            assert!(now <= before + 5 * bytes, "{before} {now}");
        }
        for ticket in tickets {
            assert_eq!(ticket.read().unwrap()[0], truth[0]);
        }
    }

    #[test]
    fn the_plan_of_a_ticket_is_true() {
        let gpu = Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let ball = ball(500);
        let ball_f64 = in_f64(&ball);
        let pose = aside(0.1);
        let pose_f64 = Pose64::from_translation([0.1, 0.01, 1e-9]);
        let ask = |add: &dyn Fn(&mut Batch)| {
            let mut batch = Batch::new();
            add(&mut batch);
            let before = gpu.totals().runs;
            let ticket = batch.count(&executor).unwrap();
            let plan = ticket.plan(0).unwrap();
            ticket.read().unwrap();
            (plan.backend, plan.reason, gpu.totals().runs > before)
        };
        let on_gpu = (Backend::Gpu, Reason::NoChoice, true);
        assert_eq!(ask(&|batch| batch.pair(&ball, &ball, pose).unwrap()), on_gpu);
        assert_eq!(ask(&|batch| batch.pair(&ball_f64, &ball, pose).unwrap()), on_gpu);
        assert_eq!(ask(&|batch| batch.pair(&ball, &ball, pose_f64).unwrap()), on_gpu);
        assert_eq!(ask(&|batch| batch.itself(&ball, Adjacency::default())), on_gpu);
        let on_cpu = (Backend::Sequential, Reason::CpuOnly, false);
        assert_eq!(ask(&|batch| batch.itself(&ball_f64, Adjacency::default())), on_cpu);
        // In one batch, each has its own.
        let (mut batch, _) = mixed(9);
        let ticket = batch.count(&executor).unwrap();
        let on_cpu = |plan: Plan| (plan.backend == Backend::Sequential).then_some(plan.reason);
        let reasons: Vec<_> = (0..9).map(|i| on_cpu(ticket.plan(i).unwrap())).collect();
        assert!(
            reasons.iter().enumerate().all(|(i, own)| (i == 7) == own.is_some()),
            "{reasons:?}"
        );
        assert_eq!(ticket.plan(9), None);
    }

    /// Nobody polls.
    #[test]
    fn a_question_in_f64_does_not_keep_a_batch_from_being_answered() {
        let gpu = Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let (mut batch, truth) = mixed(9);
        let mut ticket = batch.count(&executor).unwrap();
        let clock = std::time::Instant::now();
        while !ticket.is_ready() {
            assert!(clock.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(200));
        }
        let counts = ticket.try_read().unwrap().unwrap();
        assert!(counts.into_iter().eq(truth.iter().map(|all| all.len() as u64)));
    }

    #[test]
    fn models_are_uploaded_once_though_batches_and_tickets_go() {
        let gpu = Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let [a, b] = [ball(500), sheet(2_000)];
        for i in 0..4 {
            let mut batch = Batch::new();
            batch.pair(&a, &b, aside(0.1 * i as f32)).unwrap();
            batch.count(&executor).unwrap().read().unwrap();
            assert_eq!(gpu.totals().uploads, 2);
        }
        PairQuery::new().on(&executor).count(&a, &b, aside(0.7)).unwrap();
        assert_eq!(gpu.totals().uploads, 2);
        // Without room for what nobody holds, each question uploads.
        let executor = Executor::gpu(&gpu, GpuSettings { mesh_bytes: 0, ..gpu.settings() });
        for i in 1..3 {
            let mut batch = Batch::new();
            batch.pair(&a, &b, aside(0.1)).unwrap();
            batch.count(&executor).unwrap().read().unwrap();
            assert_eq!(gpu.totals().uploads, 2 + 2 * i);
        }
    }

    use pfront::executor::{Backend, Plan, Reason};
    use pfront::gpu::wgpu::{
        Buffer, BufferDescriptor, BufferUsages, MapMode, PollType, SubmissionIndex,
    };
    use pfront::gpu::{Budget, Gpu, GpuQuery, GpuSettings};
    use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

    fn buffer(gpu: &Gpu, size: u64, usage: BufferUsages) -> Buffer {
        let descriptor = BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        gpu.device().create_buffer(&descriptor)
    }

    /// Some seconds of work that another user of the device submits. The flag tells when it is done.
    fn load(gpu: &Gpu) -> (SubmissionIndex, Arc<AtomicBool>) {
        let size = 64 << 20;
        let both = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let [from, to] = [buffer(gpu, size, both), buffer(gpu, size, both)];
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        for _ in 0..60 {
            encoder.copy_buffer_to_buffer(&from, 0, &to, 0, size);
            encoder.copy_buffer_to_buffer(&to, 0, &from, 0, size);
        }
        let done = Arc::new(AtomicBool::new(false));
        let own = done.clone();
        let index = gpu.queue().submit([encoder.finish()]);
        gpu.queue().on_submitted_work_done(move || own.store(true, SeqCst));
        (index, done)
    }

    /// Whether the load is done, by the device itself.
    fn is_done(gpu: &Gpu, index: &SubmissionIndex) -> bool {
        let now =
            PollType::Wait { submission_index: Some(index.clone()), timeout: Some(Duration::ZERO) };
        gpu.device().poll(now).is_ok()
    }

    /// Submits early and reads late: neither waits for what others submit.
    #[test]
    fn a_ticket_waits_for_nothing_that_is_submitted_after_it() {
        let gpu = Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let (mut batch, truth) = mixed(1);
        // Uploads and lists.
        batch.count(&executor).unwrap().read().unwrap();
        for way in 0..3 {
            let mut ticket = batch.count(&executor).unwrap();
            let (index, done) = load(&gpu);
            let found = match way {
                0 => ticket.read().unwrap(),
                1 => ticket.wait(Duration::from_secs(60)).unwrap().unwrap(),
                _ => polled(ticket),
            };
            assert!(!is_done(&gpu, &index) && !done.load(SeqCst), "{way}");
            assert_eq!(found, [truth[0].len() as u64]);
            gpu.device().poll(PollType::wait_indefinitely()).unwrap();
        }
    }

    /// A ticket that is asked too early says so at once: many times while the device works.
    #[test]
    fn to_ask_a_ticket_is_not_to_wait_for_it() {
        let gpu = Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let (ball, mut batch) = (ball(20_000), Batch::new());
        batch.pair(&ball, &ball, aside(0.1)).unwrap();
        let truth = PairQuery::new().count(&ball, &ball, aside(0.1)).unwrap();
        for way in 0..3 {
            let (mut ticket, mut early) = (batch.count(&executor).unwrap(), 0);
            let found = loop {
                let found = match way {
                    0 => ticket.try_read().unwrap(),
                    1 => ticket.wait(Duration::ZERO).unwrap(),
                    _ if !ticket.is_ready() => None,
                    // It is known that this does not wait.
                    _ => ticket.try_read().unwrap(),
                };
                match found {
                    Some(found) => break found,
                    None => early += 1,
                }
            };
            assert_eq!(found, [truth]);
            assert!(early > 100, "{way}: {early}");
        }
    }

    /// A consumer on the device sees what the host reads, also after the host has read it.
    #[test]
    fn buffers_hold_the_hits_until_the_ticket_goes() {
        let gpu = Gpu::new().unwrap();
        let executor = Executor::gpu(&gpu, gpu.settings());
        let (ball, mut batch) = (ball(2_000), Batch::new());
        batch.pair(&ball, &ball, aside(0.1)).unwrap();
        let truth = PairQuery::new().all(&ball, &ball, aside(0.1)).unwrap().to_vec();
        for is_read_before in [false, true] {
            let mut ticket = batch.all(&executor).unwrap();
            if is_read_before {
                assert_eq!(&ticket.wait(Duration::MAX).unwrap().unwrap()[0], truth);
            }
            // Another ticket gets other lists.
            let mut other = Batch::new();
            other.pair(&ball, &ball, aside(0.3)).unwrap();
            let other = other.all(&executor).unwrap();
            let (hits, count) = (ticket.hits_buffer().unwrap(), ticket.count_buffer().unwrap());
            let size = 8 * truth.len() as u64;
            let copy = buffer(&gpu, size + 64, BufferUsages::COPY_DST | BufferUsages::MAP_READ);
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(hits, 0, &copy, 0, size);
            encoder.copy_buffer_to_buffer(count, 0, &copy, size, 28);
            gpu.queue().submit([encoder.finish()]);
            copy.map_async(MapMode::Read, .., |result| result.unwrap());
            gpu.device().poll(PollType::wait_indefinitely()).unwrap();
            let view = copy.get_mapped_range(..).unwrap();
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(&view);
            let at = |offset: u64| words[((size + offset) / 4) as usize];
            assert_eq!(at(GpuQuery::OVERFLOW_OFFSET), 0);
            assert_eq!(at(GpuQuery::REST_OFFSET), 0);
            assert_eq!(at(GpuQuery::COUNT_OFFSET) as usize, truth.len());
            let pairs = words.chunks(2).map(|pair| TrianglePair { a: pair[0], b: pair[1] });
            assert!(pairs.take(truth.len()).eq(truth.iter().copied()));
            drop(other);
        }
        batch.pair(&ball, &ball, aside(0.1)).unwrap();
        assert!(batch.all(&executor).unwrap().hits_buffer().is_none());
        assert!(batch.all(&Executor::sequential()).unwrap().hits_buffer().is_none());
    }

    /// Models that a batch keeps are uploaded once; those of another device, anew.
    #[test]
    fn a_batch_goes_from_device_to_device() {
        let (mut batch, truth) = mixed(5);
        for _ in 0..2 {
            let gpu = Gpu::new().unwrap();
            let executor = Executor::gpu(&gpu, gpu.settings());
            for _ in 0..2 {
                let lists = batch.all(&executor).unwrap().read().unwrap();
                assert!(lists.iter().eq(truth.iter().map(Vec::as_slice)));
            }
        }
    }
}
