//! Meshes and BVHs on which calls take most of the stack.

use pfront_core::bvh::{BuildOptions, BvhStorage, sah};
use pfront_core::bvh::{MAX_DEPTH, node_bound};
use pfront_core::{Bvh, Mesh, Node};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::{sheet, union};

pub(crate) fn mesh(soup: &MeshData) -> Mesh<'_> {
    Mesh::new(&soup.positions, &soup.triangles).unwrap()
}

/// `count` triangles in one place, which no build can tell apart.
pub(crate) fn coincident(count: usize) -> MeshData {
    MeshData::of((0..count).map(|_| [[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3]]))
}

/// `count` plates in a row, of which SAH takes the first as often as depth allows: it is farther from the others than
/// they are long, by more than the number of bins.
pub(crate) fn peeling(count: usize) -> MeshData {
    let plate = |x: f32| [[x, -1e38, -1e38], [x, 1e38, -1e38], [x, 1e38, 1e38]];
    let far = (0..58).map(|k| -1e35 * 18_f32.powi(-k));
    MeshData::of(far.chain((58..count).map(|k| k as f32 * 1e-42)).take(count).map(plate))
}

/// Points in Morton cells each of which has one bit, and `count` in the first cell.
pub(crate) fn curled(count: usize) -> MeshData {
    let cells = (0..33).map(|bit| {
        let mut cell = [0.0; 3];
        cell[bit % 3] = (1 << (bit / 3)) as f32;
        cell
    });
    let last = [[2047.0; 3]];
    let points = cells.chain(last).chain((0..count).map(|_| [0.0; 3]));
    MeshData::of(points.map(|p| [p; 3]))
}

/// Triangles that meet, or nearly, whose coordinates are so unlike that only long integers decide.
pub(crate) fn disparate(count: usize) -> MeshData {
    let mut rng = seeded(7);
    let mut number = || {
        let exponent = rng.random_range(30..200);
        f32::from_bits(rng.random::<u32>() & !(0xff << 23) | exponent << 23)
    };
    // In planes through one line.
    MeshData::of((0..count).map(|_| {
        [(); 3].map(|()| {
            let x = number();
            [x, x, number()]
        })
    }))
}

/// Two crumpled sheets in one place, `edge` squares along each edge, with corners in common.
pub(crate) fn sheets(edge: u32) -> MeshData {
    let wave = |u: f32| (4.5 * u).sin();
    let one = sheet(edge, |_, _| 0.0)
        .map(|[u, v, _]| [u + 0.2 * wave(v), v + 0.2 * wave(u), 0.4 * wave(u + v)]);
    union(&[one.clone(), one])
}

/// Nodes and order of a BVH.
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) order: Vec<u32>,
}

impl Tree {
    pub(crate) fn of(mesh: Mesh<'_>) -> Self {
        let count = mesh.triangles().len();
        let mut tree = Self { nodes: vec![Node::EMPTY; node_bound(count)], order: vec![0; count] };
        let (options, mut items) = (BuildOptions::default(), vec![Node::EMPTY; count]);
        let used = sah(mesh, &options, tree.storage(), &mut items).unwrap().nodes().len();
        tree.nodes.truncate(used);
        tree
    }

    /// As deep as can be: every left child is a leaf of one triangle.
    pub(crate) fn deepest(mesh: Mesh<'_>) -> Self {
        let count = MAX_DEPTH as u32 + 1;
        assert_eq!(mesh.triangles().len() as u32, count);
        let whole = Self::of(mesh).bvh(mesh).aabb().unwrap();
        let node = |first, count| Node { min: whole.min, first, max: whole.max, count };
        let mut nodes = vec![node(2, 0), Node::EMPTY];
        for triangle in 0..count - 1 {
            let (below, is_last) = (nodes.len() as u32 + 2, triangle + 2 == count);
            let right = if is_last { node(count - 1, 1) } else { node(below, 0) };
            nodes.extend([node(triangle, 1), right]);
        }
        Self { nodes, order: (0..count).collect() }
    }

    /// For a build to write anew.
    pub(crate) fn storage(&mut self) -> BvhStorage<'_> {
        BvhStorage { nodes: &mut self.nodes, order: &mut self.order }
    }

    pub(crate) fn bvh<'t>(&'t self, mesh: Mesh<'t>) -> Bvh<'t> {
        Bvh::new(mesh, &self.nodes, &self.order, &mut [0; 256]).unwrap()
    }
}
