//! Baked meshes: blobs of a mesh and its BVH, see [`pfront_blob`].

use crate::error::Fault;
use crate::import::Import;
use crate::mesh::TriangleMesh;
use pfront_blob::{Blob, BlobError, BlobStorage};
use pfront_core::Node;

impl From<BlobError> for Fault {
    fn from(error: BlobError) -> Self {
        Self::broken(error.to_string())
    }
}

/// Checks the header of a blob, and that it has triangles; returns whether it is in f64.
pub(crate) fn is_f64(bytes: &[u8]) -> Result<bool, Fault> {
    let counts = Blob::new(bytes)?.counts();
    if counts.triangles == 0 {
        Err(Fault::no_triangle(0, &[]))
    } else {
        Ok(counts.positions_f64 > 0)
    }
}

/// Reads the mesh of a blob without its BVH.
pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    import.mesh = mesh(bytes)?;
    for position in &mut import.mesh.positions {
        *position = import.source.rounded(*position);
    }
    Ok(())
}

/// The mesh of a blob without its BVH.
pub(crate) fn mesh(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let blob = Blob::new(bytes)?;
    let counts = blob.counts();
    let (mut nodes, mut order) = (vec![Node::EMPTY; counts.nodes], vec![0; counts.triangles]);
    let mut shadow = vec![[0.0; 3]; counts.vertices];
    let mut triangles = vec![[0; 3]; counts.triangles];
    let mut positions = vec![[0.0; 3]; counts.positions_f64];
    let mut scratch = vec![0; counts.triangles.div_ceil(32)];
    let storage = BlobStorage {
        nodes: &mut nodes,
        positions: &mut shadow,
        triangles: &mut triangles,
        order: &mut order,
    };
    let mesh = blob.read_into_f64(storage, &mut positions, &mut scratch)?.mesh();
    let positions = match mesh.positions_f64() {
        Some(positions) => positions.to_vec(),
        None => mesh.shadow().iter().map(|p| p.map(f64::from)).collect(),
    };
    Ok(TriangleMesh { positions, triangles: mesh.triangles().to_vec() })
}
