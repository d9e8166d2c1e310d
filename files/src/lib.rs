//! Mesh files: OBJ, PLY, STL, OFF, glTF, GLB and 3MF, and the blobs of [`pfront_blob`] in; PLY and OBJ out.
//!
//! [`open`] reads a file, [`read_bytes`] its bytes. The result is one mesh and the bodies that it consists of, with notes
//! of what was passed over. All readers keep the order of the file. A face of n corners becomes n − 2 triangles, so that
//! triangles have the numbers of the file's faces where all of these are triangles, and count on through the other faces
//! where not. Coordinates are the nearest f64 to what is written, or the nearest f32 if that is asked for; glTF and 3MF place
//! them in f64 first. They are in the unit of the file: a 3MF in another than millimeters has a note of its unit, and is not
//! converted.
//!
//! Nothing in a file is believed: sizes that it states reserve no memory, and what it takes is bounded, see
//! [`ReadOptions::memory`].

mod baked;
mod budget;
mod error;
pub mod escape;
mod folder;
mod format;
mod gltf;
mod head;
mod import;
mod memory;
mod mesh;
mod obj;
mod off;
mod painted;
mod ply;
mod read;
mod source;
mod stl;
mod text;
mod threemf;
mod triangulate;

pub use error::{ReadError, Remedy};
pub use format::FORMATS;
pub use memory::available;
pub use mesh::TriangleMesh;
pub use painted::{PaintedMesh, write_painted, write_polylines};
pub use read::{Contents, MeshFile, ReadOptions, Weld, open, read_bytes, read_f32};
pub use source::{Source, name_apart};
