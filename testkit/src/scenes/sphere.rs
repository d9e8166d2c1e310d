//! The icosphere: an icosahedron whose faces are cut into f² triangles and pushed out to radius 1.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::MeshData;

use super::mesh::round;

/// The unit sphere in about `triangles` triangles: 20 f² of them, f ≥ 1 being whole.
pub fn icosphere(triangles: usize) -> MeshData {
    let f = ((triangles as f64 / 20.0).sqrt().round() as u32).max(1);
    let mut sphere = Builder { f, vertex: BTreeMap::new(), mesh: MeshData::default() };
    for face in FACES {
        // Lattice point (i, j) of a face has the weights f − i − j, i, j at its corners.
        for i in 0..f {
            for j in 0..f - i {
                let [a, b, c] = [(i, j), (i + 1, j), (i, j + 1)].map(|p| sphere.vertex(face, p));
                sphere.mesh.triangles.push([a, b, c]);
                if i + j + 2 <= f {
                    let d = sphere.vertex(face, (i + 1, j + 1));
                    sphere.mesh.triangles.push([b, d, c]);
                }
            }
        }
    }
    sphere.mesh
}

/// A lattice point as the corners of the icosahedron it lies between and their weights, in order
/// of corner and without zero weights: neighbouring faces name a shared point alike.
type LatticePoint = [Option<(usize, u32)>; 3];

struct Builder {
    f: u32,
    vertex: BTreeMap<LatticePoint, u32>,
    mesh: MeshData,
}

impl Builder {
    fn vertex(&mut self, face: [usize; 3], (i, j): (u32, u32)) -> u32 {
        let weights = [self.f - i - j, i, j];
        let mut point: LatticePoint =
            [0, 1, 2].map(|k| (weights[k] > 0).then_some((face[k], weights[k])));
        point.sort_unstable();
        *self.vertex.entry(point).or_insert_with(|| {
            let terms = point.iter().flatten().map(|&(k, w)| corner(k) * f64::from(w));
            self.mesh.positions.push(round(terms.sum::<DVec3>().normalize()));
            self.mesh.positions.len() as u32 - 1
        })
    }
}

/// Corner `k` of the icosahedron: a cyclic permutation of (0, ±1, ±golden ratio).
fn corner(k: usize) -> DVec3 {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let one = if k & 1 == 0 { 1.0 } else { -1.0 };
    let long = if k & 2 == 0 { golden } else { -golden };
    match k / 4 {
        0 => DVec3::new(0.0, one, long),
        1 => DVec3::new(one, long, 0.0),
        _ => DVec3::new(long, 0.0, one),
    }
}

/// The icosahedron's faces, counter-clockwise from outside.
const FACES: [[usize; 3]; 20] = [
    [0, 1, 8],
    [0, 10, 1],
    [0, 4, 5],
    [0, 8, 4],
    [0, 5, 10],
    [1, 7, 6],
    [1, 6, 8],
    [1, 10, 7],
    [2, 9, 3],
    [2, 3, 11],
    [2, 5, 4],
    [2, 4, 9],
    [2, 11, 5],
    [3, 6, 7],
    [3, 9, 6],
    [3, 7, 11],
    [4, 8, 9],
    [5, 11, 10],
    [6, 9, 8],
    [7, 10, 11],
];
