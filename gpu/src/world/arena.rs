//! All bodies on the device: one mesh and one forest of trees, each body with its own run of both.

use crate::clock::Clock;
use crate::engine::Entry;
use crate::layout::{Corner, Posing};
use crate::memory::Usage;
use crate::model::{below, reference};
use crate::parameters::Parameters;
use crate::schedule::Schedule;
use crate::sequence::{Sequence, groups_for};
use crate::{Gpu, GpuError, GpuModel};
use pfront_core::bvtt::TrianglePair;
use pfront_core::{Bvh, Node, Pose};
use pfront_shaders::constants::GROUP;
use wgpu::{Buffer, CommandEncoder};

/// A first front pairs at most so many nodes: one level on, that is the larger starting front of the paper's GPU algorithm.
const MOST_PAIRS: usize = 4096;

/// The bodies in the world.
#[derive(Debug)]
pub(super) struct Arena {
    /// Without seeds: a query starts from [`Arena::front`].
    pub(super) model: GpuModel,
    tenants: Vec<Tenant>,
    /// Where each vertex is in the frame of its body.
    shapes: Buffer,
    poses: Buffer,
    /// From poses to corners and boxes.
    motion: Sequence,
    /// Other buffers that it holds.
    bytes: u64,
}

/// A body, and where its runs begin.
#[derive(Debug)]
struct Tenant {
    first_triangle: u32,
    first_vertex: u32,
    /// How many vertices it has.
    vertices: usize,
    /// The depth of its BVH.
    depth: u32,
    /// The nodes of each of the first levels, leaves above it included, as a front holds them.
    levels: Vec<Vec<u32>>,
}

/// The arrays to upload.
#[derive(Default)]
struct Contents {
    nodes: Vec<Node>,
    corners: Vec<Corner>,
    order: Vec<u32>,
    roots: Vec<u32>,
    shapes: Vec<[f32; 3]>,
    /// The number of the tenant of each vertex.
    owners: Vec<u32>,
    tenants: Vec<Tenant>,
}

