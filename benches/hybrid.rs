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
use pfront::core::query;
use pfront::gpu::{self, Deforming, Gpu, Pending};
use pfront::threads::{Schedule, Traversal};
use pfront::{Model, Pose, TrianglePair};

/// What the GPU gets, in per cent.
const SHARES: [u32; 5] = [5, 10, 20, 35, 50];

/// All threads and the GPU.
struct Both<'c> {
    gpu: Gpu,
    asked: Asked<'c>,
    share: f64,
    traversal: Traversal,
    pairs: Vec<TrianglePair>,
}

enum Asked<'c> {
    Pair { host: [&'c Model; 2], device: [gpu::Model; 2], poses: &'c [Pose], query: gpu::PairQuery },
    Within { host: Model, device: Deforming, frames: &'c [Model], query: gpu::SelfQuery },
}

impl<'c> Both<'c> {
    fn new(gpu: &Gpu, case: &'c Case, share: f64) -> Self {
        let asked = match case {
            Case::Pair { a, b, poses, .. } => Asked::Pair {
                host: [a, b],
                device: [a, b].map(|model| gpu::Model::new(gpu, model.bvh()).unwrap()),
                poses,
                query: gpu::PairQuery::new(gpu).unwrap(),
            },
            // A tree made for these frames, which no refit among them replaces.
            Case::Within { frames, .. } => Asked::Within {
                host: frames[0].clone(),
                device: Deforming::new(gpu, frames[0].bvh()).unwrap(),
                frames,
                query: gpu::SelfQuery::new(gpu).unwrap(),
            },
        };
        let traversal = traversal(all_threads(), Schedule::Hybrid);
        Self { gpu: gpu.clone(), asked, share, traversal, pairs: Vec::new() }
    }
}

impl Backend for Both<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        let Self { gpu, asked, share, traversal, pairs } = self;
        let pending: Pending<'_> = match asked {
            Asked::Pair { host: [a, b], device: [on_a, on_b], poses, query } => {
                let pose = &poses[frame];
                let asked = query::PairQuery::new(a.bvh(), b.bvh(), *pose).unwrap();
                traversal.all_beside(
                    &asked,
                    *share,
                    |below| {
                        submit(gpu, |encoder| query.record_below(encoder, on_a, on_b, pose, below))
                    },
                    pairs,
                )
            }
            Asked::Within { host, device, frames, query } => {
                let positions = frames[frame].mesh().positions();
                device.set_positions(positions).unwrap();
                host.set_positions_with_threads(positions).unwrap();
                let asked = query::SelfQuery::new(host.bvh()).with_fans(host.fans());
                traversal.all_beside(
                    &asked,
                    *share,
                    |below| submit(gpu, |encoder| query.record_below(encoder, device, below)),
                    pairs,
                )
            }
        };
        pairs.extend_from_slice(pending.read().unwrap());
        // Two runs, which this merges.
        pairs.sort();
        pairs
    }
}

/// Has the GPU begin with what is recorded.
fn submit<'q>(
    gpu: &Gpu,
    record: impl FnOnce(&mut gpu::wgpu::CommandEncoder) -> Result<Pending<'q>, gpu::Error>,
) -> Pending<'q> {
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let pending = record(&mut encoder).unwrap();
    gpu.queue().submit([encoder.finish()]);
    pending
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
            let both = Both::new(&gpu, case, f64::from(share) / 100.0);
            backends.push((format!("both, {share} % on the GPU"), Box::new(both)));
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
