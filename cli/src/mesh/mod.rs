//! Triangle meshes from files, and painted ones to look at.
//!
//! All readers keep the order of the file. A face of n corners becomes n − 2 triangles, so that triangles have the numbers of
//! the file's faces where all of these are triangles, and count on through the other faces where not. Coordinates are the nearest f64 to
//! what is written, or the nearest f32 if that is asked for. A word that is not a number is refused; NaN is one, and left to
//! [`pfront::Model::new`], which names the vertex.

mod baked;
mod budget;
mod error;
mod file_mesh;
mod folder;
mod format;
mod gltf;
mod head;
mod import;
mod obj;
mod off;
mod painted;
mod ply;
mod source;
mod stl;
mod text;
mod triangulate;

pub use error::ReadError;
pub use file_mesh::{FileMesh, beyond_f32, in_f32};
pub use format::FORMATS;
pub use painted::{PaintedMesh, write_painted};
pub use source::{Source, name_apart};

use crate::memory::available;
use budget::Budget;
use error::Fault;
use folder::Folder;
use format::BAKED;
use import::Import;
use pfront::Model;
use pfront::pfront_core::blob::MAGIC;
use pfront_testkit::MeshData;
use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;

/// How meshes are read.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ReadOptions {
    /// Format of a mesh whose name does not tell, as that of standard input [default: by how it begins]
    #[arg(long, value_name = "FORMAT", value_parser = FORMATS)]
    pub input_format: Option<String>,
    /// MB that a mesh may take while it is read, and as many again for baking it or for an answer [default: reading: 16
    /// times the file and 64 MB, baking and answer: what is free]
    #[arg(long, value_name = "MB", value_parser = megabytes)]
    pub memory: Option<usize>,
    /// Round coordinates to f32, and compute poses there: faster, and what graphics do [default: in f64, as written]
    #[arg(long = "f32")]
    pub in_f32: bool,
    /// Read files that a glTF names outside its own folder too [default: refused, since it may name any file]
    #[arg(long)]
    pub allow_outside_files: bool,
}

fn megabytes(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok().and_then(|number| number.checked_mul(1_000_000));
    number.ok_or_else(|| "not a number of MB".to_owned())
}

/// The most bytes of something that is not a regular file, unless more are asked for.
const MOST_STREAMED: usize = 1 << 30;

/// The contents of a mesh file.
#[derive(Debug)]
pub enum Loaded {
    /// A mesh, of which nothing is checked, and where it comes from.
    Mesh(FileMesh, Source),
    /// A baked mesh, with its BVH.
    Baked(Box<Model>),
}

impl Loaded {
    /// The mesh, without its BVH, and where it comes from.
    pub fn into_mesh(self) -> (FileMesh, Source) {
        match self {
            Self::Mesh(mesh, source) => (mesh, source),
            Self::Baked(model) => (baked::mesh(&model), Source::default()),
        }
    }
}

/// Reads a mesh in f32; the extension tells the format, in whatever case, or else how the file begins, as it always does a
/// baked mesh. The path `-` is standard input.
///
/// An STL file has three vertices of its own for each triangle, see [`MeshData::welded`]. A glTF file has the
/// triangles of all meshes of the default scene, placed by their nodes, in the order of the nodes, children
/// after their parent; without skins and morphs. The size that a file states is not believed; but a glTF mesh is
/// read as often as nodes place it.
///
/// # Errors
/// [`ReadError`] names the file, and the line or what else is wrong; a file without a triangle is taken for
/// one that was not understood.
pub fn read(path: &Path) -> Result<MeshData, ReadError> {
    let options = ReadOptions { in_f32: true, ..ReadOptions::default() };
    load(path, &options).map(|loaded| in_f32(loaded.into_mesh().0))
}

/// [`read`] in f64 unless the options say otherwise, which keeps the BVH of a baked mesh.
///
/// # Errors
/// As [`read`].
pub fn load(path: &Path, options: &ReadOptions) -> Result<Loaded, ReadError> {
    let loaded = if path == Path::new("-") {
        load_from(stdin().lock(), None, path, options)
    } else {
        File::open(path).map_err(Fault::from).and_then(|file| {
            let found = file.metadata()?;
            load_from(file, found.is_file().then_some(found.len()), path, options)
        })
    };
    loaded.map_err(|fault| fault.at(path))
}

