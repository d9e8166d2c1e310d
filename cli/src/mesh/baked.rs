//! Baked meshes: blobs of a mesh and its BVH, see [`pfront::pfront_core::blob`].

use super::error::Fault;
use pfront::Model;
use pfront_testkit::MeshData;

/// The mesh with its BVH.
pub(super) fn model(bytes: &[u8]) -> Result<Model, Fault> {
    let model = Model::from_blob(bytes).map_err(|error| Fault::broken(error.to_string()))?;
    if model.mesh().triangles().is_empty() { Err(Fault::no_triangle()) } else { Ok(model) }
}

/// The mesh without its BVH.
pub(super) fn mesh_data(model: &Model) -> MeshData {
    let mesh = model.mesh();
    MeshData { positions: mesh.positions().to_vec(), triangles: mesh.triangles().to_vec() }
}
