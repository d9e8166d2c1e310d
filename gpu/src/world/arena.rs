//! The meshes of a world in shared buffers, each once, however many bodies have it.

use super::placing::place;
use crate::buffer::Usage;
use crate::layout::{Body, Corner};
use crate::model::{below, reference};
use crate::schedule::Schedule;
use crate::sequence::Sequence;
use crate::totals::count;
use crate::{Gpu, GpuError, GpuModel};
use bytemuck::Pod;
use pfront_core::{Aabb, Bvh, MeshError, Node, Pose};
use wgpu::{Buffer, CommandEncoder};

/// A first front pairs at most so many nodes: one level on, that is the larger starting front of the paper's GPU algorithm.
pub(super) const MOST_PAIRS: usize = 4096;

/// All meshes.
#[derive(Debug)]
pub(super) struct Arena {
    /// Changes with the buffers.
    pub(super) id: u64,
    pub(super) nodes: Array,
    pub(super) corners: Array,
    pub(super) order: Array,
    pub(super) meshes: Vec<ArenaMesh>,
    /// The most triangles of a leaf.
    pub(super) leaf_size: u32,
    /// Meshes whose positions have been written and whose boxes do not know it.
    pub(super) moved: Vec<usize>,
}

/// An array on the device that grows.
#[derive(Debug)]
pub(super) struct Array {
    what: &'static str,
    buffer: Option<Buffer>,
    used: u64,
}

/// A mesh, and where its runs begin.
#[derive(Debug)]
pub(super) struct ArenaMesh {
    pub(super) first_node: u32,
    pub(super) first_slot: u32,
    /// Nodes and slots that its runs have room for.
    room: [u32; 2],
    /// Ids that it takes: as many as it has nodes or triangles.
    pub(super) ids: u32,
    /// `None` if it is empty.
    pub(super) bounds: Option<Aabb>,
    vertices: usize,
    /// The depth of its BVH.
    depth: u32,
    /// The nodes of each of the first levels, leaves above it included, as a front holds them.
    levels: Vec<Vec<u32>>,
    schedule: Schedule,
    /// If its vertices have moved.
    motion: Option<Motion>,
}

/// The buffers and passes that move a mesh.
#[derive(Debug)]
struct Motion {
    positions: Buffer,
    refit: Sequence,
}

impl Arena {
    pub(super) fn new() -> Self {
        let array = |what| Array { what, buffer: None, used: 0 };
        Self {
            id: GpuModel::next_id(),
            nodes: array("the nodes"),
            corners: array("the triangles"),
            order: array("the order of the triangles"),
            meshes: Vec::new(),
            leaf_size: 1,
            moved: Vec::new(),
        }
    }

    /// Adds a mesh. After an error the arena is of no use.
    ///
    /// # Complexity
    /// O(triangles), and where buffers grow, a copy of all on the device.
    pub(super) fn add(&mut self, gpu: &Gpu, bvh: &Bvh<'_>) -> Result<(), GpuError> {
        let added = self.upload(gpu, bvh, None)?;
        self.meshes.push(added);
        Ok(())
    }

    /// Puts another tree or shape in the place of a mesh, or behind all others where it is larger. After an error the arena is
    /// of no use.
    ///
    /// # Complexity
    /// As [`Arena::add`].
    pub(super) fn set_mesh(
        &mut self,
        gpu: &Gpu,
        number: usize,
        bvh: &Bvh<'_>,
    ) -> Result<(), GpuError> {
        self.moved.retain(|&moved| moved != number);
        self.meshes[number] = self.upload(gpu, bvh, Some(number))?;
        Ok(())
    }