/// Reads a mesh from a file whose length is known, or from a stream.
fn load_from(
    mut from: impl Read,
    found: Option<u64>,
    path: &Path,
    options: &ReadOptions,
) -> Result<Loaded, Fault> {
    let mut bytes = Vec::new();
    // A file that is no mesh is not read to its end, which may never come.
    from.by_ref().take(16).read_to_end(&mut bytes)?;
    if bytes.is_empty() {
        return Err(Fault::broken("is empty"));
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let named = FORMATS.into_iter().find(|&format| extension == format);
    let format = if bytes.starts_with(&MAGIC) {
        BAKED
    } else {
        let told = options.input_format.as_deref().or(named).or_else(|| head::beginning(&bytes));
        told.ok_or(Fault::UnknownFormat)?
    };
    from.by_ref().take(head::HEAD).read_to_end(&mut bytes)?;
    let due = head::length(format, &bytes, found)?;
    let free = || available().unwrap_or(usize::MAX);
    let most = options.memory.unwrap_or_else(|| match found {
        Some(_) => free(),
        None => MOST_STREAMED.min(free()),
    });
    let endless =
        || Fault::broken(format!("goes on after {most} bytes; --memory lets more be read"));
    if found.or(due).is_some_and(|length| length > most as u64) {
        return Err(endless());
    }
    if let Some(length) = found {
        let rest = (length as usize).saturating_sub(bytes.len()) + 1;
        bytes.try_reserve_exact(rest).map_err(|_| Fault::memory(most))?;
    }
    // One more than there should be.
    let length = due.unwrap_or(most as u64).saturating_add(1);
    from.take(length.saturating_sub(bytes.len() as u64)).read_to_end(&mut bytes)?;
    let read = bytes.len();
    match due {
        Some(due) if due != read as u64 => {
            return Err(head::other_length(format, due, read as u64));
        }
        None if read > most => return Err(endless()),
        _ => {}
    }
    let mut budget = Budget::new(options.memory, read);
    budget.take(read)?;
    if format == BAKED {
        // The model takes as much again.
        budget.check(read)?;
        return baked::model(&bytes).map(|model| Loaded::Baked(Box::new(model)));
    }
    let is_stream = path == Path::new("-");
    let folder = Folder {
        path: if is_stream { None } else { Some(path.parent().unwrap_or(Path::new(""))) },
        allows_outside: options.allow_outside_files,
    };
    let Import { mesh, source, .. } = parse(format, &bytes, &folder, budget, options.in_f32)?;
    Ok(Loaded::Mesh(mesh, source))
}

/// For fuzzing: [`read`] of bytes in one of [`FORMATS`], without files beside.
#[doc(hidden)]
pub fn read_bytes(format: &str, bytes: &[u8]) -> Option<MeshData> {
    head::length(format, bytes, Some(bytes.len() as u64)).ok()?;
    let folder = Folder { path: None, allows_outside: false };
    let import = parse(format, bytes, &folder, Budget::new(None, bytes.len()), true).ok()?;
    Some(in_f32(import.mesh))
}

fn parse(
    format: &str,
    bytes: &[u8],
    folder: &Folder<'_>,
    budget: Budget,
    in_f32: bool,
) -> Result<Import, Fault> {
    let mut import = Import { budget, ..Import::default() };
    import.source.in_f32 = in_f32;
    match format {
        "obj" => obj::parse(bytes, &mut import),
        "ply" => ply::parse(bytes, &mut import),
        "stl" => stl::parse(bytes, &mut import),
        "off" => off::parse(bytes, &mut import),
        BAKED => baked::model(bytes).map(|model| import.mesh = baked::mesh(&model)),
        _ => gltf::parse(bytes, folder, &mut import),
    }?;
    if import.mesh.triangles.is_empty() {
        return Err(Fault::no_triangle());
    }
    import.triangulate_faces()?;
    Ok(import)
}
