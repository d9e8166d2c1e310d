//! One entry for all formats: which one a file has, how much of it is read, and into how much memory.

use crate::baked;
use crate::budget::Budget;
use crate::error::{Fault, ReadError, Remedy};
use crate::folder::Folder;
use crate::format::{BAKED, FORMATS};
use crate::import::Import;
use crate::memory::available;
use crate::mesh::TriangleMesh;
use crate::source::Source;
use crate::{gltf, head, obj, off, ply, stl, text, threemf};
use pfront_blob::MAGIC;
use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;

/// How meshes are read.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The format, one of [`FORMATS`], of a file whose name does not tell; by default it is told by how the file begins.
    pub format: Option<String>,
    /// Bytes that a mesh may take while it is read; by default 16 for each of the file, and 64 MiB.
    pub memory: Option<usize>,
    /// Whether coordinates are rounded to f32.
    pub in_f32: bool,
    /// Whether files are read that a glTF names outside its own folder: it may name any.
    pub allow_outside_files: bool,
    /// The vertices that become one.
    pub weld: Weld,
}

/// The vertices that become one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weld {
    /// Vertices at exactly the same place, in formats that split vertices: STL, glTF, 3MF, and OBJ whose faces have normals
    /// or texture coordinates.
    #[default]
    Split,
    /// None: each is the one that the file numbers.
    Never,
    /// Vertices within a distance of the first of them, in every format.
    Within(f64),
}

/// The most bytes of something that is not a regular file, unless more are asked for.
const MOST_STREAMED: usize = 1 << 30;

/// Begins some texts in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The contents of a mesh file.
#[derive(Debug)]
pub enum Contents {
    /// A mesh.
    Mesh(MeshFile),
    /// The bytes of a baked mesh with its BVH, of which the header is checked: see [`pfront_blob`].
    Baked(Vec<u8>),
}

/// A mesh as a file has it.
#[derive(Clone, Debug, Default)]
pub struct MeshFile {
    /// All triangles of the file, in its order.
    pub mesh: TriangleMesh,
    /// Where in the file they come from.
    pub source: Source,
    /// Lines about what was passed over or rounded.
    pub notes: Vec<String>,
}

impl Contents {
    /// The mesh, without the BVH of one that is baked.
    ///
    /// # Errors
    /// If a baked mesh has changed since it was written; the error names `path`.
    pub fn into_mesh(self, path: &Path) -> Result<MeshFile, ReadError> {
        match self {
            Self::Mesh(file) => Ok(file),
            Self::Baked(bytes) => {
                let mesh = baked::mesh(&bytes).map_err(|fault| fault.at(path))?;
                Ok(MeshFile { mesh, ..MeshFile::default() })
            }
        }
    }
}

/// Reads a file. The extension tells the format, in whatever case, or else how the file begins, as it always does a baked
/// mesh. The path `-` is standard input.
///
/// # Errors
/// [`ReadError`] names the file, and the line or what else is wrong; a file without a triangle is taken for one that was
/// not understood.
///
/// # Complexity
/// O(bytes) for all but polygons of n corners, which take O(n log n) where they are not made to be slow.
///
/// # Examples
/// ```
/// use pfront_files::{Contents, ReadOptions, open};
/// let path = std::env::temp_dir().join("pfront-files-square.obj");
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")?;
/// let Contents::Mesh(file) = open(&path, &ReadOptions::default())? else { panic!("baked") };
/// assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
/// assert!(file.notes.is_empty());
/// # std::fs::remove_file(path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn open(path: &Path, options: &ReadOptions) -> Result<Contents, ReadError> {
    let loaded = if path == Path::new("-") {
        load(stdin().lock(), None, path, options)
    } else {
        File::open(path).map_err(Fault::from).and_then(|file| {
            let found = file.metadata()?;
            load(file, found.is_file().then_some(found.len()), path, options)
        })
    };
    loaded.map_err(|fault| fault.at(path))
}

/// The mesh of a file in f32, without what [`open`] tells beside.
///
/// # Errors
/// As [`open`].
///
/// # Complexity
/// As [`open`].
///
/// # Examples
/// ```
/// let error = pfront_files::read_f32("no/such/file.obj".as_ref()).unwrap_err();
/// assert_eq!(error.to_string(), "cannot read no/such/file.obj");
/// ```
pub fn read_f32(path: &Path) -> Result<TriangleMesh<f32>, ReadError> {
    let options = ReadOptions { in_f32: true, ..ReadOptions::default() };
    open(path, &options)?.into_mesh(path).map(|file| file.mesh.into_f32())
}

/// [`open`] for the bytes of a file that names no others; [`ReadOptions::format`] tells the format, or else how they begin.
///
/// # Errors
/// As [`open`], with `bytes` in place of a name.
///
/// # Complexity
/// As [`open`].
///
/// # Examples
/// ```
/// use pfront_files::{ReadOptions, read_bytes};
/// let error = read_bytes(b"OFF\n3 1 0\n0 0 0\n1 0 0\n", &ReadOptions::default()).unwrap_err();
/// assert_eq!(error.to_string(), "bytes: the file ends before its last vertex");
/// ```
pub fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<Contents, ReadError> {
    let path = Path::new("bytes");
    load(bytes, Some(bytes.len() as u64), path, options).map_err(|fault| fault.at(path))
}

