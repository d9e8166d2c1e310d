//! Baked meshes: blobs of a mesh and its BVH, see [`pfront::pfront_core::blob`].

use super::error::Fault;
use super::file_mesh::FileMesh;
use pfront::Model;

/// The mesh with its BVH.
pub(super) fn model(bytes: &[u8]) -> Result<Model, Fault> {
    let model = Model::from_blob(bytes).map_err(|error| Fault::broken(error.to_string()))?;
    if model.mesh().triangles().is_empty() { Err(Fault::no_triangle()) } else { Ok(model) }
}

/// The mesh without its BVH.
pub(super) fn mesh(model: &Model) -> FileMesh {
    let mesh = model.mesh();
    let positions = match mesh.positions_f64() {
        Some(positions) => positions.to_vec(),
        None => mesh.shadow().iter().map(|p| p.map(f64::from)).collect(),
    };
    FileMesh { positions, triangles: mesh.triangles().to_vec() }
}