    /// Uploads a mesh into the runs of another, if it fits there, or behind all.
    fn upload(
        &mut self,
        gpu: &Gpu,
        bvh: &Bvh<'_>,
        old: Option<usize>,
    ) -> Result<ArenaMesh, GpuError> {
        GpuModel::check_precision(bvh.mesh())?;
        let (node_count, slots) = (bvh.nodes().len() as u32, bvh.order().len() as u32);
        let old = old.map(|number| &self.meshes[number]);
        let place = old.filter(|old| node_count <= old.room[0] && slots <= old.room[1]);
        let place = place.map(|old| (old.first_node, old.first_slot, old.room));
        if place.is_none() && !self.moved.is_empty() {
            // Where buffers grow, what refits the meshes that are there is lost.
            gpu.checked(|| {
                let mut encoder = gpu.device().create_command_encoder(&Default::default());
                self.record_refits(&mut encoder);
                gpu.queue().submit([encoder.finish()]);
                Ok(())
            })?;
            self.moved.clear();
        }
        let (first_node, first_slot, room) = match place {
            Some(place) => place,
            None => {
                let first_node = self.nodes.used / size_of::<Node>() as u64;
                let first_slot = self.order.used / size_of::<u32>() as u64;
                GpuModel::check_size(first_slot as usize + bvh.order().len())?;
                (first_node as u32, first_slot as u32, [node_count, slots])
            }
        };
        let shifted = bvh.nodes().iter().map(|node| {
            let shift = if node.is_leaf() { first_slot } else { first_node };
            Node { first: node.first + shift, ..*node }
        });
        let nodes: Vec<_> = shifted.collect();
        let mesh = bvh.mesh();
        let corner = |vertex: u32| Corner { position: mesh.shadow()[vertex as usize], vertex };
        let triangles = bvh.order().iter().map(|&t| mesh.triangles()[t as usize]);
        let corners: Vec<_> = triangles.flat_map(|t| t.map(corner)).collect();
        if place.is_some() {
            self.nodes.write(gpu, first_node, &nodes);
            self.corners.write(gpu, 3 * first_slot, &corners);
            self.order.write(gpu, first_slot, bvh.order());
        } else {
            // Every one of them, whichever grows.
            let grown = [
                self.nodes.append(gpu, &nodes)?,
                self.corners.append(gpu, &corners)?,
                self.order.append(gpu, bvh.order())?,
            ];
            if grown.contains(&true) {
                self.id = GpuModel::next_id();
                self.meshes.iter_mut().for_each(|mesh| mesh.motion = None);
            }
        }
        count(&gpu.counted().uploads);
        self.leaf_size = nodes.iter().map(|node| node.count).fold(self.leaf_size, u32::max);
        Ok(ArenaMesh {
            first_node,
            first_slot,
            room,
            ids: nodes.len().max(bvh.order().len()) as u32,
            bounds: bvh.aabb(),
            vertices: mesh.shadow().len(),
            depth: bvh.depth() as u32,
            levels: levels(bvh.nodes(), first_node),
            schedule: Schedule::new(bvh.nodes()),
            motion: None,
        })
    }

    /// A body that has a mesh, within the bounds that this has by now.
    pub(super) fn place(&self, mesh: u32, pose: &Pose) -> Body {
        let ArenaMesh { first_node, first_slot, bounds, .. } = self.meshes[mesh as usize];
        Body { first_node, first_slot, ..place(pose, &bounds.unwrap_or(Aabb::EMPTY)) }
    }

    /// Bytes of device memory.
    pub(super) fn bytes(&self) -> u64 {
        let motions = self.meshes.iter().filter(|mesh| mesh.motion.is_some());
        let moving = |mesh: &ArenaMesh| mesh.schedule.bytes() + 12 * mesh.vertices as u64;
        let arrays = [&self.nodes, &self.corners, &self.order];
        arrays.iter().filter_map(|array| array.buffer.as_ref()).map(Buffer::size).sum::<u64>()
            + motions.map(moving).sum::<u64>()
    }