/// Reads a mesh from a file whose length is known, or from a stream.
fn load(
    mut from: impl Read,
    mut found: Option<u64>,
    path: &Path,
    options: &ReadOptions,
) -> Result<Contents, Fault> {
    let free = || available().unwrap_or(usize::MAX);
    let most = options.memory.unwrap_or_else(|| match found {
        Some(_) => free(),
        None => MOST_STREAMED.min(free()),
    });
    let mut bytes = Vec::new();
    // A file that is no mesh is not read to its end, which may never come.
    from.by_ref().take(16).read_to_end(&mut bytes)?;
    if bytes.is_empty() {
        return Err(Fault::broken("is empty"));
    }
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
        found = found.map(|found| found - BYTE_ORDER_MARK.len() as u64);
    }
    if let Some(is_big) = text::utf16(&bytes) {
        read_rest(from, found, most, None, &mut bytes)?;
        let contents = text::from_utf16(bytes, is_big)?;
        let mut contents = load(contents.as_bytes(), Some(contents.len() as u64), path, options)?;
        if let Contents::Mesh(file) = &mut contents {
            file.notes.push("the text is in UTF-16".to_owned());
        }
        return Ok(contents);
    }
    let format = format(&bytes, path, options)?;
    from.by_ref().take(head::HEAD).read_to_end(&mut bytes)?;
    let due = head::length(format, &bytes, found)?;
    read_rest(from, found, most, due, &mut bytes)?;
    let read = bytes.len();
    let mut notes = Vec::new();
    if let Some(due) = due.filter(|&due| due != read as u64) {
        if due > read as u64 || format == BAKED {
            return Err(head::other_length(format, due, read as u64));
        }
        bytes.truncate(due as usize);
        notes.push(format!("what follows the {due} bytes of the header is passed over"));
    }
    let mut budget = Budget::new(options.memory, read);
    budget.take(read)?;
    if format == BAKED {
        // The model takes as much again.
        budget.check(read)?;
        let is_rounded = baked::is_f64(&bytes)? && options.in_f32;
        if !is_rounded && !matches!(options.weld, Weld::Within(_)) {
            return Ok(Contents::Baked(bytes));
        }
    }
    let is_alone = path == Path::new("-") || path == Path::new("bytes");
    let folder = Folder {
        path: if is_alone { None } else { Some(path.parent().unwrap_or(Path::new(""))) },
        allows_outside: options.allow_outside_files,
    };
    let mut import = Import::new(budget, notes, options.in_f32);
    match format {
        "obj" => obj::parse(&bytes, &mut import),
        "ply" => ply::parse(&bytes, &mut import),
        "stl" => stl::parse(&bytes, &mut import),
        "off" => off::parse(&bytes, &mut import),
        "3mf" => threemf::parse(&bytes, &mut import),
        BAKED => baked::parse(&bytes, &mut import),
        _ => gltf::parse(&bytes, &folder, &mut import),
    }?;
    import.finish()?;
    match options.weld {
        Weld::Split if import.is_split => import.mesh.weld(),
        Weld::Split | Weld::Never => {}
        Weld::Within(distance) => {
            import.budget.check(JOINED.saturating_mul(import.mesh.positions.len()))?;
            let moved = import.mesh.weld_within(distance);
            import.note("vertices that were joined with others nearby", moved);
        }
    }
    let Import { mesh, source, notes, .. } = import;
    Ok(Contents::Mesh(MeshFile { mesh, source, notes }))
}

/// The format that a file begins like, or else has by its options, its name or its first bytes.
fn format(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<&'static str, Fault> {
    let known = || FORMATS.join(", ");
    let find = |name: &str| FORMATS.into_iter().find(|format| name == *format);
    if bytes.starts_with(&MAGIC) {
        return Ok(BAKED);
    }
    if let Some(name) = &options.format {
        let unknown = || Fault::broken(format!("'{name}' is no format; known are {}", known()));
        return find(name).ok_or_else(unknown);
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let told = extension.to_str().and_then(find).or_else(|| head::beginning(bytes));
    told.ok_or_else(|| {
        Fault::broken(format!("unknown format; known are {}", known())).or(Remedy::Format)
    })
}

/// Reads what follows the first bytes of a file, and one byte more than there should be, if there is one.
fn read_rest(
    from: impl Read,
    found: Option<u64>,
    most: usize,
    due: Option<u64>,
    bytes: &mut Vec<u8>,
) -> Result<(), Fault> {
    let endless = || Fault::broken(format!("goes on after {most} bytes")).or(Remedy::Memory);
    if found.or(due).is_some_and(|length| length > most as u64) {
        return Err(endless());
    }
    if let Some(length) = found {
        let rest = (length as usize).saturating_sub(bytes.len()) + 1;
        bytes.try_reserve_exact(rest).map_err(|_| Fault::memory(most))?;
    }
    let length = due.unwrap_or(most as u64).saturating_add(1);
    from.take(length.saturating_sub(bytes.len() as u64)).read_to_end(bytes)?;
    if due.is_none() && bytes.len() > most { Err(endless()) } else { Ok(()) }
}

/// Bytes for each vertex that is joined with others nearby: a cell of its own with a list, at most.
const JOINED: usize = 256;
