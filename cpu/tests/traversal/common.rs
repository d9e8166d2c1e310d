//! Meshes with a BVH, and frames of the scenes.

use pfront_core::bvh::node_bound;
use pfront_core::bvh::{self, BuildOptions, BvhStorage, SahItem};
use pfront_core::bvtt::{PairQuery, Query, TrianglePair};
use pfront_core::{Bvh, Mesh, Node, Pose};
use pfront_scenes::{Scene, TriMesh};
use std::ops::ControlFlow;

/// A mesh that owns its BVH.
pub(crate) struct Body {
    mesh: TriMesh,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Body {
    pub(crate) fn new(mesh: TriMesh) -> Self {
        let n = mesh.triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let mut scratch = vec![SahItem::default(); bvh::sah_scratch_bound(n)];
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let view = Mesh::new(&mesh.positions, &mesh.triangles).unwrap();
        let options = BuildOptions::default();
        let used = bvh::sah(view, &options, storage, &mut scratch).unwrap().nodes().len();
        nodes.truncate(used);
        Self { mesh, nodes, order }
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
        );
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

    pub(crate) fn query(&self, frame: usize) -> PairQuery<'_> {
        let mut poses = Vec::new();
        self.scene.poses(frame, &mut poses);
        let [a, b] = [0, 1].map(|i| self.bodies[self.scene.objects[i]].bvh());
        PairQuery::new(a, b, Pose::new(poses[1])).unwrap()
    }
}

/// What one core finds, sorted.
pub(crate) fn sequential(query: &impl Query) -> Vec<TrianglePair> {
    let mut pairs = Vec::new();
    let _ = query.visit(&mut query.start(), |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    });
    pairs.sort_unstable();
    pairs
}
