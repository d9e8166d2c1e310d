//! A mesh and its BVH on the device.

use crate::GpuError;
use crate::buffer::Usage;
use crate::device::release;
use crate::gpu::Gpu;
use crate::layout::Corner;
use crate::refit::Refit;
use crate::source::Source;
use crate::totals::count;
use crate::wear::Wear;
use pfront_core::{Aabb, Bvh, Mesh, Node};
use pfront_shaders::constants::{LEAF, LEAF_SHIFT};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The most nodes of one level that the first pass of a query pairs with those of the other tree: both
/// together give 4^7 node pairs at most, the larger starting front of the paper's GPU algorithm.
pub(crate) const MOST_SEEDS: usize = 128;

/// A mesh and its BVH in device memory.
///
/// Nodes are the core's, byte for byte. Triangles are stored by their corners, in the order of the
/// leaves: the triangles of a leaf are one run of memory, where indices into vertices would be three
/// loads that wait for each other.
///
/// Takes 52 bytes a triangle and 32 a node (about 21 a triangle with the default leaf size), and 12 a triangle and a vertex more
/// until the device has gathered the corners.
#[derive(Debug)]
pub struct GpuModel {
    pub(crate) id: u64,
    /// The device it is on.
    pub(crate) device: u64,
    pub(crate) nodes: wgpu::Buffer,
    pub(crate) corners: wgpu::Buffer,
    pub(crate) order: wgpu::Buffer,
    pub(crate) seeds: wgpu::Buffer,
    pub(crate) seed_count: u32,
    /// The root as an entry of a front.
    pub(crate) root: u32,
    /// The depth of the deepest node.
    pub(crate) depth: u32,
    /// The same below the seeds.
    pub(crate) depth_below_seeds: u32,
    /// The most triangles of a leaf.
    pub(crate) leaf_size: u32,
    /// `None` for an empty mesh.
    pub(crate) bounds: Option<Aabb>,
    /// If the host has not seen the positions: which of them are not where they were said to be.
    pub(crate) outside: Option<Outside>,
    /// The refit that its boxes are of, if it moves.
    pub(crate) refit: Option<Arc<Refit>>,
    /// Whether what is there is the shadow of a mesh in f64.
    pub(crate) is_shadow: bool,
    /// Box tests of queries about it.
    pub(crate) wear: Arc<Wear>,
}

/// The word in which a device tells whether positions that only it has seen are where they were said to be.
#[derive(Clone, Debug)]
pub(crate) struct Outside {
    /// One number: that of all vertices less that of the first outside of its box, or 0.
    pub(crate) buffer: wgpu::Buffer,
    /// The number of all vertices.
    pub(crate) vertices: u32,
}

impl Outside {
    pub(crate) fn new(gpu: &Gpu, source: &Source) -> Result<Self, GpuError> {
        let buffer = gpu.buffer("the vertex outside", 4, Usage::List)?;
        Ok(Self { buffer, vertices: source.vertices as u32 })
    }
}

impl GpuModel {
    /// Refuses a mesh of whose positions a device would know the shadow alone.
    pub(crate) fn check_precision(mesh: Mesh<'_>) -> Result<(), GpuError> {
        if mesh.is_f64() { Err(GpuError::InF64) } else { Ok(()) }
    }

    /// Uploads a mesh with its BVH; of a mesh in f64 its shadow, for [`GpuQuestion::shadows`](crate::GpuQuestion::shadows).
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if an array does not fit in a binding, [`GpuError::OutOfMemory`].
    ///
    /// # Complexity
    /// O(triangles).
    pub fn new(gpu: &Gpu, bvh: Bvh<'_>) -> Result<Self, GpuError> {
        Self::of_source(gpu, bvh, &Source::new(gpu, bvh.mesh())?)
    }

    /// The same of a mesh that is there.
    pub(crate) fn of_source(gpu: &Gpu, bvh: Bvh<'_>, source: &Source) -> Result<Self, GpuError> {
        Self::check_size(bvh.order().len())?;
        let (level, seeds) = seeds(bvh.nodes());
        let order = gpu.upload("the order of the triangles", bvh.order(), Usage::Input)?;
        let depth = bvh.depth() as u32;
        count(&gpu.counted().uploads);
        Ok(Self {
            id: Self::next_id(),
            device: gpu.id(),
            nodes: gpu.upload("the nodes", bvh.nodes(), Usage::Input)?,
            corners: source.corners(gpu, &order)?,
            order,
            seeds: gpu.upload("the seeds", &seeds, Usage::Input)?,
            seed_count: seeds.len() as u32,
            root: bvh.aabb().map_or(LEAF, |_| reference(bvh.nodes(), 0)),
            depth,
            depth_below_seeds: depth - level,
            leaf_size: bvh.nodes().iter().map(|node| node.count).fold(1, u32::max),
            bounds: bvh.aabb(),
            is_shadow: bvh.mesh().is_f64(),
            outside: None,
            refit: None,
            wear: Arc::default(),
        })
    }

    /// An identity for another model.
    pub(crate) fn next_id() -> u64 {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        NEXT.fetch_add(1, Ordering::Relaxed)
    }

    /// Whether the slots of so many triangles leave room for the size of a leaf.
    pub(crate) fn check_size(triangles: usize) -> Result<(), GpuError> {
        let slots = triangles as u64;
        if slots >= 1 << LEAF_SHIFT {
            let bytes = size_of::<[Corner; 3]>() as u64;
            let (needed, available) = (slots * bytes, (1 << LEAF_SHIFT) * bytes);
            return Err(GpuError::TooLarge { what: "the triangles", needed, available });
        }
        Ok(())
    }

    /// Whether it was uploaded through `gpu` or a copy of it.
    #[must_use]
    pub fn is_on(&self, gpu: &Gpu) -> bool {
        self.device == gpu.id()
    }

    /// Bytes of device memory the model holds.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.buffers().map(wgpu::Buffer::size).iter().sum()
    }

    fn buffers(&self) -> [&wgpu::Buffer; 4] {
        [&self.nodes, &self.corners, &self.order, &self.seeds]
    }
}

impl Drop for GpuModel {
    fn drop(&mut self) {
        release(self.buffers().into_iter().chain(self.outside.as_ref().map(|own| &own.buffer)));
    }
}

/// The nodes of the deepest level that has at most [`MOST_SEEDS`], leaves above it included, and its
/// depth.
fn seeds(nodes: &[Node]) -> (u32, Vec<u32>) {
    let mut level = 0;
    let mut seeds: Vec<u32> = (0..nodes.len().min(1) as u32).collect();
    loop {
        let next = below(nodes, &seeds);
        if next.len() == seeds.len() || next.len() > MOST_SEEDS {
            return (level, seeds);
        }
        (level, seeds) = (level + 1, next);
    }
}

/// The nodes a level below others, of which leaves stay.
pub(crate) fn below(nodes: &[Node], level: &[u32]) -> Vec<u32> {
    let children = |&index: &u32| match &nodes[index as usize] {
        leaf if leaf.is_leaf() => index..index + 1,
        inner => inner.first..inner.first + 2,
    };
    level.iter().flat_map(children).collect()
}

/// A node as a front holds it.
pub(crate) fn reference(nodes: &[Node], index: u32) -> u32 {
    let node = &nodes[index as usize];
    if node.is_leaf() { index | LEAF } else { node.first }
}
