//! The sort and the tree it gives, read back from the device.

use super::{Built, sort::Sort};
use crate::groups::EXTRA;
use crate::layout::{Build, Corner};
use crate::pass::Target;
use crate::read::read_now;
use crate::sequence::Sequence;
use crate::source::Source;
use crate::{Gpu, GpuQuery, GpuQuestion};
use bytemuck::{Pod, Zeroable};
use pfront_core::bvh::node_bound;
use pfront_core::bvh::{BuildOptions, BvhStorage, sah};
use pfront_core::bvtt::{PairBvtt, Query};
use pfront_core::{Aabb, Bvh, Mesh, Node, Pose};
use pfront_testkit::rng::{Rng, seeded};
use pfront_testkit::scenes::torus_knot;
use std::sync::OnceLock;

fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::new().unwrap_or_else(|error| panic!("{error}")))
}

fn read<T: Pod>(buffer: &wgpu::Buffer, count: usize) -> Vec<T> {
    let (device, queue) = (gpu().device(), gpu().queue());
    let encoder = device.create_command_encoder(&Default::default());
    pollster::block_on(read_now(device, queue, encoder, buffer, count, None)).unwrap()
}

fn run(sequence: &Sequence) {
    let mut encoder = gpu().device().create_command_encoder(&Default::default());
    sequence.run(&mut encoder, None);
    gpu().queue().submit([encoder.finish()]);
    gpu().check().unwrap();
}

#[test]
fn the_sort_is_that_of_the_host() {
    let mut random = seeded(7);
    for n in [1, 2, 4, 5, 127, 128, 129, 255, 256, 257, 511, 513, 5_000, 70_000] {
        let mut sort = Sort::new(gpu(), n).unwrap();
        let mut sequence = Sequence::new(gpu()).unwrap();
        let round = Build { triangles: n, ..Build::zeroed() };
        // Four digits: the entries end where they began.
        sort.add(gpu(), &mut sequence, round, u32::BITS, None).unwrap();
        for mask in [u32::MAX, 0, 0x0300_0001, 0xff00, 0x7fff_0000] {
            let mut entries: Vec<[u32; 2]> =
                (0..n).map(|i| [random.next_u32() & mask, i]).collect();
            gpu().queue().write_buffer(sort.entries(), 0, bytemuck::cast_slice(&entries));
            run(&sequence);
            entries.sort_by_key(|&[key, _]| key);
            assert!(read::<[u32; 2]>(sort.entries(), n as usize) == entries, "{n} of {mask:x}");
        }
    }
}

/// Nodes and order.
type Tree = (Vec<Node>, Vec<u32>);

/// Builds a tree over a mesh, reads it back and checks it.
fn build(positions: &[[f32; 3]], triangles: &[[u32; 3]], leaf_size: u32) -> Tree {
    let mesh = Mesh::new(positions, triangles).unwrap();
    let source = Source::new(gpu(), mesh).unwrap();
    let bounds = Aabb::of(positions);
    let options = BuildOptions { leaf_size, ..BuildOptions::default() };
    let built = Built::new(gpu(), &source, &bounds, options).unwrap();
    run(&built.build);
    let model = built.model;

    let n = triangles.len();
    let order: Vec<u32> = read(&model.order, n);
    let nodes: Vec<Node> = read(&model.nodes, (model.nodes.size() / 32) as usize);
    let nodes = &nodes[..if model.depth == 0 { n.min(1) } else { 2 << model.depth }];
    let bvh = Bvh::new(mesh, nodes, &order, &mut vec![0; n.div_ceil(32)]).unwrap();
    assert_eq!(bvh.depth() as u32, model.depth);
    assert!(nodes.iter().all(|node| node.count <= leaf_size.max(2)));
    let corners: Vec<[Corner; 3]> = read(&model.corners, n);
    for (corners, &triangle) in corners.iter().zip(&order) {
        assert_eq!(corners.map(|corner| corner.vertex), triangles[triangle as usize]);
        // Compared as numbers: a box has no -0.
        assert_eq!(corners.map(|corner| corner.position), mesh.shadow_triangle(triangle));
    }
    for node in nodes.iter().filter(|node| node.is_leaf()) {
        let run = &order[node.first as usize..][..node.count as usize];
        let of = |bounds: Aabb, &t: &u32| bounds.union(&Aabb::of(&mesh.shadow_triangle(t)));
        assert_eq!(node.aabb(), run.iter().fold(Aabb::EMPTY, of), "boxes are tight");
    }
    (nodes.to_vec(), order)
}

#[test]
fn every_tree_is_a_bvh() {
    let whole = torus_knot(40_000);
    for (n, leaf_size) in [
        (0, 4),
        (1, 4),
        (2, 1),
        (4, 4),
        (5, 4),
        (3, 2),
        (255, 8),
        (256, 8),
        (257, 8),
        (511, 1),
        (5_000, 3),
        (40_000, 4),
    ] {
        build(&whole.positions, &whole.triangles[..n.min(whole.triangles.len())], leaf_size);
    }
}

