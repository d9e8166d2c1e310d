//! A mesh as a file has it: in f64.

use pfront_testkit::MeshData;

/// A mesh as a file has it.
pub type FileMesh = MeshData<[f64; 3]>;

/// How many coordinates of a mesh no f32 is equal to. If there is none, it may as well be one in f32.
pub fn beyond_f32(mesh: &FileMesh) -> usize {
    let is_beyond = |x: &&f64| !x.is_nan() && f64::from(**x as f32).to_bits() != x.to_bits();
    mesh.positions.as_flattened().iter().filter(is_beyond).count()
}

/// A mesh with the f32 nearest to each coordinate.
pub fn in_f32(mesh: FileMesh) -> MeshData {
    let positions = mesh.positions.iter().map(|p| p.map(|x| x as f32)).collect();
    MeshData { positions, triangles: mesh.triangles }
}
