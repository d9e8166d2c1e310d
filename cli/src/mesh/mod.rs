//! Triangle meshes from files, and painted ones to look at.
//!
//! All readers keep the order of the file. A face of more than three corners becomes a fan of triangles around
//! its first, so that triangles have the numbers of the file's faces where all of these are triangles,
//! and count on through the fans where not. Coordinates are the nearest f32 to
//! what is written. What is no number is refused; NaN is one, and left to [`pfront::Model::new`], which
//! names the vertex.

mod baked;
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
use pfront::Model;
use pfront::core::blob::MAGIC;
use std::collections::HashMap;
use std::path::Path;

/// The extensions that [`read`] knows.
pub const FORMATS: [&str; 7] = ["obj", "ply", "stl", "off", "gltf", "glb", BAKED];

/// The extension of what `pfront bake` writes.
const BAKED: &str = "pfb";

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
        // An index out of range is for [`pfront::Model::new`] to name.
        if self.triangles.iter().flatten().any(|&v| v as usize >= self.positions.len()) {
            return self;
        }
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
        let triangles = self.triangles.into_iter().map(|t| t.map(|v| joined[v as usize]));
        Self { triangles: triangles.collect(), positions }
    }

    /// Adds a polygon as a fan.
    fn push_fan(&mut self, corners: &[u32]) {
        let [first, rest @ ..] = corners else { return };
        self.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    }
}

/// What was in a mesh file.
#[derive(Debug)]
pub enum Loaded {
    /// A mesh, of which nothing is checked.
    Mesh(MeshData),
    /// A baked mesh, with its BVH.
    Baked(Box<Model>),
}

impl From<Loaded> for MeshData {
    fn from(loaded: Loaded) -> Self {
        match loaded {
            Loaded::Mesh(mesh) => mesh,
            Loaded::Baked(model) => (*model).into(),
        }
    }
}

/// Reads a mesh; the extension tells the format, in whatever case. A baked one is known by how it begins.
///
/// An STL file has three vertices of its own for each triangle, see [`MeshData::welded`]. Of glTF these
/// are the triangles of all meshes of the default scene, placed by their nodes, in the order of the nodes,
/// children after their parent; without skins and morphs. What a file says of its size is not believed;
/// but a glTF mesh is read as often as nodes place it.
///
/// # Errors
/// [`ReadError`] names the file, and the line or what else is wrong; a file without a triangle is taken for
/// one that was not understood.
pub fn read(path: &Path) -> Result<MeshData, ReadError> {
    load(path).map(MeshData::from)
}

/// [`read`] that keeps the BVH of a baked mesh.
///
/// # Errors
/// As [`read`].
pub fn load(path: &Path) -> Result<Loaded, ReadError> {
    let bytes = std::fs::read(path).map_err(|error| Fault::from(error).at(path))?;
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let named = FORMATS.into_iter().find(|&format| extension == format);
    let format = if bytes.starts_with(&MAGIC) { Some(BAKED) } else { named };
    let format = format.ok_or_else(|| Fault::UnknownFormat.at(path))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let loaded = match format {
        BAKED => baked::model(&bytes).map(|model| Loaded::Baked(Box::new(model))),
        _ => parse(format, &bytes, folder).map(Loaded::Mesh),
    };
    loaded.map_err(|fault| fault.at(path))
}

/// For fuzzing: [`read`] of bytes in one of [`FORMATS`], without files beside.
#[doc(hidden)]
pub fn read_bytes(format: &str, bytes: &[u8]) -> Option<MeshData> {
    parse(format, bytes, Path::new("/nowhere")).ok()
}

fn parse(format: &str, bytes: &[u8], folder: &Path) -> Result<MeshData, Fault> {
    let mesh = match format {
        "obj" => obj::parse(bytes),
        "ply" => ply::parse(bytes),
        "stl" => stl::parse(bytes),
        "off" => off::parse(bytes),
        BAKED => baked::parse(bytes),
        _ => gltf::parse(bytes, folder),
    }?;
    if mesh.triangles.is_empty() {
        return Err(Fault::no_triangle());
    }
    Ok(mesh)
}
