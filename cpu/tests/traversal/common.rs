//! Meshes with a BVH, and frames of the scenes.

use pfront_core::bvh::node_bound;
use pfront_core::bvh::{self, BuildOptions, BvhStorage};
use pfront_core::bvtt::{PairBvtt, Query, TrianglePair};
use pfront_core::{Bvh, Mesh, Node, Pose};
use pfront_cpu::{Report, Schedule};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::Scene;
use std::ops::ControlFlow;

pub(crate) const SCHEDULES: [Schedule; 2] = [Schedule::Static, Schedule::Hybrid];

/// A mesh that owns its BVH.
pub(crate) struct Body {
    mesh: MeshData,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Body {
    pub(crate) fn new(mesh: MeshData) -> Self {
        let n = mesh.triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let mut scratch = vec![Node::EMPTY; n];
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let view = Mesh::new(&mesh.positions, &mesh.triangles).unwrap();
        let options = BuildOptions::default();
        let used = bvh::sah(view, &options, storage, &mut scratch).unwrap().nodes().len();
        nodes.truncate(used);
        Self { mesh, nodes, order }
    }

    /// The same below a chain of `levels` nodes, each with a triangle of its own beside it: so deep is a tree in which a
    /// dense body lies in one cell of a Morton order, beside an outlier for each of its bits.
    pub(crate) fn below_outliers(mut self, levels: u32) -> Self {
        let own = self.mesh.triangles.len() as u32;
        for outlier in 0..levels {
            let (first, x) =
                (self.mesh.positions.len() as u32, 100.0 * 0.5_f32.powi(outlier as i32));
            self.mesh.positions.extend([[x, 0.0, 0.0], [x, 0.01, 0.0], [x, 0.0, 0.01]]);
            self.mesh.triangles.push([first, first + 1, first + 2]);
        }
        self.order.splice(0..0, own..own + levels);
        let (mut nodes, mut parent) = (vec![Node::EMPTY; 2], 0);
        for outlier in 0..levels {
            nodes[parent].first = nodes.len() as u32;
            nodes.push(Node { first: outlier, count: 1, ..Node::EMPTY });
            parent = nodes.len();
            nodes.push(Node::EMPTY);
        }
        let shift = nodes.len() as u32 - 2;
        let moved = |node: &Node| {
            let first = node.first + if node.is_leaf() { levels } else { shift };
            Node { first, ..*node }
        };
        let below: Vec<_> = self.nodes.iter().map(moved).collect();
        nodes[parent] = below[0];
        nodes.extend_from_slice(&below[2..]);
        self.nodes = nodes;
        let positions = self.mesh.positions.clone();
        self.deform(&positions);
        self
    }

    pub(crate) fn bvh(&self) -> Bvh<'_> {
        let mesh = Mesh::new_unchecked(&self.mesh.positions, &self.mesh.triangles);
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }

    /// The same mesh in another shape.
    pub(crate) fn deform(&mut self, positions: &[[f32; 3]]) {
        self.mesh.positions.copy_from_slice(positions);
        bvh::refit(
            Mesh::new_unchecked(&self.mesh.positions, &self.mesh.triangles),
            &mut self.nodes,
            &self.order,
            bvh::Refit::default(),
        )
        .unwrap();
    }
}

/// Two bodies and how the second moves.
pub(crate) struct Frames {
    scene: Scene,
    bodies: Vec<Body>,
}

impl Frames {
    pub(crate) fn new(scene: Scene) -> Self {
        let bodies = scene.meshes.iter().cloned().map(Body::new).collect();
        Self { scene, bodies }
    }

    pub(crate) fn named(name: &str, size: usize) -> Self {
        Self::new(Scene::by_name(name, Some(size)).unwrap())
    }

    pub(crate) fn query(&self, frame: usize) -> PairBvtt<'_> {
        let mut poses = Vec::new();
        self.scene.poses(frame, &mut poses);
        let [a, b] = [0, 1].map(|i| self.bodies[self.scene.objects[i]].bvh());
        PairBvtt::new(a, b, Pose::new(poses[1])).unwrap()
    }
}

/// The pairs that one core finds, sorted.
pub(crate) fn sequential(query: &impl Query) -> Vec<TrianglePair> {
    let mut pairs = Vec::new();
    let _ = query.visit(&mut query.start(), |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    });
    pairs.sort_unstable();
    pairs
}

/// The predicted cost of the busiest worker over the mean.
pub(crate) fn predicted_imbalance(report: &Report) -> f64 {
    let predicted = || report.shares.iter().map(|share| share.predicted);
    predicted().fold(0.0, f64::max) * report.shares.len() as f64 / predicted().sum::<f64>()
}