#[test]
fn boxes_hold_any_finite_positions() {
    let whole = torus_knot(2_000);
    for scale in [0.0, -0.0, f32::from_bits(3), f32::MIN_POSITIVE, 1e-30, 1e30, 2.4e38] {
        let positions: Vec<_> = whole.positions.iter().map(|p| p.map(|x| x * scale)).collect();
        build(&positions, &whole.triangles, 4);
    }
    let most = [[f32::MAX; 3], [-f32::MAX; 3], [f32::MAX, -f32::MAX, 0.0]];
    let positions: Vec<_> = most.into_iter().chain(whole.positions).collect();
    let triangles: Vec<_> = whole.triangles.iter().map(|t| t.map(|v| v + 3)).collect();
    build(&positions, &[&[[0, 1, 2], [0, 0, 0]], &triangles[..]].concat(), 4);
}

/// Box tests and triangle pairs of leaf pairs.
fn work<Q: Query>(query: &Q, nodes: [&[Node]; 2]) -> [u64; 2] {
    let mut waiting: Vec<_> = query.root().into_iter().collect();
    let mut work = [0; 2];
    while let Some(n) = waiting.pop() {
        let (a, b) = (&nodes[0][n.a as usize], &nodes[1][n.b as usize]);
        work[0] += u64::from(query.children(n, &mut |child, _| waiting.push(child)));
        work[1] += u64::from(a.count * b.count);
    }
    work
}

#[test]
fn queries_take_little_more_work_than_with_the_tree_of_the_core() {
    let knot = torus_knot(20_000);
    let mesh = Mesh::new(&knot.positions, &knot.triangles).unwrap();
    let n = knot.triangles.len();
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
    let mut scratch = vec![Node::EMPTY; n];
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let core =
        sah(mesh, &BuildOptions { leaf_size: 4, ..BuildOptions::default() }, storage, &mut scratch)
            .unwrap();
    let (nodes, order) = build(&knot.positions, &knot.triangles, 4);
    let own = Bvh::new_unchecked(mesh, &nodes, &order);
    let pose = Pose::from_translation([0.3, 0.1, 0.2]);
    let of = |bvh: Bvh<'_>| {
        let pair = PairBvtt::new(bvh, bvh, pose).unwrap();
        work(&pair, [bvh.nodes(); 2])
    };
    let [[boxes, triangles], [most_boxes, most_triangles]] = [own, core].map(of);
    assert!(boxes < 2 * most_boxes && triangles < most_triangles * 5 / 4);
}

#[test]
fn workgroups_without_work_store_nothing() {
    let knot = torus_knot(5_000);
    let n = knot.triangles.len();
    let mesh = Mesh::new(&knot.positions, &knot.triangles).unwrap();
    let source = Source::new(gpu(), mesh).unwrap();
    let options = BuildOptions { leaf_size: 4, ..BuildOptions::default() };
    let mut answers = [0, 1, 3].map(|extra| {
        EXTRA.set(extra);
        let built = Built::new(gpu(), &source, &Aabb::of(&knot.positions), options).unwrap();
        run(&built.build);
        run(&built.refit);
        let mut query = GpuQuery::new(gpu()).unwrap();
        let pose = Pose::from_translation([0.3, 0.1, 0.2]);
        let pairs =
            query.all(&GpuQuestion::pair(&built.model, &built.model, &pose)).unwrap().to_vec();
        let nodes: Vec<Node> = read(&built.model.nodes, built.model.nodes.size() as usize / 32);
        EXTRA.set(0);
        (read::<u32>(&built.model.order, n), nodes[2..].to_vec(), pairs)
    });
    assert!(answers[0].2.len() > 100);
    let [first, rest @ ..] = &mut answers;
    assert!(rest.iter().all(|other| other == first));
}

#[test]
fn few_rounds_take_more_runs_and_give_the_same_answer() {
    let knot = torus_knot(5_000);
    let mesh = Mesh::new(&knot.positions, &knot.triangles).unwrap();
    let source = Source::new(gpu(), mesh).unwrap();
    let options = BuildOptions { leaf_size: 4, ..BuildOptions::default() };
    let built = Built::new(gpu(), &source, &Aabb::of(&knot.positions), options).unwrap();
    run(&built.build);
    let pose = Pose::from_translation([0.05, 0.0, 0.0]);
    let [(many, one), (few, more)] = [800, 10].map(|rounds| {
        let target = Target { arithmetic: gpu().arithmetic(), rounds, certify: false };
        let settings = crate::GpuSettings { groups: 1, ..gpu().settings() };
        let gpu = gpu().with_target(target).unwrap();
        let mut query = GpuQuery::with_settings(&gpu, settings).unwrap();
        let pairs =
            query.all(&GpuQuestion::pair(&built.model, &built.model, &pose)).unwrap().to_vec();
        (pairs, query.report().runs)
    });
    assert!(many.len() > 100 && many == few);
    assert!(one < more, "{one} and {more} runs");
}

#[test]
fn a_shader_that_the_device_refuses_is_an_error() {
    let large = pfront_shaders::Pass {
        entry: "large",
        parts: &["@compute @workgroup_size(65536) fn large() {}"],
        buffers: &[],
    };
    let device = gpu().device();
    let target = Target::new(device, gpu().arithmetic());
    let refused = crate::pass::Pass::new(device, &large, target);
    assert!(matches!(refused, Err(crate::GpuError::Device { .. })), "{refused:?}");
}
