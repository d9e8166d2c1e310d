//! The same frames on all threads of the CPU, on the GPU, and on both at once, pairs on the host.
//!
//! `cargo bench --bench hybrid --features gpu`, on the best adapter. Both work on one front, of which the GPU
//! gets a share by expected cost; a mesh that deforms is refitted by each of them in each frame. Cases are
//! those of `cpu_vs_gpu`, and all answers are compared before anything is timed.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

mod backends;
mod cases;

use backends::{Backend, Cpu, on_gpu};
use cases::{Asker, CASES, Case, FRAMES, all_threads, traversal, turn};
use criterion::{Criterion, criterion_group, criterion_main};
use pfront::core::bvtt::{self, NodePair, Query};
use pfront::gpu::wgpu::CommandEncoder;
use pfront::gpu::{self, Deforming, Gpu, Pending};
use pfront::threads::{Schedule, Traversal};
use pfront::{Model, Pose, TrianglePair};

/// What the GPU gets, in per cent.
const SHARES: [u32; 5] = [5, 10, 20, 35, 50];

/// All threads and the GPU, which gets a share.
struct Both {
    gpu: Gpu,
    share: f64,
    traversal: Traversal,
    pairs: Vec<TrianglePair>,
}

impl Both {
    fn new(gpu: &Gpu, share: f64) -> Self {
        let traversal = traversal(all_threads(), Schedule::Hybrid);
        Self { gpu: gpu.clone(), share, traversal, pairs: Vec::new() }
    }

    /// Asks; `record` records what lies below the nodes of the GPU.
    fn ask<'q>(
        &mut self,
        query: &(impl Query + Sync),
        record: impl FnOnce(&mut CommandEncoder, &[NodePair]) -> Result<Pending<'q>, gpu::Error> + Send,
    ) -> &[TrianglePair] {
        let Self { gpu, share, traversal, pairs } = self;
        let start = |below: &[NodePair]| {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let pending = record(&mut encoder, below);
            gpu.queue().submit([encoder.finish()]);
            pending.unwrap()
        };
        let pending = traversal.all_beside(query, *share, start, pairs);
        pairs.extend_from_slice(pending.read().unwrap());
        // Two runs, which this merges.
        pairs.sort();
        pairs
    }
}

struct Pair<'c> {
    both: Both,
    host: [&'c Model; 2],
    device: [gpu::Model; 2],
    poses: &'c [Pose],
    query: gpu::PairQuery,
}

impl Backend for Pair<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        let Self { both, host: [a, b], device: [on_a, on_b], poses, query } = self;
        let pose = &poses[frame];
        let asked = bvtt::PairQuery::new(a.bvh(), b.bvh(), *pose).unwrap();
        both.ask(&asked, |encoder, below| query.record_below(encoder, on_a, on_b, pose, below))
    }
}

struct Within<'c> {
    both: Both,
    host: Model,
    device: Deforming,
    frames: &'c [Model],
    query: gpu::SelfQuery,
}

impl Backend for Within<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        let Self { both, host, device, frames, query } = self;
        let positions = frames[frame].mesh().positions();
        device.set_positions(positions).unwrap();
        host.set_positions_with_threads(positions).unwrap();
        let asked = bvtt::SelfQuery::new(host.bvh()).with_fans(host.fans());
        both.ask(&asked, |encoder, below| query.record_below(encoder, device, below))
    }
}

fn on_both<'c>(gpu: &Gpu, case: &'c Case, share: f64) -> Box<dyn Backend + 'c> {
    let both = Both::new(gpu, share);
    match case {
        Case::Pair { a, b, poses, .. } => Box::new(Pair {
            both,
            host: [a, b],
            device: [a, b].map(|model| gpu::Model::new(gpu, model.bvh()).unwrap()),
            poses,
            query: gpu::PairQuery::new(gpu).unwrap(),
        }),
        // A tree made for these frames, which no refit among them replaces: its nodes are the device's too.
        Case::Within { frames, .. } => Box::new(Within {
            both,
            host: frames[0].clone(),
            device: Deforming::new(gpu, frames[0].bvh()).unwrap(),
            frames,
            query: gpu::SelfQuery::new(gpu).unwrap(),
        }),
    }
}

fn frames(c: &mut Criterion) {
    let gpu = Gpu::new().unwrap_or_else(|error| panic!("{error}"));
    let adapter = gpu.device().adapter_info().name;
    for case in CASES.iter() {
        let mut group = c.benchmark_group(format!("hybrid/{}", case.name()));
        group.sample_size(20);
        let mut backends: Vec<(String, Box<dyn Backend + '_>)> = vec![
            (format!("{} threads", all_threads()), Box::new(Cpu::new(case, true))),
            (adapter.clone(), on_gpu(&gpu, case)),
        ];
        for share in SHARES {
            let both = on_both(&gpu, case, f64::from(share) / 100.0);
            backends.push((format!("both, {share} % on the GPU"), both));
        }
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
