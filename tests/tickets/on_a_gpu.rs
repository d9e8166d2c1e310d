//! Tickets of executors with a GPU.

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
    let taken = || gpu.device().generate_allocator_report().map(|all| all.total_allocated_bytes);
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
    assert!(reasons.iter().enumerate().all(|(i, own)| (i == 7) == own.is_some()), "{reasons:?}");
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

/// Pairs that are more than a submission holds are several, with what else is asked between them.
#[test]
fn a_batch_of_several_submissions_is_answered_in_order() {
    let tile = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let tile = Arc::new(Model::new(tile, vec![[0, 1, 2]]).unwrap());
    let (_, executor) = EXECUTORS.iter().find(|(name, _)| *name == "gpu").unwrap();
    let mut batch = Batch::new();
    for i in 0..66_000 {
        if i == 33_000 {
            batch.itself(&sheet(200), Adjacency::default());
        }
        batch.pair(&tile, &tile, Pose::from_translation([0.0, 0.0, (i % 3) as f32])).unwrap();
    }
    let (counts, lists) = (batch.count(executor).unwrap(), batch.all(executor).unwrap());
    let (mut counts, mut lists) =
        (counts.read().unwrap(), lists.read().unwrap().iter().map(<[_]>::len).collect::<Vec<_>>());
    assert_eq!(counts.remove(33_000), lists.remove(33_000) as u64);
    assert!(counts.iter().enumerate().all(|(i, &count)| count == u64::from(i % 3 == 0)));
    assert!(lists.iter().enumerate().all(|(i, &len)| len == usize::from(i % 3 == 0)));
}
