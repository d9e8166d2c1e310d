//! Triangle meshes from files, and painted ones to look at.
//!
//! All readers keep the order of the file, so that the numbers of an answer are those of the file's
//! vertices and faces; a polygon becomes a fan around its first corner. Coordinates are the nearest f32 to
//! what is written. What is no number is refused; NaN is one, and left to [`pfront::Model::new`], which
//! names the vertex.

mod error;
mod gltf;
mod obj;
mod off;
mod painted;
mod ply;
mod stl;
mod text;

pub use error::ReadError;
pub use painted::{PaintedMesh, write_painted};

use error::Fault;
use std::collections::HashMap;
use std::path::Path;

/// The extensions that [`read`] knows.
pub const FORMATS: [&str; 6] = ["obj", "ply", "stl", "off", "gltf", "glb"];

/// A mesh as its file has it: neither coordinates nor indices are checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl MeshData {
    /// The same with vertices at exactly the same place joined, where −0 is 0; each stays where it first
    /// appears. Triangles keep their numbers.
    ///
    /// # Examples
    /// ```
    /// use pfront_cli::mesh::MeshData;
    /// let positions = vec![[0.0; 3], [1.0; 3], [2.0; 3], [-0.0; 3], [1.0; 3], [3.0; 3]];
    /// let mesh = MeshData { positions, triangles: vec![[0, 1, 2], [3, 4, 5]] }.welded();
    /// assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
    /// ```
    #[must_use]
    pub fn welded(self) -> Self {
        let mut seen = HashMap::with_capacity(self.positions.len());
        let mut positions = Vec::new();
        let mut join = |p: [f32; 3]| {
            // −0 + 0 is 0.
            *seen.entry(p.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        };
        let joined: Vec<u32> = self.positions.into_iter().map(&mut join).collect();
        // An index out of range stays out of range.
        let of = |v: u32| joined.get(v as usize).copied().unwrap_or(u32::MAX);
        Self { triangles: self.triangles.into_iter().map(|t| t.map(of)).collect(), positions }
    }

    /// Adds a polygon as a fan.
    fn push_fan(&mut self, corners: &[u32]) {
        let [first, rest @ ..] = corners else { return };
        self.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    }
}

/// Reads a mesh; the extension tells the format.
///
/// # Errors
/// [`ReadError`] names the file, and the line or what else is wrong.
pub fn read(path: &Path) -> Result<MeshData, ReadError> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let parse: fn(&[u8], &Path) -> Result<MeshData, Fault> = match extension.to_str() {
        Some("obj") => |bytes, _| obj::parse(bytes),
        Some("ply") => |bytes, _| ply::parse(bytes),
        Some("stl") => |bytes, _| stl::parse(bytes),
        Some("off") => |bytes, _| off::parse(bytes),
        Some("gltf" | "glb") => gltf::parse,
        _ => return Err(ReadError::UnknownFormat { path: path.to_owned() }),
    };
    let read = std::fs::read(path).map_err(Fault::from);
    read.and_then(|bytes| parse(&bytes, path)).map_err(|fault| fault.at(path))
}
