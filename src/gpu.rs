//! The queries on a GPU: the same pairs, to the bit, through wgpu on Vulkan, Metal, Direct3D 12 or WebGPU.
//!
//! A [`Gpu`] is a device of this machine or of the caller's; a [`GpuModel`] is the BVH of a
//! [`crate::Model`] in its memory, a [`Deforming`] one whose vertices move there, by positions from the host or from a
//! [`VertexBuffer`] of the caller's. A [`GpuQuery`] asks about them for those
//! who mind buffers and submissions themselves; with [`crate::Executor::gpu`] the queries of this crate do.
//!
//! # Examples
//! ```no_run
//! use pfront::Pose;
//! use pfront::gpu::{Deforming, Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion};
//! # fn demo(body: pfront::Model, cloth: pfront::Model) -> Result<(), GpuError> {
//! let gpu = Gpu::new()?;
//! let body = GpuModel::new(&gpu, body.bvh())?;
//! let mut query = GpuQuery::new(&gpu)?;
//! for frame in 0..4 {
//!     let a_from_b = Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]);
//!     let pairs = query.all(&GpuQuestion::pair(&body, &body, &a_from_b))?; // sorted
//!     println!("frame {frame}: {} pairs", pairs.len());
//! }
//!
//! // A mesh that deforms goes there once; then only its vertices do.
//! let mut moving = Deforming::new(&gpu, cloth.bvh())?;
//! # let frames: [Vec<[f32; 3]>; 0] = [];
//! for positions in &frames {
//!     moving.set_positions(positions)?;
//!     println!("{} folds", query.all(&GpuQuestion::itself(&moving))?.len());
//! }
//! # Ok(()) }
//! ```
//!
//! # Which adapter
//! [`Gpu::new`] takes the best one. A machine without a GPU needs a driver that computes on the CPU,
//! such as lavapipe (`apt-get install mesa-vulkan-drivers libvulkan1`); with no adapter at all it is
//! an error, which says so.

#[doc(inline)]
pub use pfront_gpu::*;
