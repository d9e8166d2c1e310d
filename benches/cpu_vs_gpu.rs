//! The same frames on the CPU and on a GPU, pairs on the host: on one thread, on all, through the device.
//!
//! `cargo bench --bench cpu_vs_gpu --features gpu`, on the best adapter, if only one that computes on the
//! CPU. A mesh that deforms is moved and refitted in each frame, where it is asked about. With recorded
//! data (`PFRONT_DATA`, see test.sh) two dragons of 871,414 triangles are added. All answers are compared
//! before anything is timed. Where the device spends its time: `pfront bench gpu`.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

mod cases;

use cases::{Asker, CASES, Case, FRAMES, all_threads, traversal, turn};
use criterion::{Criterion, criterion_group, criterion_main};
use pfront::gpu::{self, Deforming, Gpu};
use pfront::threads::Schedule;
use pfront::{Model, Pose, TrianglePair};

/// Moves what moves to a frame, and finds its pairs.
trait Backend {
    fn frame(&mut self, frame: usize) -> &[TrianglePair];
}

/// Threads of the CPU, or one.
struct Cpu<'c> {
    case: &'c Case,
    asker: Asker,
    /// What deforms.
    moving: Option<Model>,
    threads: bool,
}

impl<'c> Cpu<'c> {
    fn new(case: &'c Case, threads: bool) -> Self {
        let moving = match case {
            Case::Pair { .. } => None,
            Case::Within { model, .. } => Some(model.clone()),
        };
        let asker = match threads {
            true => Asker::on(&traversal(all_threads(), Schedule::Hybrid)),
            false => Asker::default(),
        };
        Self { case, asker, moving, threads }
    }
}

impl Backend for Cpu<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        match (self.case, &mut self.moving) {
            (Case::Within { frames, .. }, Some(moving)) => {
                let positions = frames[frame].mesh().positions();
                match self.threads {
                    true => moving.set_positions_with_threads(positions).unwrap(),
                    false => moving.set_positions(positions).unwrap(),
                }
                self.asker.within.all(moving)
            }
            _ => self.case.found(&mut self.asker, frame),
        }
    }
}

struct Pair<'c> {
    models: [gpu::Model; 2],
    poses: &'c [Pose],
    query: gpu::PairQuery,
}

impl Backend for Pair<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        let [a, b] = &self.models;
        self.query.all(a, b, &self.poses[frame]).unwrap()
    }
}

struct Within<'c> {
    moving: Deforming,
    frames: &'c [Model],
    query: gpu::SelfQuery,
}

impl Backend for Within<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        self.moving.set_positions(self.frames[frame].mesh().positions()).unwrap();
        self.query.all(&self.moving).unwrap()
    }
}

fn on_gpu<'c>(gpu: &Gpu, case: &'c Case) -> Box<dyn Backend + 'c> {
    match case {
        Case::Pair { a, b, poses, .. } => Box::new(Pair {
            models: [a, b].map(|model| gpu::Model::new(gpu, model.bvh()).unwrap()),
            poses,
            query: gpu::PairQuery::new(gpu).unwrap(),
        }),
        Case::Within { model, frames, .. } => Box::new(Within {
            moving: Deforming::new(gpu, model.bvh()).unwrap(),
            frames,
            query: gpu::SelfQuery::new(gpu).unwrap(),
        }),
    }
}

fn frames(c: &mut Criterion) {
    let gpu = Gpu::new().unwrap_or_else(|error| panic!("{error}"));
    let adapter = gpu.device().adapter_info().name;
    for case in CASES.iter() {
        let mut group = c.benchmark_group(format!("cpu vs gpu/{}", case.name()));
        group.sample_size(20);
        let all = all_threads();
        let mut backends: [(String, Box<dyn Backend + '_>); 3] = [
            ("1 thread".to_owned(), Box::new(Cpu::new(case, false))),
            (format!("{all} threads"), Box::new(Cpu::new(case, true))),
            (adapter.clone(), on_gpu(&gpu, case)),
        ];
        for frame in 0..FRAMES {
            let truth = case.found(&mut Asker::default(), frame).to_vec();
            for (name, backend) in &mut backends {
                assert!(backend.frame(frame) == truth, "{name}, frame {frame}");
            }
        }
        for (name, backend) in &mut backends {
            let mut number = 0;
            group.bench_function(&*name, |bench| {
                bench.iter(|| {
                    number += 1;
                    backend.frame(turn(number)).len()
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
