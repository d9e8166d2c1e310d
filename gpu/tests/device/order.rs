//! The order of hits, whichever passes see to it.

use crate::common::{Both, gpu, truth};
use pfront_core::Pose;
use pfront_gpu::{Gpu, GpuModel, GpuQuery, GpuQuestion, wgpu};
use pfront_shaders::constants;
use pfront_testkit::shapes::sphere;

/// The passes that put hits in order are recorded before the number of hits is known, by that of the last answer.
#[test]
fn answers_that_grow_and_shrink_are_in_order() {
    let soup = sphere(24);
    let ball = Both::new(&soup.positions, &soup.triangles, 4);
    let [apart, few, many] = [3.0, 0.5, 0.0].map(|x| Pose::from_translation([x, 0.0, 0.0]));
    let most = truth(&ball, &ball, &many).len();
    assert!(most > constants::FEW as usize, "{most}");
    for gpu in [gpu(), &without_features()] {
        let model = GpuModel::new(gpu, ball.bvh()).unwrap();
        let mut query = GpuQuery::new(gpu).unwrap();
        for pose in [&apart, &many, &many, &few, &few, &apart, &few, &many] {
            let (question, truth) =
                (GpuQuestion::pair(&model, &model, pose), truth(&ball, &ball, pose));
            assert_eq!(query.all(&question).unwrap(), truth);
            assert_eq!(query.count(&question).unwrap(), truth.len() as u64);
            let any = query.any(&question).unwrap();
            assert!(any.map_or(truth.is_empty(), |pair| truth.binary_search(&pair).is_ok()));
        }
    }
}

/// A device on which the host reads a copy of the results, and does not map what passes write.
fn without_features() -> Gpu {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
    Gpu::from_device(device, queue).unwrap()
}

/// So many that the sample which divides them is a larger one; the device puts them in order by itself.
#[test]
fn very_many_hits_are_in_order_on_the_device() {
    const SLATS: u32 = 400;
    const { assert!(SLATS * SLATS > constants::BUCKETS * constants::BUCKET / 10) };
    let triangles: Vec<_> = (0..SLATS).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let slats = |corners: fn(f32) -> [[f32; 3]; 3]| {
        let positions: Vec<_> = (0..SLATS).flat_map(|i| corners(i as f32)).collect();
        Both::new(&positions, &triangles, 8)
    };
    // Each of the first lies across all of the second, which stand upright.
    let a = slats(|i| [[-9.0, i, 0.0], [999.0, i + 0.1, 0.0], [999.0, i + 0.3, 0.0]]);
    let b = slats(|i| [[i + 0.5, -99.0, -1.0], [i + 0.5, 999.0, -1.0], [i + 0.5, 200.0, 5.0]]);
    let mut query = GpuQuery::new(gpu()).unwrap();
    let question = GpuQuestion::pair(&a.model, &b.model, &Pose::IDENTITY);
    let truth = truth(&a, &b, &Pose::IDENTITY);
    assert_eq!(truth.len(), (SLATS * SLATS) as usize);
    // After the first answer so many are expected.
    for _ in 0..2 {
        assert_eq!(query.all(&question).unwrap(), truth);
    }
    let (device, queue) = (gpu().device(), gpu().queue());
    let bytes = size_of_val(&truth[..]) as u64;
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(query.hits_buffer(), 0, &copy, 0, bytes);
    queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let hits = copy.get_mapped_range(..).unwrap();
    let truth: Vec<u32> = truth.iter().flat_map(|pair| [pair.a, pair.b]).collect();
    let hits = hits.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap()));
    assert!(hits.eq(truth));
}