impl Arena {
    /// Nobody is posed yet.
    ///
    /// # Complexity
    /// O(triangles).
    pub(super) fn new(gpu: &Gpu, bodies: &[Bvh<'_>]) -> Result<Self, GpuError> {
        GpuModel::check_size(bodies.iter().map(|bvh| bvh.order().len()).sum())?;
        let mut contents = Contents::default();
        bodies.iter().for_each(|bvh| contents.add(bvh));
        let Contents { nodes, corners, order, roots, shapes, owners, tenants } = contents;
        let model = GpuModel {
            id: GpuModel::next_id(),
            device: gpu.id(),
            nodes: gpu.upload("the nodes", &nodes, Usage::Input)?,
            corners: gpu.upload("the triangles", &corners, Usage::Input)?,
            order: gpu.upload("the order of the triangles", &order, Usage::Input)?,
            seeds: gpu.buffer("the seeds", 0, Usage::Input)?,
            seed_count: 0,
            root: 0,
            depth: 0,
            depth_below_seeds: 0,
            leaf_size: nodes.iter().map(|node| node.count).fold(1, u32::max),
            bounds: None,
        };
        let shapes =
            gpu.upload("the vertices", bytemuck::cast_slice::<_, u32>(&shapes), Usage::Input)?;
        let owner_count = owners.len() as u32;
        let owners = gpu.upload("the owners of vertices", &owners, Usage::Input)?;
        let positions = gpu.buffer("the positions", shapes.size(), Usage::Input)?;
        let rows = tenants.len() * size_of::<Pose>();
        let poses = gpu.buffer("the poses", rows as u64, Usage::Input)?;
        let mut motion = Sequence::new(gpu)?;
        let buffers = [
            ("shapes", &shapes),
            ("owners", &owners),
            ("poses", &poses),
            ("positions", &positions),
        ];
        let parameters = Parameters::new(gpu, "the vertices", &[Posing { vertices: owner_count }])?;
        let groups = groups_for(owner_count.div_ceil(GROUP));
        motion.add(gpu, |p| &p.pose, &buffers, parameters.binding(0), groups)?;
        let schedule = Schedule::of_forest(&nodes, &roots);
        schedule.add_to(&mut motion, gpu, &model, &positions)?;
        let bytes = buffers.iter().map(|(_, buffer)| buffer.size()).sum::<u64>() + schedule.bytes();
        Ok(Self { model, tenants, shapes, poses, motion, bytes })
    }

    /// Bytes of device memory.
    pub(super) fn bytes(&self) -> u64 {
        self.model.bytes() + self.bytes
    }

    /// How many vertices a body has.
    pub(super) fn vertices(&self, body: usize) -> usize {
        self.tenants[body].vertices
    }

    /// Moves the vertices of a body with the next submission.
    pub(super) fn write_positions(&self, gpu: &Gpu, body: usize, positions: &[[f32; 3]]) {
        let first = u64::from(self.tenants[body].first_vertex);
        let at = first * size_of::<[f32; 3]>() as u64;
        gpu.queue().write_buffer(&self.shapes, at, bytemuck::cast_slice(positions));
    }

    /// Moves all bodies to their poses.
    pub(super) fn record_motion(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        poses: &[Pose],
        clock: Option<&mut Clock>,
    ) {
        gpu.queue().write_buffer(&self.poses, 0, bytemuck::cast_slice(poses));
        self.motion.run(encoder, clock);
    }

    /// Node pairs to start from, of pairs of bodies, and the levels of the BVTT below them.
    ///
    /// Few pairs of bodies start some levels below their roots, so that the first pass has work for many
    /// workgroups.
    pub(super) fn front(&self, pairs: &[[u32; 2]]) -> (Vec<Entry>, u32) {
        let tenants = |pair: &[u32; 2]| pair.map(|body| &self.tenants[body as usize]);
        let node_pairs = |level: usize| -> usize {
            let of_pair = |pair| -> usize {
                tenants(pair).into_iter().map(|tenant| tenant.level(level).0.len()).product()
            };
            pairs.iter().map(of_pair).sum()
        };
        // No balanced tree has more levels to offer.
        let deepest = MOST_PAIRS.ilog2() as usize;
        let level = (1..=deepest).rev().find(|&level| node_pairs(level) <= MOST_PAIRS).unwrap_or(0);
        let (mut front, mut levels) = (Vec::with_capacity(node_pairs(level)), 1);
        for pair in pairs {
            let [(own, own_levels), (other, other_levels)] =
                tenants(pair).map(|tenant| tenant.level(level));
            levels = levels.max(own_levels).max(other_levels);
            for &x in own {
                front.extend(other.iter().map(|&y| [x, y]));
            }
        }
        (front, levels)
    }

    /// The bodies and triangles of a pair of triangles of the arena.
    pub(super) fn hit(&self, pair: TrianglePair) -> ([u32; 2], TrianglePair) {
        let [(a, own), (b, other)] = [pair.a, pair.b].map(|triangle| {
            let next = self.tenants.partition_point(|tenant| tenant.first_triangle <= triangle);
            (next as u32 - 1, triangle - self.tenants[next - 1].first_triangle)
        });
        ([a, b], TrianglePair { a: own, b: other })
    }
}

impl Tenant {
    /// The nodes of a level, or of the last one there is, as a front holds them; and how many levels
    /// lie below, of which a leaf on its own counts as one.
    fn level(&self, level: usize) -> (&[u32], u32) {
        let level = level.min(self.levels.len().saturating_sub(1));
        let nodes = self.levels.get(level).map_or(&[][..], Vec::as_slice);
        (nodes, (self.depth - level as u32).max(1))
    }
}

impl Contents {
    /// Adds a body.
    fn add(&mut self, bvh: &Bvh<'_>) {
        let [first_node, first_triangle, first_vertex] =
            [self.nodes.len(), self.order.len(), self.shapes.len()].map(|first| first as u32);
        let mesh = bvh.mesh();
        self.nodes.extend(bvh.nodes().iter().map(|node| {
            let shift = if node.is_leaf() { first_triangle } else { first_node };
            Node { first: node.first + shift, ..*node }
        }));
        for &triangle in bvh.order() {
            self.corners.extend(mesh.triangles()[triangle as usize].map(|vertex| {
                let position = mesh.positions()[vertex as usize];
                Corner { position, vertex: vertex + first_vertex }
            }));
            self.order.push(triangle + first_triangle);
        }
        if !bvh.nodes().is_empty() {
            self.roots.push(first_node);
        }
        self.shapes.extend(mesh.positions());
        self.owners.resize(self.shapes.len(), self.tenants.len() as u32);
        self.tenants.push(Tenant {
            first_triangle,
            first_vertex,
            vertices: mesh.positions().len(),
            depth: bvh.depth() as u32,
            levels: levels(bvh.nodes(), first_node),
        });
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
