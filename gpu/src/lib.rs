//! The queries of [`pfront_core`] on any GPU: the same answer, to the bit, through wgpu.
//!
//! Zhang & Kim (TVCG 2014, section 4) traverse on a GPU in passes of bounded depth: a pass takes a
//! front of node pairs, descends at most d_b levels, and leaves what is unfinished to the next; triangle
//! tests run last. Here
//! - the first pass pairs the nodes of one level of both trees, as their larger starting front does;
//! - a pass descends in workgroup memory and adds what is left to the next front with one atomic
//!   operation a workgroup; four invocations share a node pair;
//! - counts stay on the device and the number of passes follows from the depth of the trees, so that a
//!   query is one submission;
//! - a triangle pair is decided in f32 where that is certain, in integers where it is not, and the few
//!   that do not fit come back to the CPU. Nothing else needs it.
//!
//! A [`GpuModel`] is a mesh with its BVH on the device, a [`Deforming`] one whose vertices move; a
//! [`GpuQuery`] owns the lists that a [`GpuQuestion`] needs, within a [`Budget`]; when they are full, the query goes on
//! in parts. A [`World`] owns many posed bodies that share meshes as well.
//!
//! Natively all that waits blocks. In a browser nothing may: there [`Gpu::open`] and the methods named `read` are awaited, verbs
//! are submitted and read, and [`Gpu::settle`] tells what was wrong with calls that return at once.

mod ahead;
mod buffer;
mod build;
mod check;
mod clock;
mod deforming;
mod device;
mod engine;
mod error;
mod gpu;
mod groups;
mod layout;
mod lists;
mod memory;
mod model;
mod moving;
mod parameters;
mod pass;
mod probe;
mod query;
mod read;
mod refit;
mod report;
mod results;
mod runner;
mod schedule;
mod sequence;
mod settings;
mod source;
mod staging;
mod task;
#[cfg(test)]
mod tests;
mod totals;
mod untold;
mod wear;
mod world;

pub use clock::Timing;
pub use deforming::{Deforming, VertexBuffer};
pub use error::GpuError;
pub use gpu::Gpu;
pub use model::GpuModel;
pub use pass::Arithmetic;
pub use query::{GpuQuery, GpuQuestion};
pub use report::GpuReport;
pub use settings::{Budget, GpuSettings};
pub use task::GpuVerb;
pub use totals::GpuTotals;
pub use wgpu;
pub use world::{BodyPair, World, WorldAnswer};
