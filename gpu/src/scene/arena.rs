//! All bodies on the device: one mesh and one forest of trees, each body with its own run of both.

use super::bodies::{Bodies, BodyId};
use super::shape::MOST_PAIRS;
use super::{SceneHit, Shape};
use crate::clock::Clock;
use crate::engine::Entry;
use crate::layout::{Corner, Posing};
use crate::memory::Usage;
use crate::parameters::Parameters;
use crate::schedule::Schedule;
use crate::sequence::{Sequence, groups_for};
use crate::{Error, Gpu, Model};
use pfront_core::bvtt::TrianglePair;
use pfront_core::{Node, Pose};
use pfront_shaders::constants::GROUP;
use wgpu::{Buffer, CommandEncoder};

/// The bodies that have triangles, in the world.
#[derive(Debug)]
pub(super) struct Arena {
    /// Without seeds: a query starts from [`Arena::front`].
    pub(super) model: Model,
    tenants: Vec<Tenant>,
    /// Where each vertex is in the frame of its body.
    shapes: Buffer,
    poses: Buffer,
    /// From poses to corners and boxes.
    motion: Sequence,
    /// Other buffers that it holds.
    bytes: u64,
}

/// A body and where its runs begin.
#[derive(Debug)]
struct Tenant {
    id: BodyId,
    /// Among all bodies.
    place: u32,
    first_node: u32,
    first_triangle: u32,
    first_vertex: u32,
}

/// The arrays to upload.
#[derive(Default)]
struct Contents {
    nodes: Vec<Node>,
    corners: Vec<Corner>,
    order: Vec<u32>,
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
    pub(super) fn new(gpu: &Gpu, bodies: &Bodies) -> Result<Self, Error> {
        let triangles = bodies.solid().map(|(body, _)| body.shape().mesh().triangles().len()).sum();
        Model::check_size(triangles)?;
        let mut contents = Contents::default();
        for (body, place) in bodies.iter().zip(0..).filter(|(body, _)| body.aabb().is_some()) {
            contents.add(body.id(), place, body.shape());
        }
        let Contents { nodes, corners, order, shapes, owners, tenants } = contents;
        let model = Model {
            id: Model::next_id(),
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
        let roots: Vec<u32> = tenants.iter().map(|tenant| tenant.first_node).collect();
        let schedule = Schedule::of_forest(&nodes, &roots);
        schedule.add_to(&mut motion, gpu, &model, &positions)?;
        let bytes = buffers.iter().map(|(_, buffer)| buffer.size()).sum::<u64>() + schedule.bytes();
        Ok(Self { model, tenants, shapes, poses, motion, bytes })
    }

    /// Bytes of device memory.
    pub(super) fn bytes(&self) -> u64 {
        self.model.bytes() + self.bytes
    }

    /// Moves the vertices of a body with the next submission.
    pub(super) fn write_positions(&self, gpu: &Gpu, id: BodyId, positions: &[[f32; 3]]) {
        // A body without triangles is not in the arena.
        if let Ok(number) = self.tenants.binary_search_by_key(&id, |tenant| tenant.id) {
            let at = u64::from(self.tenants[number].first_vertex) * size_of::<[f32; 3]>() as u64;
            gpu.queue().write_buffer(&self.shapes, at, bytemuck::cast_slice(positions));
        }
    }

    /// Moves everybody to where they are now.
    pub(super) fn record_motion(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        bodies: &Bodies,
        clock: Option<&mut Clock>,
    ) {
        let poses: Vec<Pose> = bodies.solid().map(|(body, _)| body.pose()).collect();
        gpu.queue().write_buffer(&self.poses, 0, bytemuck::cast_slice(&poses));
        self.motion.run(encoder, clock);
    }

    /// Node pairs to start from, of pairs of tenants by their numbers, and the levels of the BVTT below
    /// them.
    ///
    /// Few pairs of bodies start some levels below their roots, so that the first pass has work for many
    /// workgroups.
    pub(super) fn front(&self, bodies: &Bodies, pairs: &[[u32; 2]]) -> (Vec<Entry>, u32) {
        let tenants = |pair: &[u32; 2]| pair.map(|number| &self.tenants[number as usize]);
        let nodes = |tenant: &Tenant, level| bodies.at(tenant.place).shape().level(level);
        let node_pairs = |level: usize| -> usize {
            let of_pair = |pair| -> usize {
                tenants(pair).into_iter().map(|tenant| nodes(tenant, level).0.len()).product()
            };
            pairs.iter().map(of_pair).sum()
        };
        // No balanced tree has more levels to offer.
        let deepest = MOST_PAIRS.ilog2() as usize;
        let level = (1..=deepest).rev().find(|&level| node_pairs(level) <= MOST_PAIRS).unwrap_or(0);
        let (mut front, mut levels) = (Vec::with_capacity(node_pairs(level)), 1);
        for pair in pairs {
            let [a, b] = tenants(pair);
            let ((own, own_levels), (other, other_levels)) = (nodes(a, level), nodes(b, level));
            levels = levels.max(own_levels).max(other_levels);
            for x in own {
                front.extend(other.iter().map(|y| [x + a.first_node, y + b.first_node]));
            }
        }
        (front, levels)
    }

    /// The bodies and triangles of a pair of triangles of the arena.
    pub(super) fn hit(&self, pair: TrianglePair) -> SceneHit {
        let tenant = |triangle: u32| {
            let next = self.tenants.partition_point(|tenant| tenant.first_triangle <= triangle);
            &self.tenants[next - 1]
        };
        let (own, other) = (tenant(pair.a), tenant(pair.b));
        let pair =
            TrianglePair { a: pair.a - own.first_triangle, b: pair.b - other.first_triangle };
        SceneHit { bodies: [own.id, other.id], pair }
    }
}

impl Contents {
    /// Adds an instance of a shape.
    fn add(&mut self, id: BodyId, place: u32, shape: &Shape) {
        let [first_node, first_triangle, first_vertex] =
            [self.nodes.len(), self.order.len(), self.shapes.len()].map(|first| first as u32);
        let (bvh, mesh) = (shape.bvh(), shape.mesh());
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
        self.shapes.extend(mesh.positions());
        self.owners.resize(self.shapes.len(), self.tenants.len() as u32);
        self.tenants.push(Tenant { id, place, first_node, first_triangle, first_vertex });
    }
}
