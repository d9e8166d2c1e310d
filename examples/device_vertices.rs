//! A mesh whose vertices are on the device already, as those of a skinning pass or of a simulation are: its positions never pass
//! through the host.
//!
//! `cargo run --release --features gpu --example device_vertices -- [FILES]...` asks which triangles of a mesh meet, in two shapes
//! that take turns: a sheet that folds, or those of two files. Told are the median times of a frame, refit included, with positions
//! from the host and from a buffer of the device, whose pairs are compared.

use pfront::gpu::wgpu::util::{BufferInitDescriptor, DeviceExt};
use pfront::gpu::wgpu::{Buffer, BufferUsages};
use pfront::gpu::{Deforming, Gpu, GpuQuery, GpuQuestion, VertexBuffer};
use pfront::{Aabb, BuildOptions, Mesh};
use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

/// The words of a vertex: its position, and what a renderer keeps beside it.
const STRIDE: usize = 8;

type Shapes = ([Vec<[f32; 3]>; 2], Vec<[u32; 3]>);

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let (shapes, triangles) = match files.as_slice() {
        [first, second] => {
            let [first, second] =
                [first, second].map(|file| pfront_files::read_f32(Path::new(file)));
            let (first, second) = (first?, second?);
            ([first.positions, second.positions], first.triangles)
        }
        [] => sheet(if cfg!(debug_assertions) { 20 } else { 215 }),
        _ => return Err("give two files, or none".into()),
    };
    run(shapes, &triangles, if cfg!(debug_assertions) { 3 } else { 200 })
}

/// Asks so many times about either shape, by both ways.
fn run(
    shapes: [Vec<[f32; 3]>; 2],
    triangles: &[[u32; 3]],
    rounds: usize,
) -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::new()?;
    let options = BuildOptions { leaf_size: Deforming::LEAF_SIZE, ..BuildOptions::default() };
    let mut mesh = Deforming::build(&gpu, Mesh::new(&shapes[0], triangles)?, &options)?;
    let mut query = GpuQuery::new(&gpu)?;
    let buffers = shapes.each_ref().map(|shape| skinned(&gpu, shape));
    let mut host = Vec::new();
    let mut by_host = [Vec::new(), Vec::new()];
    for at in (0..2).cycle().take(2 * rounds) {
        let start = Instant::now();
        mesh.set_positions(&shapes[at])?;
        query.all(&GpuQuestion::itself(&mesh))?;
        host.push(start.elapsed());
        by_host[at] = query.all(&GpuQuestion::itself(&mesh))?.to_vec();
    }
    // The box bounds how far a pose may take the mesh; here it stays where it is.
    let bounds = Aabb { min: [-1e6; 3], max: [1e6; 3] };
    let stride = 4 * STRIDE as u64;
    let mut device = Vec::new();
    for at in (0..2).cycle().take(2 * rounds) {
        let start = Instant::now();
        mesh.set_positions_from(&VertexBuffer { buffer: &buffers[at], offset: 0, stride, bounds })?;
        let by_device = query.all(&GpuQuestion::itself(&mesh))?;
        device.push(start.elapsed());
        assert_eq!(by_device, by_host[at]);
    }
    let [host, device] = [host, device].map(median);
    println!(
        "{} triangles: {host:.1?} a frame with positions from the host, {device:.1?} from the device",
        triangles.len()
    );
    Ok(())
}

/// Vertices in a buffer of the device, as a skinning pass leaves them.
fn skinned(gpu: &Gpu, positions: &[[f32; 3]]) -> Buffer {
    let mut words = vec![0.0f32; positions.len() * STRIDE];
    for (vertex, position) in words.chunks_exact_mut(STRIDE).zip(positions) {
        vertex[..3].copy_from_slice(position);
    }
    gpu.device().create_buffer_init(&BufferInitDescriptor {
        label: Some("skinned vertices"),
        contents: bytemuck::cast_slice(&words),
        usage: BufferUsages::STORAGE,
    })
}

/// A sheet of n by n squares that is folded over, by two angles.
fn sheet(n: u32) -> Shapes {
    let grid = || (0..=n).flat_map(|y| (0..=n).map(move |x| [x, y].map(|k| k as f32 / n as f32)));
    let folded = |angle: f32| -> Vec<[f32; 3]> {
        let fold = |[x, y]: [f32; 2]| match x - 0.5 {
            beyond @ 0.0.. => {
                [0.5 + beyond * angle.cos(), y, beyond * angle.sin() + 0.01 * (40.0 * y).sin()]
            }
            _ => [x, y, 0.01 * (50.0 * x).cos()],
        };
        grid().map(fold).collect()
    };
    let square = |x: u32, y: u32| {
        let a = y * (n + 1) + x;
        let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
        [[a, b, d], [a, d, c]]
    };
    let triangles = (0..n).flat_map(|y| (0..n).flat_map(move |x| square(x, y))).collect();
    ([folded(3.0), folded(3.13)], triangles)
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

#[cfg(test)]
mod tests {
    #[test]
    fn both_ways_find_the_same_pairs() {
        let (shapes, triangles) = super::sheet(20);
        super::run(shapes, &triangles, 2).unwrap();
    }
}
