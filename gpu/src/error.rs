//! Why a GPU cannot answer, and what to do about it.

use crate::layout::{LARGEST_DISTANCE, LARGEST_POSED};
use pfront_core::pose::PoseError;
use pfront_core::{CapacityError, MeshError};

/// Why a call could not answer. Each message says what would help.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter.
    #[error("no GPU adapter: {reason}")]
    NoAdapter {
        /// The message of wgpu and what would help, or the environment variable that is wrong.
        reason: String,
    },
    /// The adapter gave no device.
    #[error(
        "the adapter {adapter} gave no device: {reason}. Choose another with WGPU_ADAPTER_NAME"
    )]
    NoDevice {
        /// The name of the adapter.
        adapter: String,
        /// The message of wgpu.
        reason: String,
    },
    /// The device's limits are below those of WebGPU.
    #[error(
        "the device allows {available} for {limit}, and {needed} are needed: request it with at least \
         the default limits of WebGPU, or choose another adapter"
    )]
    Limit {
        /// The limit, by its name in wgpu.
        limit: &'static str,
        /// The value that the passes need.
        needed: u64,
        /// The value of the device.
        available: u64,
    },
    /// A buffer of a model or a query would be larger than the device can bind.
    #[error(
        "{what} take {needed} bytes, and the device binds at most {available} at once: divide the \
         mesh, lower the budget, or request a device with the limits of its adapter"
    )]
    TooLarge {
        /// Name of the buffer that is too large.
        what: &'static str,
        /// Its size.
        needed: u64,
        /// The most the device can bind.
        available: u64,
    },
    /// The device has no memory left.
    #[error("no device memory for {bytes} bytes: drop models, or lower the budget of the queries")]
    OutOfMemory {
        /// The size that was asked for.
        bytes: u64,
    },
    /// The host has no memory left for a list.
    #[error(
        "no memory for a list of {needed} bytes: ask for counts, or about fewer pairs at a time"
    )]
    Memory {
        /// The size of the list.
        needed: usize,
    },
    /// The device is gone, with everything on it.
    #[error(
        "the device is lost: {reason}. Make a new `Gpu`, upload the models again and ask again"
    )]
    DeviceLost {
        /// The message of wgpu.
        reason: String,
    },
    /// A buffer could not be mapped, and the device has not said that it is lost.
    #[error("a buffer of the device could not be mapped: {reason}. Ask again")]
    Map {
        /// The message of wgpu.
        reason: String,
    },
    /// The device did something that it should not have.
    #[error("the device failed: {reason}. Update its driver, or choose another adapter")]
    Device {
        /// The message of wgpu, or the fault that was found.
        reason: String,
    },
    /// A model was uploaded through another `Gpu`.
    #[error("the model was uploaded through another Gpu: upload it through the one of the query")]
    OtherDevice,
    /// The mesh is in f64, and the question is not about the shadows of two.
    #[error(
        "a mesh is in f64, about which GPUs answer for two meshes only, by their shadows: ask on the CPU"
    )]
    InF64,
    /// Shadows that are not those of the models.
    #[error(
        "the shadows are not those of these models: a number is NaN, infinite, a negative error, or takes a model out of \
         range. Take them from the query about the same meshes"
    )]
    Shadows,
    /// No GPU answers about pairs within this distance.
    #[error(
        "a GPU answers about pairs within at most {LARGEST_DISTANCE:e} of each other, of two models, and was asked for {distance:e}: \
         ask on the CPU"
    )]
    Distance {
        /// The distance.
        distance: f32,
    },
    /// The flag of [`GpuQuery::set_cancel`](crate::GpuQuery::set_cancel) or
    /// [`World::set_cancel`](crate::World::set_cancel) was set.
    #[error("the question was cancelled")]
    Cancelled,
    /// The commands that were recorded have not been submitted.
    #[error("submit the encoder that the query was recorded into before reading its answer")]
    NotSubmitted,
    /// A budget is below the minimum.
    #[error("a budget of {bytes} bytes is below the minimum of {least}")]
    Budget {
        /// The budget.
        bytes: u64,
        /// The smallest one.
        least: u64,
    },
    /// New positions do not fit the mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A [`VertexBuffer`](crate::VertexBuffer) cannot hold the vertices of the mesh.
    #[error("the buffer of vertices cannot be read: {reason}")]
    VertexBuffer {
        /// The fault, with the numbers that do not fit.
        reason: String,
    },
    /// A vertex that came from a [`VertexBuffer`](crate::VertexBuffer) is not where it was said to be.
    #[error(
        "vertex {vertex} is not in the box that was promised for the buffer of vertices, or not finite: set positions again, with a \
         box that holds them"
    )]
    OutsideBox {
        /// The first such vertex.
        vertex: u32,
    },
    /// A mesh cannot be posed so.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// A mesh that is posed has coordinates of more than half the range of f32.
    #[error(
        "coordinate {axis} of the mesh goes beyond ±{LARGEST_POSED:e}, where a GPU cannot pose it: \
         scale the mesh down, or ask on the CPU"
    )]
    Coordinate {
        /// The coordinate, 0 to 2.
        axis: usize,
    },
    /// There is no such body.
    #[error("there is no body {body}; the world has {bodies}")]
    NoBody {
        /// The number of the body asked for.
        body: u32,
        /// How many there are.
        bodies: u32,
    },
    /// There is no such mesh.
    #[error("there is no mesh {mesh}; the world has {meshes}")]
    NoMesh {
        /// The number of the mesh asked for.
        mesh: u32,
        /// How many there are.
        meshes: u32,
    },
    /// A buffer of the core was too small.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
}
