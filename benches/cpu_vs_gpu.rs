//! The same frames on the CPU and on a GPU, pairs on the host: on one thread, on all, through the device.
//!
//! `cargo bench --bench cpu_vs_gpu --features gpu`, on the best adapter, if only one that computes on the
//! CPU. A mesh that deforms is moved and refitted in each frame, where it is asked about. With recorded
//! data (`PFRONT_DATA`, see test.sh) two dragons of 871,414 triangles are added. All answers are compared
//! before anything is timed. Where the device spends its time: `pfront-lab passes`.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

mod backends;
mod cases;

use backends::{Backend, Cpu, on_gpu};
use cases::{Asker, CASES, FRAMES, all_threads, turn};
use criterion::{Criterion, criterion_group, criterion_main};
use pfront::gpu::Gpu;

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
