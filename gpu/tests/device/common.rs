//! Shared by the tests: one device, and meshes on it beside the core's.

use pfront_core::bvh::node_bound;
use pfront_core::bvh::{self, BuildOptions, BvhStorage};
use pfront_core::bvtt::{self, Query, TrianglePair};
use pfront_core::{Bvh, Mesh, Node, Pose};
use pfront_gpu::{Arithmetic, Gpu, GpuModel};
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// The device of all tests. Without an adapter they fail, saying what to install.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::new().unwrap_or_else(|error| panic!("{error}")))
}

/// The same device with each arithmetic, whose passes are compiled once for all tests.
pub(crate) fn gpu_with(arithmetic: Arithmetic) -> &'static Gpu {
    static OTHERS: [OnceLock<Gpu>; 3] = [const { OnceLock::new() }; 3];
    if arithmetic == gpu().arithmetic() {
        return gpu();
    }
    OTHERS[arithmetic as usize].get_or_init(|| gpu().with_arithmetic(arithmetic).unwrap())
}

/// A mesh with its BVH, and both on the device.
pub(crate) struct Both {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    pub(crate) model: GpuModel,
}

impl Both {
    pub(crate) fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]], leaf_size: u32) -> Self {
        let n = triangles.len();
        let mesh = Mesh::new(positions, triangles).unwrap();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let mut scratch = vec![Node::EMPTY; n];
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let bvh = bvh::sah(
            mesh,
            &BuildOptions { leaf_size, ..BuildOptions::default() },
            storage,
            &mut scratch,
        )
        .unwrap();
        let (used, model) = (bvh.nodes().len(), GpuModel::new(gpu(), bvh).unwrap());
        nodes.truncate(used);
        Self { positions: positions.to_vec(), triangles: triangles.to_vec(), nodes, order, model }
    }

    /// Moves the mesh and refits the core's BVH; the device's stays.
    pub(crate) fn set_positions(&mut self, positions: &[[f32; 3]]) {
        self.positions = positions.to_vec();
        let mesh = Mesh::new(&self.positions, &self.triangles).unwrap();
        bvh::refit(mesh, &mut self.nodes, &self.order, bvh::Refit::default()).unwrap();
    }

    pub(crate) fn bvh(&self) -> Bvh<'_> {
        Bvh::new_unchecked(
            Mesh::new_unchecked(&self.positions, &self.triangles),
            &self.nodes,
            &self.order,
        )
    }
}

/// The pairs that the core finds, sorted.
pub(crate) fn truth(a: &Both, b: &Both, a_from_b: &Pose) -> Vec<TrianglePair> {
    sorted(&bvtt::PairBvtt::new(a.bvh(), b.bvh(), *a_from_b).unwrap())
}

pub(crate) fn sorted(query: &impl Query) -> Vec<TrianglePair> {
    let mut pairs = Vec::new();
    let _ = query.visit(&mut query.start(), |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    });
    pairs.sort_unstable();
    pairs
}
