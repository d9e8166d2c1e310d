//! Bytes a triangle and time of the compact layout beside the standard one.
//!
//! `cargo bench --bench compact`; with recorded data (`PFRONT_DATA`, see test.sh) two bunnies are added. Times
//! are medians of rounds in which each tree is asked in turn, so that all suffer alike from what else a machine
//! does. Answers are compared in every round.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a bench fails by panicking")]

use pfront::{BuildOptions, Bvh, Mesh, Node, Pose};
use pfront_core::bvh::{self, BvhStorage};
use pfront_core::bvh::{CompactNode, Layout, compact, node_bound};
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::Scene;
use std::time::{Duration, Instant};

/// Two meshes in some poses, or one by itself.
struct Case {
    name: &'static str,
    meshes: Vec<MeshData>,
    poses: Vec<Pose>,
}

fn cases() -> Vec<Case> {
    let mut cases = vec![
        pair("worm-gear", None, [60, 64, 68, 72]),
        pair("torus-knots", Some(400_000), [60, 64, 68, 72]),
        sheet(),
    ];
    cases.extend(bunnies());
    cases
}

fn pair(name: &'static str, size: Option<usize>, frames: [usize; 4]) -> Case {
    let scene = Scene::by_name(name, size).unwrap();
    let meshes = scene.objects.iter().map(|&object| scene.meshes[object].clone()).collect();
    let mut rows = Vec::new();
    let pose = |frame| {
        scene.poses(frame, &mut rows);
        Pose::new(rows[1])
    };
    Case { name, meshes, poses: frames.map(pose).to_vec() }
}

fn sheet() -> Case {
    let scene = Scene::by_name("sheet", None).unwrap();
    let mut mesh = scene.meshes[0].clone();
    scene.positions(100, &mut mesh.positions);
    Case { name: "sheet with itself", meshes: vec![mesh], poses: vec![Pose::IDENTITY] }
}

fn bunnies() -> Option<Case> {
    let folder = std::env::var_os("PFRONT_DATA")?;
    let path = std::path::Path::new(&folder).join("classic/bunny_69451.obj");
    let read = pfront_files::read_f32(&path).unwrap_or_else(|e| panic!("{e}"));
    let mesh = MeshData { positions: read.positions, triangles: read.triangles };
    let (sin, cos) = 0.3_f32.sin_cos();
    // A bunny is 0.16 wide.
    let pose = |i: u8| {
        let x = 0.008 * f32::from(i);
        Pose::new([[cos, -sin, 0.0, x], [sin, cos, 0.0, 0.003], [0.0, 0.0, 1.0, 0.002]])
    };
    Some(Case {
        name: "bunnies",
        meshes: vec![mesh.clone(), mesh],
        poses: (1..=6).map(pose).collect(),
    })
}

/// How trees are built.
#[derive(Clone, Copy)]
enum Build {
    Sah,
    Morton,
}

const BUILDS: [(Build, &str); 2] = [(Build::Sah, "SAH"), (Build::Morton, "Morton")];

/// A tree in both layouts.
struct Tree<'m> {
    mesh: Mesh<'m>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    compact: Vec<CompactNode>,
}

impl<'m> Tree<'m> {
    fn new(mesh: &'m MeshData, build: Build, leaf_size: u32) -> Self {
        let mesh = Mesh::new(&mesh.positions, &mesh.triangles).unwrap();
        let n = mesh.triangles().len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let options = BuildOptions { leaf_size, ..BuildOptions::default() };
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let bvh = if matches!(build, Build::Morton) {
            bvh::morton(mesh, &options, storage, &mut vec![0; 2 * n])
        } else {
            let mut scratch = vec![Node::EMPTY; n];
            bvh::sah(mesh, &options, storage, &mut scratch)
        };
        let used = bvh.unwrap().nodes().len();
        nodes.truncate(used);
        let mut small = vec![CompactNode::default(); used];
        compact(mesh, &nodes, &order, &mut small).unwrap();
        Self { mesh, nodes, order, compact: small }
    }

    fn standard(&self) -> Bvh<'_> {
        Bvh::new_unchecked(self.mesh, &self.nodes, &self.order)
    }

    fn compact(&self) -> Bvh<'_, CompactNode> {
        Bvh::new_unchecked(self.mesh, &self.compact, &self.order)
    }
}

/// Bytes a triangle of nodes of type `N` and the order.
fn bytes<N>(trees: &[Tree<'_>]) -> String {
    let triangles: usize = trees.iter().map(|tree| tree.order.len()).sum();
    let nodes: usize = trees.iter().map(|tree| tree.nodes.len()).sum();
    let bytes = nodes * size_of::<N>() + triangles * size_of::<u32>();
    format!("{:.1}", bytes as f64 / triangles as f64)
}

/// How many pairs meet in all poses, and how long that took.
fn ask<N: Layout>(case: &Case, bvhs: &[Bvh<'_, N>]) -> (u64, Duration) {
    let clock = Instant::now();
    let count = match *bvhs {
        [own] => SelfBvtt::new(own).count(),
        _ => {
            let ask = |pose: &Pose| PairBvtt::new(bvhs[0], bvhs[1], *pose).unwrap().count();
            case.poses.iter().map(ask).sum()
        }
    };
    (count, clock.elapsed())
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

fn main() {
    let once = std::env::args().any(|argument| argument == "--test");
    let (rounds, leaf_sizes): (_, &[u32]) = if once { (1, &[4]) } else { (15, &[1, 2, 4, 8]) };
    println!(
        "| scene | build | leaf size | standard | compact | standard, ms | compact ÷ standard | compact ÷ \
         standard by default |\n|---|---|---|---|---|---|---|---|"
    );
    for case in cases() {
        let trees = |build, leaf_size| -> Vec<_> {
            case.meshes.iter().map(|mesh| Tree::new(mesh, build, leaf_size)).collect()
        };
        let default = trees(Build::Sah, BuildOptions::default().leaf_size);
        for (build, name) in BUILDS {
            for &leaf_size in leaf_sizes {
                let trees = trees(build, leaf_size);
                let mut times = [vec![], vec![], vec![]];
                for _ in 0..rounds {
                    let asked = [
                        ask(&case, &default.iter().map(Tree::standard).collect::<Vec<_>>()),
                        ask(&case, &trees.iter().map(Tree::standard).collect::<Vec<_>>()),
                        ask(&case, &trees.iter().map(Tree::compact).collect::<Vec<_>>()),
                    ];
                    assert!(asked.iter().all(|answer| answer.0 == asked[0].0), "{}", case.name);
                    times.iter_mut().zip(asked).for_each(|(times, (_, time))| times.push(time));
                }
                let [default, standard, compact] = times.map(median);
                println!(
                    "| {} | {name} | {leaf_size} | {} | {} | {standard:.2} | {:.2} | {:.2} |",
                    case.name,
                    bytes::<Node>(&trees),
                    bytes::<CompactNode>(&trees),
                    compact / standard,
                    compact / default,
                );
            }
        }
    }
}