    /// Moves the vertices of a mesh with the next submission.
    pub(super) fn set_positions(
        &mut self,
        gpu: &Gpu,
        number: usize,
        positions: &[[f32; 3]],
    ) -> Result<(), GpuError> {
        let mesh = &mut self.meshes[number];
        let (expected, found) = (mesh.vertices, positions.len());
        if expected != found {
            return Err(MeshError::VertexCount { expected, found }.into());
        }
        let (Some(nodes), Some(corners)) = (&self.nodes.buffer, &self.corners.buffer) else {
            return Ok(());
        };
        let motion = match &mut mesh.motion {
            Some(motion) => motion,
            none => {
                let bytes = size_of_val(positions) as u64;
                let buffer = gpu.buffer("the positions", bytes, Usage::Input)?;
                let schedule = &mesh.schedule;
                let refit = schedule.sequence(gpu, [nodes, corners], mesh.first_node, &buffer)?;
                none.insert(Motion { positions: buffer, refit })
            }
        };
        gpu.queue().write_buffer(&motion.positions, 0, bytemuck::cast_slice(positions));
        // The box of all vertices only bounds what a pose may do.
        mesh.bounds = mesh.bounds.map(|_| Aabb::of(positions));
        if !self.moved.contains(&number) {
            self.moved.push(number);
        }
        Ok(())
    }

    /// Records the refits of the meshes that have moved: once it is submitted, none has.
    pub(super) fn record_refits(&self, encoder: &mut CommandEncoder) {
        let motions = self.moved.iter().filter_map(|&number| self.meshes[number].motion.as_ref());
        motions.for_each(|motion| motion.refit.run(encoder, None));
    }
}

impl Array {
    /// The buffer, if it has any contents.
    pub(super) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }

    /// Writes elements over others, from the one of this number on, with the next submission.
    fn write<T: Pod>(&self, gpu: &Gpu, first: u32, contents: &[T]) {
        if let Some(buffer) = &self.buffer
            && !contents.is_empty()
        {
            let at = u64::from(first) * size_of::<T>() as u64;
            gpu.queue().write_buffer(buffer, at, bytemuck::cast_slice(contents));
        }
    }

    /// Adds elements with the next submission; returns whether they are in another buffer now.
    fn append<T: Pod>(&mut self, gpu: &Gpu, contents: &[T]) -> Result<bool, GpuError> {
        let contents: &[u8] = bytemuck::cast_slice(contents);
        let end = self.used + contents.len() as u64;
        if contents.is_empty() {
            return Ok(false);
        }
        let old = self.buffer.take_if(|buffer| buffer.size() < end);
        let grows = self.buffer.is_none();
        if grows {
            // With room to spare if there is more to come, and the device can bind that much.
            let spare = old.as_ref().map_or(0, |old| old.size() / 2);
            let roomy = gpu.buffer(self.what, end + spare, Usage::List);
            let new = roomy.or_else(|_| gpu.buffer(self.what, end, Usage::List))?;
            if let Some(old) = &old {
                gpu.checked(|| {
                    let mut encoder = gpu.device().create_command_encoder(&Default::default());
                    encoder.copy_buffer_to_buffer(old, 0, &new, 0, self.used);
                    gpu.queue().submit([encoder.finish()]);
                    Ok(())
                })?;
            }
            self.buffer = Some(new);
        }
        if let Some(buffer) = &self.buffer {
            gpu.queue().write_buffer(buffer, self.used, contents);
        }
        self.used = end;
        Ok(grows)
    }
}

impl ArenaMesh {
    /// The nodes of a level, or of the last one there is, as a front holds them; and how many levels
    /// lie below, of which a leaf on its own counts as one.
    pub(super) fn level(&self, level: usize) -> (&[u32], u32) {
        let level = level.min(self.levels.len().saturating_sub(1));
        let nodes = self.levels.get(level).map_or(&[][..], Vec::as_slice);
        (nodes, (self.depth - level as u32).max(1))
    }
}

/// From the root on, as long as a level paired with its own does not exceed [`MOST_PAIRS`].
fn levels(nodes: &[Node], first_node: u32) -> Vec<Vec<u32>> {
    let mut level: Vec<u32> = (0..nodes.len().min(1) as u32).collect();
    let mut levels = Vec::new();
    while !level.is_empty() && level.len().pow(2) <= MOST_PAIRS {
        levels.push(level.iter().map(|&node| reference(nodes, node) + first_node).collect());
        let next = below(nodes, &level);
        if next.len() == level.len() {
            break;
        }
        level = next;
    }
    levels
}
