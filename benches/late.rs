//! Reading late on a device that draws: how long a ticket blocks that was submitted before a renderer's 10 ms.
//!
//! `cargo bench --features gpu --bench late`. Each frame submits a question about two torus knots and then a dispatch that
//! keeps the device busy for 10 ms, as a renderer would; 2 ms later, when the answer is there, it reads the ticket. Only the
//! reading is timed: beside it, the same without a renderer, and the device time of the question is in the first.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use criterion::{Criterion, criterion_group, criterion_main};
use pfront::gpu::{Gpu, wgpu};
use pfront::{Batch, Executor, Model, Pose};
use pfront_testkit::scenes::torus_knot;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time that the renderer draws, and after which the ticket is read.
const DRAWS: Duration = Duration::from_millis(10);
const REST: Duration = Duration::from_millis(2);

/// Keeps a device busy.
struct Renderer {
    gpu: Gpu,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    /// Rounds of a dispatch that takes [`DRAWS`].
    rounds: wgpu::Buffer,
}

impl Renderer {
    fn new(gpu: &Gpu) -> Self {
        let device = gpu.device();
        let source = "
            @group(0) @binding(0) var<storage, read_write> rounds: array<u32>;
            @compute @workgroup_size(64)
            fn draw(@builtin(global_invocation_id) id: vec3u) {
                var x = id.x;
                for (var i = 0u; i < rounds[0]; i += 1u) { x = x * 1664525u + 1013904223u; }
                if x == 7u { rounds[1] = x; }
            }";
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("draw"),
            compilation_options: Default::default(),
            cache: None,
        });
        let rounds = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 8,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: rounds.as_entire_binding() }],
        });
        let own = Self { gpu: gpu.clone(), pipeline, group, rounds };
        let mut count = 1_000_u32;
        loop {
            gpu.queue().write_buffer(&own.rounds, 0, &count.to_le_bytes());
            own.draw();
            device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            let clock = Instant::now();
            own.draw();
            device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            if clock.elapsed() >= DRAWS {
                return own;
            }
            count += count / 4;
        }
    }

    /// Submits a dispatch.
    fn draw(&self) {
        let mut encoder = self.gpu.device().create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(64, 1, 1);
        drop(pass);
        self.gpu.queue().submit([encoder.finish()]);
    }
}

fn late(c: &mut Criterion) {
    let gpu = Gpu::new().unwrap();
    let (renderer, executor) = (Renderer::new(&gpu), Executor::gpu(&gpu, gpu.settings()));
    let knot = torus_knot(70_000);
    let model = Arc::new(Model::new(knot.positions, knot.triangles).unwrap());
    let mut batch = Batch::new();
    batch.pair(&model, &model, Pose::from_translation([0.3, 0.1, 0.2])).unwrap();
    let truth = batch.all(&Executor::sequential()).unwrap().read().unwrap();

    let mut read = |draws: bool, rest: Duration| {
        let ticket = batch.all(&executor).unwrap();
        if draws {
            renderer.draw();
        }
        let submitted = Instant::now();
        while submitted.elapsed() < rest {
            std::hint::spin_loop();
        }
        let clock = Instant::now();
        let found = black_box(ticket.read().unwrap());
        let blocked = clock.elapsed();
        assert!(found == truth, "{} pairs", found.pairs().len());
        gpu.device().poll(wgpu::PollType::wait_indefinitely()).unwrap();
        blocked
    };
    let mut group = c.benchmark_group("time that a ticket blocks");
    group.sample_size(10).warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_secs(1));
    for (name, draws, rest) in [
        ("read at once", false, Duration::ZERO),
        ("read at once, a renderer draws", true, Duration::ZERO),
        ("read late", false, REST),
        ("read late, a renderer draws", true, REST),
    ] {
        group.bench_function(name, |bench| {
            bench.iter_custom(|times| (0..times).map(|_| read(draws, rest)).sum());
        });
    }
    group.finish();
}

criterion_group!(benches, late);
criterion_main!(benches);
