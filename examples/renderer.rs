//! A renderer and `pfront` on one device. Questions go to the queue like draw calls, and an answer is read in a later
//! frame, when it is there: neither the CPU nor the renderer waits for it.
//!
//! `cargo run --release --example renderer --features gpu`

use pfront::gpu::{Gpu, wgpu};
use pfront::{Batch, Executor, Model, PairLists, Pose, Ticket};
use std::{error::Error, sync::Arc, time::Duration};

fn main() -> Result<(), Box<dyn Error>> {
    // The device of the renderer, which here draws to a texture instead of a window.
    let backends = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let adapter = wgpu::Instance::new(backends).request_adapter(&Default::default());
    let adapter = pollster::block_on(adapter)?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 640, height: 480, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());

    // Devices and queues of wgpu are handles: clones share them. An executor is made once, for all questions.
    let gpu = Gpu::from_device(device.clone(), queue.clone())?;
    let executor = Executor::gpu(&gpu, gpu.settings());
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let model = Arc::new(Model::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?);
    // A batch that is kept keeps its models on the device.
    let (mut batch, mut found) = (Batch::new(), Vec::new());
    let mut asked: Option<(u32, Ticket<PairLists>)> = None;

    for frame in 0..60 {
        // An answer that is there is taken; one that is not stays on its way.
        if let Some((since, mut ticket)) = asked.take() {
            match ticket.try_read()? {
                Some(lists) => found.push((since, lists.pairs().len())),
                None => asked = Some((since, ticket)),
            }
        }
        // The next question goes before the drawing, so that the device answers it first.
        if asked.is_none() {
            batch.clear();
            let a_from_b = Pose::from_translation([0.03 * frame as f32, 0.0, 0.0]);
            batch.pair(&model, &model, a_from_b)?;
            asked = Some((frame, batch.all(&executor)?));
        }
        draw(&device, &queue, &view, found.last().is_some_and(|&(_, pairs)| pairs > 0));
        // Stands for the time until the screen wants the next frame.
        std::thread::sleep(Duration::from_millis(5));
    }
    if let Some((since, ticket)) = asked {
        found.push((since, ticket.read()?.pairs().len()));
    }
    found.iter().for_each(|(frame, pairs)| println!("frame {frame}: {pairs} pairs"));
    assert!(found[0].1 > 0); // Frame 0, in which both are in the same place.
    Ok(())
}

/// Fills the picture, in red if something meets.
fn draw(device: &wgpu::Device, queue: &wgpu::Queue, view: &wgpu::TextureView, meets: bool) {
    let load = wgpu::LoadOp::Clear(if meets { wgpu::Color::RED } else { wgpu::Color::GREEN });
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    let target =
        wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
    let color_attachments = &[Some(target)];
    let mut encoder = device.create_command_encoder(&Default::default());
    let pass = wgpu::RenderPassDescriptor { color_attachments, ..Default::default() };
    drop(encoder.begin_render_pass(&pass));
    queue.submit([encoder.finish()]);
}

#[test]
fn runs() -> Result<(), Box<dyn Error>> {
    main()
}
