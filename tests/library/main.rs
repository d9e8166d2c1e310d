//! Tests of the library as its users see it, in one program: each program links the whole library, and has a copy of what is generic
//! in it. Beside it are tests that need a process of their own: an allocator, threads that are counted, ways to end.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod api;
mod background;
mod blob;
mod cancel;
mod contacts;
mod distance;
#[cfg(all(target_arch = "x86_64", feature = "threads"))]
mod environment;
mod executors;
mod fans;
mod impacts;
mod in_f64;
mod model;
mod one_ring;
#[cfg(feature = "threads")]
mod plan;
mod predicates;
mod predicates_f64;
mod queries;
mod questions;
mod relation;
mod scene;
mod scene_history;
mod scene_impacts;
mod scene_split;
mod segment;
mod side_by_side;
mod spheres;
mod still;
#[cfg(feature = "threads")]
mod threads;
#[cfg(feature = "gpu")]
mod wear;
mod within;

use pfront::Executor;

/// The calling thread, threads of each number, and a GPU.
#[cfg_attr(not(feature = "threads"), expect(unused_variables, reason = "there are no threads"))]
fn each_executor(threads: &[usize]) -> Vec<Executor> {
    let mut all = vec![Executor::sequential()];
    #[cfg(feature = "threads")]
    all.extend(threads.iter().map(|&number| Executor::threads(number)));
    #[cfg(feature = "gpu")]
    {
        let gpu = pfront::gpu::Gpu::new().unwrap();
        all.push(Executor::gpu(&gpu, gpu.settings()));
    }
    all
}

/// Pairs of crossing triangles in a row, in an order of their own, if the stride and their number have no factor in common.
fn crosses(number: u64, stride: u64, shift: f32) -> Vec<[f32; 3]> {
    const CROSS: [[f32; 3]; 6] = [
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.0, 0.5, 0.0],
        [0.1, 0.1, -0.1],
        [0.1, 0.1, 0.2],
        [0.2, 0.3, 0.2],
    ];
    let places = (0..number).map(|part| (part * stride % number) as f32 + shift);
    places.flat_map(|place| CROSS.map(|[x, y, z]| [x + place, y, z])).collect()
}
