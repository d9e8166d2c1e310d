//! Writes the recorded meshes as workloads, for `pfront bench gpu`, `pfront replay` and `pfront balance`.
//!
//! `PFRONT_DATA=… cargo run --release --example workloads -- FOLDER`, with the data of `test.sh`, writes
//! - `bunnies`, `dragons`, `dragons-3m`: two of the mesh, the second swaying; the last has every triangle
//!   divided into four;
//! - `cloth-ball`: its two frames in turn; `kick`: a garment of 121 frames; `kick-100k`: divided too.

#![expect(clippy::unwrap_used, reason = "an example fails by panicking")]

use pfront::Pose;
use pfront_cli::mesh::{self, MeshData};
use pfront_lab::workload::{Frame, Header, WorkloadWriter};
use pfront_testkit::scenes::Kind;
use std::collections::HashMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

fn main() {
    let data = PathBuf::from(std::env::var_os("PFRONT_DATA").unwrap_or("../shared/data".into()));
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or(".".into()));
    let read = |file: &str| mesh::read(&data.join(file)).unwrap();

    let bunny = read("classic/bunny_69451.obj");
    sway(&folder.join("bunnies.tcw"), bunny, 0.015625);
    let dragon = read("classic/dragon_871414.ply");
    sway(&folder.join("dragons-3m.tcw"), Divided::new(&dragon).mesh(&dragon), 0.02);
    sway(&folder.join("dragons.tcw"), dragon, 0.02);

    let balls = [92, 93].map(|i| read(&format!("cloth/cloth_ball/cloth_ball{i}.ply")));
    let frames: Vec<_> = balls.iter().map(|ball| &ball.positions[..]).cycle().take(32).collect();
    deform(&folder.join("cloth-ball.tcw"), &balls[0], &frames);

    let garment = read("cloth/kick/kick_frame000.ply");
    let bytes = std::fs::read(data.join("cloth/kick/kick_positions_121x12811x3.f32le")).unwrap();
    let positions: Vec<[f32; 3]> = bytemuck::pod_collect_to_vec(&bytes);
    let frames: Vec<_> = positions.chunks_exact(garment.positions.len()).collect();
    deform(&folder.join("kick.tcw"), &garment, &frames);
    let divided = Divided::new(&garment);
    let frames: Vec<_> = frames.into_iter().map(|frame| divided.positions(frame)).collect();
    let frames: Vec<_> = frames.iter().map(|frame| &frame[..]).collect();
    deform(&folder.join("kick-100k.tcw"), &divided.mesh(&garment), &frames);
}

/// Two of a mesh, the second moved by about `along` x.
fn sway(path: &Path, mesh: MeshData, along: f32) {
    let header = Header { kind: Kind::Pair, meshes: vec![mesh], objects: vec![0, 0], frames: 64 };
    let mut to = WorkloadWriter::new(BufWriter::new(File::create(path).unwrap()), &header).unwrap();
    for frame in 0..header.frames {
        let x = along * (1.0 + 0.1 * (0.1 * frame as f32).sin());
        let poses = [Pose::IDENTITY, Pose::from_translation([x, 0.0, 0.0])];
        to.frame(Frame::Poses(&poses)).unwrap();
    }
    finish(to, path);
}

/// A mesh whose vertices move.
fn deform(path: &Path, mesh: &MeshData, frames: &[&[[f32; 3]]]) {
    let header = Header {
        kind: Kind::SelfMesh,
        meshes: vec![mesh.clone()],
        objects: vec![0],
        frames: frames.len() as u32,
    };
    let mut to = WorkloadWriter::new(BufWriter::new(File::create(path).unwrap()), &header).unwrap();
    frames.iter().for_each(|positions| to.frame(Frame::Positions(positions)).unwrap());
    finish(to, path);
}

fn finish(to: WorkloadWriter<BufWriter<File>>, path: &Path) {
    to.finish().into_inner().unwrap();
    println!("{}", path.display());
}

/// Every triangle in four, through the midpoints of its edges.
struct Divided {
    /// The ends of the edge that each new vertex halves.
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Divided {
    fn new(mesh: &MeshData) -> Self {
        let (mut edges, mut numbers) = (Vec::new(), HashMap::new());
        let mut middle = |a: u32, b: u32| {
            let edge = [a.min(b), a.max(b)];
            *numbers.entry(edge).or_insert_with(|| {
                edges.push(edge);
                (mesh.positions.len() + edges.len() - 1) as u32
            })
        };
        let four = |&[a, b, c]: &[u32; 3]| {
            let [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
        };
        let triangles = mesh.triangles.iter().flat_map(four).collect();
        Self { edges, triangles }
    }

    fn positions(&self, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let middle = |edge: &[u32; 2]| {
            let [p, q] = edge.map(|vertex| positions[vertex as usize]);
            [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]))
        };
        positions.iter().copied().chain(self.edges.iter().map(middle)).collect()
    }

    fn mesh(&self, mesh: &MeshData) -> MeshData {
        MeshData { positions: self.positions(&mesh.positions), triangles: self.triangles.clone() }
    }
}
